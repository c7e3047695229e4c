"""Directions of approach that are the opposite of the moves are doubted; those of other programs are not."""

from dataclasses import replace

import numpy as np
import pytest

from scalar.data.moves import side_column
from scalar.estimation.calibrate import calibrate
from scalar.estimation.setup.tables.approach_signs import opposite_approach
from tests.random_scene import make_scene


@pytest.fixture(scope="module")
def tracked():
    """Return sixty poses before a tracker."""
    return make_scene("vs060", "tracker", poses_per_plane=20, noise=1e-4, seed=3).dataset


def recorded(dataset, directions):
    """Return the dataset with directions of approach ``(N, n)``."""
    columns = {f"approach{j + 1}": column for j, column in enumerate(directions.T)}
    return replace(dataset, poses=dataset.poses.assign(**columns))


def moved(dataset):
    """Return the sides from which the moves came ``(N, n)``, 1 for the first pose."""
    sides = np.column_stack([dataset.known_poses.columns[side_column(j + 1)] for j in range(6)])
    return np.where(sides == 0.0, 1.0, sides)


def test_opposite_directions_are_doubted(tracked):
    """The summary of a calibration says so."""
    (said,) = [one["sentence"] for one in calibrate(recorded(tracked, -moved(tracked))).summary["setup"]]
    assert "the opposite of" in said and "approach1 to approach6" in said


def test_directions_of_other_programs_are_not_doubted(tracked):
    """As the moves are; all from one side; drawn at random, as by way of other poses; or not recorded."""
    drawn = np.random.default_rng(2).choice([-1.0, 1.0], tracked.q.shape)
    for directions in (moved(tracked), np.ones(tracked.q.shape), drawn):
        assert not opposite_approach(recorded(tracked, directions))
    assert not opposite_approach(tracked)
