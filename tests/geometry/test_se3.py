"""Rotations and transforms: the laws of the group, and exponential and logarithm near zero and near half a turn."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm

from scalar.geometry import se3
from tests import kinematics

component = st.floats(-2.0, 2.0, allow_nan=False, width=64)
vectors = st.tuples(component, component, component).map(np.array)
directions = vectors.filter(lambda v: np.linalg.norm(v) > 1e-2).map(lambda v: v / np.linalg.norm(v))
rotation_vectors = st.tuples(directions, st.floats(0.0, np.pi)).map(lambda p: p[0] * p[1])
poses = st.tuples(vectors, rotation_vectors).map(lambda p: se3.transform_from_rotation_vector(*p))
small_angles = st.sampled_from([0.0, 1e-300, 1e-16, 1e-12, 1e-8, 1e-5, 9.9e-5, 1.01e-4, 1e-3])
from_half_turn = st.sampled_from([0.0, 1e-14, 1e-10, 1e-8, 1e-6, 1e-3])


@given(poses, poses, poses)
def test_transforms_form_a_group(A, B, C):
    """Composition is associative, stays rigid, has a neutral element, and ``inverse`` undoes on both
    sides.
    """
    np.testing.assert_allclose((A @ B) @ C, A @ (B @ C), atol=1e-13)
    R = (A @ B)[:3, :3]
    np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-14)
    assert np.linalg.det(R) == pytest.approx(1.0, abs=1e-14)
    np.testing.assert_allclose(A @ se3.inverse(A), np.eye(4), atol=1e-14)
    np.testing.assert_allclose(se3.inverse(A) @ A, np.eye(4), atol=1e-14)
    np.testing.assert_allclose(se3.inverse(A @ B), se3.inverse(B) @ se3.inverse(A), atol=1e-13)


@given(rotation_vectors)
def test_exponential_is_the_matrix_exponential(r):
    """``exp(r)`` is the exponential of the matrix ``[r]x``, as SciPy computes it."""
    np.testing.assert_allclose(se3.exp_so3(r), expm(se3.skew(r)), atol=1e-13)


@given(directions, st.one_of(small_angles, st.floats(0.0, 3.1)))
def test_logarithm_undoes_exponential(direction, angle):
    """``log(exp(r)) = r`` to rounding, for angles from zero to just below half a turn."""
    r = direction * angle
    np.testing.assert_allclose(se3.log_so3(se3.exp_so3(r)), r, rtol=0, atol=2e-14 + 1e-14 * angle)


@given(directions, from_half_turn)
def test_logarithm_near_half_a_turn(direction, short):
    """Near pi the axis may come out with either sign, but the rotation it stands for is the same and no
    longer than pi.
    """
    R = se3.exp_so3(direction * (np.pi - short))
    r = se3.log_so3(R)
    assert np.linalg.norm(r) <= np.pi + 1e-12
    np.testing.assert_allclose(se3.exp_so3(r), R, atol=1e-13)
    assert (
        min(np.linalg.norm(r - direction * (np.pi - short)), np.linalg.norm(r + direction * (np.pi + short)))
        < 1e-6
    )


@given(rotation_vectors)
def test_logarithm_agrees_with_that_by_quaternions(r):
    """The logarithm and one that is computed by a quaternion stand for the same rotation."""
    R = kinematics.rotate_about(r, float(np.linalg.norm(r))) if np.linalg.norm(r) > 0 else np.eye(3)
    np.testing.assert_allclose(
        se3.exp_so3(se3.log_so3(R)), se3.exp_so3(kinematics.rotation_vector(R)), atol=1e-13
    )


@given(directions, st.one_of(small_angles, st.floats(1e-3, 3.0)), vectors)
def test_left_jacobian_turns_a_step_of_the_vector_into_a_rotation(direction, angle, step):
    """By central differences, ``exp(r + dr) = exp(J_l dr) exp(r)`` holds to first order."""
    r, h = direction * angle, 1e-5
    difference = se3.exp_so3(r + h * step) @ se3.exp_so3(r - h * step).T
    expected = se3.log_so3(difference) / (2 * h)
    np.testing.assert_allclose(se3.left_jacobian_so3(r) @ step, expected, atol=2e-9)


def test_left_jacobian_is_continuous_where_the_series_takes_over():
    """The closed form and the series agree on either side of the switch, to the rounding of the closed form."""
    direction = np.array([1.0, -2.0, 0.5]) / np.sqrt(5.25)
    below, above = (se3.left_jacobian_so3(direction * angle) for angle in (0.99999e-4, 1.00001e-4))
    np.testing.assert_allclose(below, above, atol=1e-8)


@given(vectors, vectors)
def test_cross_and_skew_are_the_cross_product(u, v):
    """``cross(u, v)`` and ``skew(u) @ v`` agree with NumPy's cross product."""
    np.testing.assert_array_equal(se3.cross(u, v), np.cross(u, v))
    np.testing.assert_allclose(se3.skew(u) @ v, np.cross(u, v), atol=1e-15)


@given(st.integers(0, 3), st.integers(1, 3))
def test_batches_are_the_single_results_stacked(outer, inner):
    """Every function maps over leading dimensions, empty ones too."""
    rng = np.random.default_rng(outer * 7 + inner)
    r, t = rng.normal(size=(2, outer, inner, 3))
    T = se3.transform_from_rotation_vector(t, r)
    assert T.shape == (outer, inner, 4, 4)
    assert se3.inverse(T).shape == T.shape
    assert se3.log_so3(T[..., :3, :3]).shape == (outer, inner, 3)
    assert se3.skew(r).shape == (outer, inner, 3, 3)
    for i in range(outer):
        for j in range(inner):
            np.testing.assert_array_equal(se3.inverse(T)[i, j], se3.inverse(T[i, j]))
            np.testing.assert_allclose(T[i, j, :3, :3], se3.exp_so3(r[i, j]), atol=1e-14)


@given(directions, st.one_of(small_angles, st.floats(1e-3, np.pi)))
def test_rotation_angle_is_accurate_near_zero_and_up_to_half_a_turn(direction, angle):
    """The angle has full relative accuracy even where it is tiny, where an arc cosine would return zero."""
    assert se3.rotation_angle(se3.exp_so3(direction * angle)) == pytest.approx(angle, rel=1e-9, abs=1e-15)
