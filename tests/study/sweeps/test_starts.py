"""Both methods from the start of either: the starts are what they are said to be, and fits that fail are counted."""

import numpy as np
import pandas as pd
import pytest
from study.common.grid import with_overrides
from study.common.in_memory import dataset_in_memory
from study.sweeps.plans import read_plans, write_plans
from study.sweeps.starts import (
    BASELINE,
    OTHER,
    OWN,
    PROPOSED,
    compare_starts,
    start_numbers,
    with_initial_planes,
)

from scalar.simulation.config import load_config
from scalar.simulation.scene import simulate

SCENE = "configs/scenes/paper.yaml"
SMALL = {"poses_per_plane": 14, "sensor.points_per_scan": 20, "truth_poses": 200}
FAR = {"plane_guess.tilt_deg": 25.0}


@pytest.fixture(scope="module")
def scene(request):
    """Return the config file of the scene."""
    return request.config.rootpath / SCENE


def test_the_other_start_of_the_baseline_has_planes_nearer_to_the_true_ones(scene):
    """Planes that are fitted to the nominal arm are nearer to the true ones than guesses that are tilted by 25 degrees, and nothing else changes."""
    config = with_overrides(load_config(scene), SMALL | FAR)
    simulated = simulate(config, base_dir=scene.parent)
    given = dataset_in_memory(simulated)
    begun = with_initial_planes(given)
    true = np.array(simulated.truth["planes"]["normals"])
    angles = [
        np.degrees(np.arccos(np.clip([n @ p.normal for n, p in zip(true, d.planes, strict=True)], -1, 1)))
        for d in (given, begun)
    ]
    assert (angles[0] > 15).all() and (angles[1] < 5).all()
    assert [p.name for p in given.planes] == [p.name for p in begun.planes]
    assert np.array_equal(given.points, begun.points) and given.robot is begun.robot


def test_every_fit_has_a_row(scene, tmp_path):
    """Each case, seed, method and start has one row, and from exact planes all four fits end near the truth."""
    write_plans(scene, 14, [1], tmp_path / "plans.npz")
    cases = {"near": SMALL | {"plane_guess.tilt_deg": 0.5}}
    table = compare_starts(scene, cases, [1], read_plans(tmp_path / "plans.npz"))
    assert sorted(zip(table["method"], table["start"], strict=True)) == sorted(
        (m, s) for m in (PROPOSED, BASELINE) for s in (OWN, OTHER)
    )
    assert (table["status"] == "converged").all()
    assert (table["position_mean_mm"] < 1.0).all()


def test_fits_are_counted_by_how_they_end():
    """A fit that did not converge is failed, one that converged far off is lost, and a later success does not mend an earlier failure."""
    ends = [(1, "converged", 0.1), (2, "capped", 0.1), (3, "converged", 90.0), (4, "converged", 0.1)]
    rows = [
        {"axis": "tilt", "walls": "upright", "method": PROPOSED, "start": OWN, "seed": 1, "value": v, "status": s, "position_mean_mm": e}
        for v, s, e in ends
    ]  # fmt: skip
    found = start_numbers(pd.DataFrame(rows))["tilt"]["upright"][PROPOSED][OWN]
    assert found == {"fits": 4, "failed": 1, "lost": 1, "all_succeed_up_to": 1.0}


def test_no_value_is_reached_if_the_first_fails():
    """If a fit at the smallest value fails, no value is stated up to which all succeed."""
    row = {"axis": "tilt", "walls": "upright", "method": PROPOSED, "start": OWN, "seed": 1, "value": 1.0}
    table = pd.DataFrame([row | {"status": "capped", "position_mean_mm": 0.1}])
    assert start_numbers(table)["tilt"]["upright"][PROPOSED][OWN]["all_succeed_up_to"] is None
