"""The workflow, small and whole: every rule, every figure, and what makes a job run again.

It runs once in a copy of the checkout; most tests then look at what it made, or edit a module or config and ask which jobs would run again.
"""

import filecmp
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pandas as pd
import pytest
from PIL import Image

from tests.checkouts import (
    RESULTS,
    ROOT,
    SMOKE,
    UNREPEATABLE,
    copy_checkout,
    edited,
    jobs,
    planned,
    snakemake,
)

NEARLY_WHITE = 250  # of 255
LEAST_INK = 0.01  # share of the pixels; axes and labels alone have more
WITHOUT_A_PLOT = {"parameters_baseline-raise"}
"""Figures that only say, in words, that there is nothing to plot: here, no fit of the small run gave standard errors."""


@pytest.fixture(scope="module")
def built(tmp_path_factory) -> tuple[Path, str]:
    """Return a checkout in which the small workflow ran, and what it printed."""
    folder = copy_checkout(tmp_path_factory.mktemp("checkout"))
    ran = snakemake(folder, *SMOKE)
    assert ran.returncode == 0, ran.stdout
    return folder, ran.stdout


def rules() -> set[str]:
    """Return the names of the rules that `snakemake` runs when no target is named, apart from those that only gather files."""
    run_only_by_name = (
        "measured",
        "blind_trials",
        "tracked_trials",
        "spoiled_setups",
        "coverage",
        "real_arm_trials",
        "processors",
        "sensitivity",
        "planning",
        "edges",
        "leaning_walls",
        "starts",
        "confidence",
        "aliases",
        "crate",
        "everything",
    )
    paths = [path for path in (ROOT / "workflow/rules").glob("*.smk") if path.stem not in run_only_by_name]
    text = "".join(path.read_text(encoding="utf-8") for path in paths)
    # These draw figures of the paper from committed summaries, though they stand in files of targets that run only by name.
    drawn_for_the_paper = {
        "draw_committed_blind_trials",
        "draw_committed_measured",
        "draw_committed_sensitivity",
        "draw_committed_confidence",
        "draw_committed_edges",
    }
    return set(re.findall(r"^rule (\w+):", text, re.MULTILINE)) - {"figures"} | drawn_for_the_paper


@pytest.mark.slow
def test_every_rule_runs(built):
    """The small config leaves no rule out, and every job has a log file of its own, if an empty one."""
    folder, output = built
    assert set(jobs(output)) == rules()
    assert len(list((folder / RESULTS / "logs").rglob("*.log"))) == sum(jobs(output).values())


@pytest.mark.slow
def test_every_figure_shows_something_whole(built):
    """Each PNG has ink in every third of its width and height and a clear margin, so that nothing is blank or cut off; each SVG parses."""
    folder, _ = built
    pngs = sorted((folder / RESULTS).rglob("figures/*.png"))
    assert len(pngs) >= 5
    for png in pngs:
        picture = np.asarray(Image.open(png).convert("RGB")).min(axis=2) < NEARLY_WHITE
        assert picture.any() and not picture.all(), png
        if png.stem != "scene":  # a rendered picture fills its frame
            edges = picture[0], picture[-1], picture[:, 0], picture[:, -1]
            assert not any(edge.any() for edge in edges), png
        boxes = [half.any() for half in (*np.array_split(picture, 3), *np.array_split(picture, 3, axis=1))]
        if png.stem not in WITHOUT_A_PLOT:
            assert picture.mean() > LEAST_INK and all(boxes), png
        ElementTree.parse(png.with_suffix(".svg"))


@pytest.mark.slow
def test_the_datasets_are_read_like_a_users(built):
    """The simulated datasets have the format of users' datasets, and the truth lies in another folder."""
    from scalar.data.dataset import read_dataset

    folder, _ = built
    seeds = sorted((folder / RESULTS / "headline/data/smoke").glob("seeds-*/seed-*"))
    assert len(seeds) == 3
    for seed in seeds:
        assert read_dataset(seed / "dataset").n_poses == 42
        assert {path.name for path in (seed / "truth").iterdir()} == {"truth.json", "truth_poses.csv"}


