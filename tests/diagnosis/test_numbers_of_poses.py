"""A change in the course of a campaign is named by the number of its first pose in the table, whatever poses before it are set aside."""

from dataclasses import replace

import numpy as np
import pytest

from scalar.diagnosis import diagnose
from tests.effects.injected import Flaws, make_cell


@pytest.mark.slow
def test_poses_that_are_set_aside_do_not_count_the_others_down():
    """A plane is knocked at row 50 of 90, and five of the rows before are gross errors; poses.csv has no column order.

    The order of the change had been that among the poses which were left: 45.
    """
    flaws = Flaws(moved={"floor": (50, 1e-3, (0.0, 0.0))})
    dataset = make_cell(flaws, seed=5, poses_per_plane=30).dataset
    points, wrong = dataset.points.copy(), [4, 11, 19, 27, 38]
    for row in wrong:
        points[dataset.starts[row] : dataset.starts[row + 1], -1] += 0.05
    bare = dataset.poses.drop(columns=["order", "time"], errors="ignore")
    found = diagnose(replace(dataset, points=points, poses=bare), outer_folds=0)
    assert len(found.cleaned.dataset.pose_ids) == dataset.n_poses - len(wrong)
    (change,) = [f.effect for f in found.findings if f.effect.name == "plane_moved"]
    scans_of_floor = np.flatnonzero(dataset.poses["plane"].to_numpy() == "floor")
    first = scans_of_floor[scans_of_floor >= 50][0]
    last_before = scans_of_floor[scans_of_floor < 50][-1]
    assert last_before < change.target["at"]["order"] <= first
