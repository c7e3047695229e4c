"""What a config asks of the workflow, and what is refused before a job starts."""

import re
from pathlib import Path

import pandas as pd
import pytest

from scalar.data.io.plain_yaml import load_yaml
from tests.checkouts import ROOT, SMOKE, copy_checkout, edited, jobs, snakemake


@pytest.fixture(scope="module")
def checkout(tmp_path_factory) -> Path:
    """Return a checkout in which nothing ran."""
    return copy_checkout(tmp_path_factory.mktemp("fresh"))


def test_rule_files_hold_rules_only():
    """Functions that rules use stand in workflow/study, typed and tested, or in common.smk, which has no rule."""
    files = {path.name: path.read_text("utf-8") for path in (ROOT / "workflow/rules").glob("*.smk")}
    holding = {
        what: {name for name, text in files.items() if re.search(rf"^\s*{what} .+?:", text, re.MULTILINE)}
        for what in ("def", "rule")
    }
    assert holding["def"] == {"common.smk"}
    assert holding["rule"] == set(files) - {"common.smk"}


@pytest.mark.parametrize(
    ("file", "old", "new", "named"),
    [
        ("configs/smoke.yaml", "seeds_per_job:", "seeds_per_jop:", "seeds_per_jop"),
        ("configs/smoke.yaml", "    seeds:", "    seads:", "seads"),
        ("configs/smoke.yaml", "proposed", "manyfold", "manyfold"),
        ("configs/smoke.yaml", "first_seed: 1", "first_seed: one", "first_seed"),
        ("configs/smoke.yaml", "grids/smoke.csv", "grids/none.csv", "none.csv"),
        ("configs/grids/smoke.csv", "poses_per_plane", "poses_per_plain", "poses_per_plain"),
        ("configs/grids/smoke.csv", ",14,", ",fourteen,", "fourteen"),
    ],
)
def test_a_misspelt_config_fails_at_load_with_its_name(checkout, file, old, new, named):
    """A misspelt key is refused by its name before any job starts."""
    with edited(checkout / file, old, new):
        ran = snakemake(checkout, *SMOKE)
    assert ran.returncode != 0
    assert named in ran.stdout
    assert "Job stats" not in ran.stdout


@pytest.mark.slow
def test_the_papers_config_is_sound():
    """The config plans thirty seeds of the headline in every way, and every published value of every sweep for two kinds of walls."""
    ran = snakemake(ROOT, "--dry-run", "--forceall", "--quiet", "reason", "--nolock")
    assert ran.returncode == 0, ran.stdout
    started = jobs(ran.stdout)
    assert started["calibrate"] == 8
    assert started["draw_sweep"] == 2 * started["collect_sweep"]
    curves = pd.read_csv(ROOT / "workflow/resources/published_curves.csv")
    config = load_yaml(ROOT / "configs/paper.yaml")
    grids = {
        axis["published"]: axis["grid"] for axis in config["sweeps"]["axes"].values() if "published" in axis
    }
    for sweep, points in curves.groupby("sweep"):
        assert len(pd.read_csv(ROOT / grids[sweep])) >= len(points)
    cases = sum(len(pd.read_csv(ROOT / axis["grid"])) for axis in config["sweeps"]["axes"].values())
    assert cases / config["sweeps"]["cases_per_job"] <= started["sweep"] < cases


@pytest.mark.slow
@pytest.mark.parametrize(
    ("former", "present"),
    [
        ("closed_loop", "blind_trials"),
        ("foretell_first_loop", "predict_published_curves"),
        ("close_first_loop", "explain_published_curves"),
        pytest.param("draw_first_loop", "draw_published_curves", marks=pytest.mark.slow),
        pytest.param("example_floor", "example_control", marks=pytest.mark.slow),
        pytest.param("tell_example", "tabulate_example", marks=pytest.mark.slow),
    ],
)
def test_former_names_of_targets_still_work(former, present):
    """A target that is asked for by its former name is made by the rule of the present name."""
    wanted = [
        jobs(snakemake(ROOT, name, "--dry-run", "--forceall", "--quiet", "reason", "--nolock", *SMOKE).stdout)
        for name in (former, present)
    ]
    assert present in wanted[1]
    gathering = {former, "blind_trials", "total"}  # targets that make nothing themselves
    former_jobs, present_jobs = ({n: k for n, k in found.items() if n not in gathering} for found in wanted)
    assert former_jobs == present_jobs