@pytest.mark.slow
def test_tables_hold_a_row_for_every_seed_method_and_alignment(built):
    """No row is lost between batches, and every column is explained."""
    from study.headline.evaluate import ERROR_COLUMNS, PARAMETER_COLUMNS, PLANE_COLUMNS

    folder, _ = built
    headline = folder / RESULTS / "headline"
    errors = pd.read_csv(headline / "errors.csv")
    assert list(errors.columns) == list(ERROR_COLUMNS)
    assert len(errors) == errors.groupby(["seed", "method", "alignment"]).ngroups == 3 * 5 * 2
    assert list(pd.read_csv(headline / "planes.csv").columns) == list(PLANE_COLUMNS)
    assert list(pd.read_csv(headline / "parameters.csv").columns) == list(PARAMETER_COLUMNS)


@pytest.mark.slow
def test_a_second_run_does_nothing(built):
    """After a run, no job is left to do."""
    folder, _ = built
    assert "Nothing to be done" in snakemake(folder, *SMOKE).stdout


@pytest.mark.slow
def test_the_report_holds_every_figure_with_its_caption(built):
    """`snakemake --report` writes one file; every caption that a rule names is there."""
    folder, _ = built
    ran = snakemake(folder, *SMOKE, "--report", "report.html")
    assert ran.returncode == 0, ran.stdout
    report = (folder / "report.html").read_text(encoding="utf-8")
    for category in ("Sweeps", "Published curves", "Paper"):
        assert category in report


@pytest.mark.slow
def test_figures_are_redrawn_from_tables_alone(built):
    """A figure that is gone comes back without a dataset, a fit or an evaluation."""
    folder, _ = built
    figure = folder / RESULTS / "headline/figures/errors.png"
    before = figure.read_bytes()
    figure.unlink()
    ran = snakemake(folder, "figures", *SMOKE)
    assert jobs(ran.stdout) == {"draw_errors": 1}, ran.stdout
    assert figure.read_bytes() == before


@pytest.mark.slow
@pytest.mark.parametrize(
    ("module", "reruns", "spares"),
    [
        (
            "workflow/study/plots/errors.py",
            {"draw_errors"},
            {"simulate", "calibrate", "evaluate", "draw_planes"},
        ),
        (
            "workflow/study/headline/evaluate.py",
            {"evaluate", "collect", "draw_errors"},
            {"simulate", "calibrate", "sweep"},
        ),
        ("workflow/study/common/bound.py", {"sweep", "collect_sweep"}, {"simulate", "calibrate", "evaluate"}),
        (
            "scalar/baseline/fit.py",
            {"calibrate", "evaluate", "collect", "draw_errors"},
            {"simulate", "tabulate_identifiability"},
        ),
        ("scalar/geometry/se3.py", {"calibrate", "tabulate_identifiability", "evaluate"}, set()),
        ("scalar/simulation/noise.py", {"simulate", "calibrate", "evaluate", "draw_errors"}, set()),
        ("scalar/simulation/schemas/scene.schema.json", {"simulate"}, set()),
    ],
)
def test_editing_a_module_reruns_what_depends_on_it(built, module, reruns, spares):
    """A change of a module reruns exactly the jobs that import it, however indirectly."""
    folder, _ = built
    old, new = ("\n}", "\n\n}") if module.endswith(".json") else ('"""', '"""Edited. ')
    with edited(folder / module, old, new):
        started = set(planned(folder))
    assert reruns <= started
    assert not spares & started
    assert planned(folder) == {}


@pytest.mark.slow
def test_the_modules_listed_are_those_that_are_imported(built):
    """The modules that are read from import statements are those that Python itself loads."""
    folder, _ = built
    ran = snakemake(folder, "--detailed-summary", *SMOKE)
    rows = [line.split("\t") for line in ran.stdout.splitlines() if line.count("\t") == 7]
    listed = {row[2]: set(row[4].split(",")) for row in rows}
    modules = {
        "simulate": "headline.simulate",
        "calibrate": "headline.calibrate",
        "evaluate": "headline.evaluate",
        "tabulate_identifiability": "headline.identifiability",
        "sweep": "sweeps.run",
    }
    own = {**os.environ, "PYTHONPATH": os.pathsep.join([str(folder), str(folder / "workflow")])}
    for rule, module in modules.items():
        code = (
            f"import sys, study.{module};"
            "print(*(m.__file__ for n, m in sorted(sys.modules.items()) if n.split('.')[0] in ('scalar', 'study')))"
        )
        loaded = subprocess.run(
            [sys.executable, "-c", code], cwd=folder, env=own, capture_output=True, text=True, check=True
        ).stdout.split()
        names = {str(Path(path).resolve().relative_to(folder.resolve())) for path in loaded}
        assert len(names) > 5
        assert names <= listed[rule], rule


