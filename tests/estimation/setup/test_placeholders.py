"""A number that an instrument writes in all columns where it measured nothing is not taken for a place."""

from dataclasses import replace

import numpy as np
import pytest

from scalar.errors import InvalidInput
from scalar.estimation.calibrate import calibrate
from scalar.estimation.setup.tables.placeholders import placeholders
from tests.random_scene import make_scene


@pytest.fixture(scope="module")
def tracked():
    """Return seventy-five poses before a tracker."""
    return make_scene("vs060", "tracker", poses_per_plane=25, noise=1e-4, seed=7).dataset


def with_points(dataset, rows, point):
    """Return the dataset with some of its points replaced."""
    points = dataset.points.copy()
    points[rows] = point
    return replace(dataset, points=points)


@pytest.mark.parametrize("number", [-0.999, 0.0, 9999.0])
def test_the_number_and_its_poses_are_named(tracked, number):
    """Two rows suffice, and the message says how a mapping leaves such rows out."""
    rows = [3, 17, 40]
    with pytest.raises(InvalidInput, match=f"all {number:g} .*missing") as refused:
        calibrate(with_points(tracked, rows, number))
    assert ", ".join(str(tracked.pose_ids[row]) for row in rows) in str(refused.value)


def test_true_places_are_none(tracked):
    """Neither a single place on the diagonal, nor repeated places off it, nor the origin among places to which a target returns."""
    assert not len(placeholders(tracked))
    assert not len(placeholders(with_points(tracked, [5], 0.3)))
    assert not len(placeholders(with_points(tracked, [5, 9], [0.1, 0.2, 0.3])))
    sockets = np.array([[0.0, 0.0, 0.0], [0.5, 0.1, 0.0], [0.2, 0.6, 0.1]])
    assert not len(placeholders(replace(tracked, points=sockets[np.arange(tracked.n_poses) % 3])))
