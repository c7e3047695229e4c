"""Planes that are declared known: rows in standard deviations, with the derivatives that go with them."""

from dataclasses import replace

import numpy as np
import pytest

from scalar.estimation.reference_planes import ReferencePlanes
from scalar.geometry.planes import Planes
from tests.random_scene import make_scene

DISTANCE_STD, NORMAL_STD = 1e-5, 1e-4


@pytest.fixture(scope="module")
def dataset():
    """Return a dataset whose second plane is known in both ways, and its third in distance alone."""
    data = make_scene(poses_per_plane=3).dataset
    floor, wall, other = data.planes
    known = replace(wall, distance_std=DISTANCE_STD, normal_std=NORMAL_STD)
    return replace(data, planes=(floor, known, replace(other, distance_std=DISTANCE_STD)))


@pytest.fixture(scope="module")
def planes(dataset):
    """Return the planes of the dataset where it declares them."""
    return Planes.at(
        [p.name for p in dataset.planes],
        np.array([p.normal for p in dataset.planes]),
        [p.distance for p in dataset.planes],
    )


def test_planes_where_they_are_declared_leave_no_residual(dataset, planes):
    """At the declared planes all rows are zero, even those of quantities that are not declared."""
    rows, _ = ReferencePlanes.of(dataset, planes).rows(planes)
    np.testing.assert_allclose(rows, 0.0, atol=1e-9)


def test_one_standard_deviation_off_is_a_residual_of_one(dataset, planes):
    """Distances and tilts count in their own standard deviations; a plane that is not known may be anywhere."""
    references = ReferencePlanes.of(dataset, planes)
    step = np.zeros(9)
    step[[2, 5]] = 1.0, DISTANCE_STD  # the floor by a metre, the wall by one standard deviation
    assert np.linalg.norm(references.rows(planes.with_vector(planes.vector + step))[0]) == pytest.approx(1.0)
    tilt = np.zeros(9)
    tilt[3] = NORMAL_STD
    assert np.linalg.norm(references.rows(planes.with_vector(planes.vector + tilt))[0]) == pytest.approx(1.0)


def test_derivatives_are_those_of_central_differences(dataset, planes):
    """The Jacobian away from the declared planes agrees with differences of the rows."""
    references = ReferencePlanes.of(dataset, planes)
    at = planes.vector + 1e-2 * np.random.default_rng(0).standard_normal(9)
    jacobian = references.rows(planes.with_vector(at))[1]
    h = 1e-6
    for k in range(9):
        ends = [references.rows(planes.with_vector(at + sign * h * np.eye(9)[k]))[0] for sign in (1, -1)]
        np.testing.assert_allclose(jacobian[:, k], (ends[0] - ends[1]) / (2 * h), rtol=1e-5, atol=1e-3)


def test_without_a_known_plane_there_are_no_rows(dataset, planes):
    """A dataset that declares no known plane has no reference planes."""
    plain = make_scene(poses_per_plane=3).dataset
    assert ReferencePlanes.of(plain, planes) is None
