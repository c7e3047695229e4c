"""Leaning walls: the scene between the two that the sweeps have, the published settings as cases, and verdicts from fits."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from study.common.methods import CONVERGED, EVERY_METHOD
from study.common.statistics import QUANTITIES
from study.common.tables import read_table
from study.published_curves.candidates import MIN_FITS
from study.published_curves.leaning_support import _from_fits
from study.published_curves.leaning_walls import READINGS, all_runs, leaning, overrides
from study.published_curves.predict import runs_to_weigh

from scalar.simulation.config import load_config

ROOT = Path(__file__).parents[3]
SCENES = ROOT / "configs/scenes"
OPTIONS = {"leave_out": {"poses": [18]}}


@pytest.mark.parametrize(("lean", "scene"), [(0.0, "paper"), (3.0, "paper_tilted")])
def test_the_ends_are_the_scenes_of_the_sweeps(lean, scene):
    """Walls that do not lean give the upright scene, walls that lean by three degrees give the tilted one, and all else is the same."""
    turned = leaning(load_config(SCENES / "paper.yaml"), lean)
    wanted = load_config(SCENES / f"{scene}.yaml")
    for own, other in zip(turned["planes"], wanted["planes"], strict=True):
        assert own["normal"] == pytest.approx(other["normal"], abs=1e-12)
        assert {k: v for k, v in own.items() if k != "normal"} == {
            k: v for k, v in other.items() if k != "normal"
        }


def published():
    """Return the published curves, and the runs that are weighed with and without the one that is left out."""
    table = read_table(ROOT / "workflow/resources/published_curves.csv")
    config = load_config(SCENES / "paper.yaml")
    return all_runs(config, table, OPTIONS), runs_to_weigh(config, table, OPTIONS)


def test_the_run_that_is_left_out_is_the_only_further_one():
    """The only further run is that with 18 poses, whose case has six poses on each plane."""
    every, usual = published()
    assert len(every.settings) == len(usual.settings) + 1
    (further,) = set(every.settings) - set(usual.settings)
    assert overrides(further, 3)["poses_per_plane"] == 6


def fits(curves, failed: str) -> pd.DataFrame:
    """Return as many fits of every run and reading as are needed, those of one reading without an end."""
    rng = np.random.default_rng(7)
    rows = [
        {"lean_deg": 1.0, "sweep": run["sweep"], "value": run["value"], "seed": seed, "method": method}
        | {"status": "capped" if method == failed else CONVERGED, "alignment": "raw"}
        | dict(zip(QUANTITIES, np.exp(rng.standard_normal(4)), strict=True))
        for run in curves.table.to_dict("records")
        for seed in range(MIN_FITS)
        for method in READINGS
    ]
    return pd.DataFrame(rows)


def test_a_reading_is_weighed_only_where_its_fits_end():
    """Every reading has a prediction of every run, except the one whose fits did not converge."""
    _, usual = published()
    found = dict(_from_fits(fits(usual, "baseline-nan"), usual))
    assert set(found) == {(method, 1.0) for method in READINGS if method != "baseline-nan"}
    assert all(one.mean.shape == (1, len(usual.settings), 4) for one in found.values())


def test_every_reading_is_a_method():
    """Every reading that is fitted has the name of a method of the sweeps."""
    assert set(READINGS) <= set(EVERY_METHOD)