@pytest.mark.slow
def test_a_row_more_in_a_grid_is_a_case_more(built):
    """Only the new case is simulated; the others stay."""
    folder, _ = built
    with edited(folder / "configs/grids/smoke.csv", "smoke,14", "more,15,20,300\nsmoke,14"):
        ran = snakemake(folder, "--dry-run", *SMOKE)
    started = jobs(ran.stdout)
    assert started["simulate"] == started["evaluate"] == 2  # one job a batch of seeds
    assert "results/smoke/headline/data/more/seeds-001-002" in ran.stdout
    assert "Simulating headline smoke" not in ran.stdout


@pytest.mark.slow
def test_a_row_more_in_a_sweeps_grid_is_a_case_more(built):
    """Only the new case runs, from the postures that are there, and the sweep's figure is drawn again."""
    folder, _ = built
    grid = folder / "configs/grids/smoke_noise.csv"
    with edited(grid, "sigma-0.1mm,", "more,2e-4,14,20,300\nsigma-0.1mm,"):
        started = planned(folder)
    assert {"sweep": 1, "collect_sweep": 1, "draw_sweep": 1, "summarise_sweeps": 1}.items() <= started.items()
    assert not {"plan_sweeps", "simulate", "calibrate"} & set(started)


SWEEP_AXES = """  axes:
    noise:"""
NEW_SWEEP = """  axes:
    plane_offset: {grid: configs/grids/new.csv, key: plane_guess.offset_m, label: "initial guesses of the planes off by [m]"}
    noise:"""


@pytest.mark.slow
def test_a_whole_sweep_is_added_by_a_grid_and_a_line_of_the_config(built):
    """Its cases run and its figures are drawn; of the sweeps that are there, only the summary of all is new."""
    folder, _ = built
    grid = folder / "configs/grids/new.csv"
    grid.write_text(
        "case,plane_guess.offset_m,poses_per_plane,truth_poses\nnear,0.001,14,300\nfar,0.05,14,300\n"
    )
    try:
        with edited(folder / "configs/smoke.yaml", SWEEP_AXES, NEW_SWEEP):
            started = planned(folder)
            assert {name: started[name] for name in ("sweep", "collect_sweep", "draw_sweep")} == {
                "sweep": 2,
                "collect_sweep": 1,
                "draw_sweep": 1,
            }
            assert not {"plan_sweeps", "simulate", "calibrate"} & set(started)
            ran = snakemake(folder, "results/smoke/sweeps/plane_offset/figures/upright.png", *SMOKE)
            assert ran.returncode == 0, ran.stdout
        summary = pd.read_csv(folder / RESULTS / "sweeps/plane_offset/summary.csv")
        assert set(summary["value"]) == {0.001, 0.05}
    finally:
        grid.unlink()
        shutil.rmtree(folder / RESULTS / "sweeps/plane_offset", ignore_errors=True)


@pytest.mark.slow
def test_the_same_seeds_give_the_same_bytes_on_one_core(built, tmp_path):
    """Tables, datasets and figures do not depend on how many jobs ran at once."""
    folder, _ = built
    again = copy_checkout(tmp_path / "again")
    ran = snakemake(again, *SMOKE, cores=1)
    assert ran.returncode == 0, ran.stdout
    files = [
        path.relative_to(folder / RESULTS)
        for path in (folder / RESULTS).rglob("*")
        if path.is_file() and path.name != ".snakemake_timestamp"
    ]
    files = [path for path in files if path.parts[0] not in UNREPEATABLE]
    _, different, missing = filecmp.cmpfiles(folder / RESULTS, again / RESULTS, files, shallow=False)
    assert len(files) > 30
    assert different == missing == []
    claims = [pd.read_csv(run / RESULTS / "claims/claims.csv") for run in (folder, again)]
    pd.testing.assert_frame_equal(*(table[table["claim"] != "duration"] for table in claims))
