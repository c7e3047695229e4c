"""Planes on S^2 x R: tangents are orthonormal, derivatives agree with differences, and coordinates survive a change of reference."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scalar.geometry.planes import Planes, tangent_basis

component = st.floats(-1.0, 1.0, allow_nan=False)
normals = (
    st.tuples(component, component, component)
    .map(np.array)
    .filter(lambda v: np.linalg.norm(v) > 1e-2)
    .map(lambda v: v / np.linalg.norm(v))
)
axes = st.sampled_from([sign * row for row in np.eye(3) for sign in (1.0, -1.0)])
coordinates = st.tuples(st.floats(-2, 2), st.floats(-2, 2), st.floats(-3, 3)).map(np.array)


@given(st.one_of(normals, axes))
def test_tangents_are_orthonormal_with_the_normal(normal):
    """The tangents are unit vectors perpendicular to the normal and to each other, for walls and floors too."""
    frame = np.vstack([normal, tangent_basis(normal[None])[0]])
    np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=1e-14)


@given(st.one_of(normals, axes), coordinates)
def test_derivative_of_the_normal(normal, vector):
    """``dn/d(u, v)`` agrees with central differences, also far from the reference, and is tangent to the sphere."""
    planes = Planes.at(["k"], normal[None], np.zeros(1)).with_vector(vector)
    derivative, h = planes.normal_derivatives[0], 1e-6
    for t in range(2):
        step = h * np.eye(3)[t]
        ahead, behind = (
            planes.with_vector(vector + step).normals[0],
            planes.with_vector(vector - step).normals[0],
        )
        np.testing.assert_allclose(derivative[:, t], (ahead - behind) / (2 * h), atol=1e-9)
    np.testing.assert_allclose(planes.normals[0] @ derivative, 0.0, atol=1e-14)
    assert np.linalg.norm(planes.normals[0]) == pytest.approx(1.0, abs=1e-15)


@given(st.one_of(normals, axes), coordinates)
def test_rebasing_changes_the_coordinates_and_not_the_planes(normal, vector):
    """``rebased`` and ``expressed_about`` keep every plane where it is."""
    planes = Planes.at(["k"], normal[None], np.zeros(1)).with_vector(vector)
    rebased = planes.rebased()
    np.testing.assert_allclose(rebased.normals, planes.normals, atol=1e-15)
    np.testing.assert_array_equal(rebased.vector[:2], 0.0)
    back = rebased.expressed_about(Planes.at(["k"], normal[None], np.zeros(1)))
    np.testing.assert_allclose(back.vector, vector, atol=1e-12)


@given(normals)
def test_a_small_coordinate_is_the_angle_of_tilt(normal):
    """For small values (u, v) is the tilt in radians, so that its standard error can be read as an angle."""
    planes = Planes.at(["k"], normal[None], np.zeros(1)).with_vector(np.array([3e-4, -4e-4, 0.0]))
    angle = np.linalg.norm(np.cross(planes.normals[0], normal))
    assert angle == pytest.approx(5e-4, rel=1e-6)


def test_a_normal_that_turned_over_is_not_expressed_about_its_guess():
    """A normal more than 90 degrees from its guess has no tangent coordinates about it: an error is raised."""
    guess = Planes.at(["k"], np.array([[0.0, 0.0, 1.0]]), np.zeros(1))
    with pytest.raises(ValueError, match="right angle"):
        Planes.at(["k"], np.array([[1.0, 0.0, -0.1]]), np.zeros(1)).expressed_about(guess)


def test_names_units_and_vector_go_together():
    """Each plane has three coordinates; names, units and vector list them in the same order."""
    planes = Planes.at(["floor", "wall"], np.eye(3)[[2, 0]], np.array([0.1, 0.7]))
    floor, wall = planes.parameter_names[:3], planes.parameter_names[3:]
    assert floor == ["normal_floor_u", "normal_floor_v", "distance_floor"]
    assert wall == ["normal_wall_u", "normal_wall_v", "distance_wall"]
    assert planes.vector.tolist() == [0, 0, 0.1, 0, 0, 0.7]
    assert len(planes.parameter_units) == 6
