"""Screws: they are the velocities of points, change frames by the adjoint action, and are the derivatives of rigid motions."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from scalar.geometry import screws, se3

component = st.floats(-2.0, 2.0, allow_nan=False, width=64)
vectors = st.tuples(component, component, component).map(np.array)
directions = vectors.filter(lambda v: np.linalg.norm(v) > 1e-2).map(lambda v: v / np.linalg.norm(v))
rotation_vectors = st.tuples(directions, st.floats(0.0, np.pi)).map(lambda p: p[0] * p[1])
frames = st.tuples(vectors, rotation_vectors).map(lambda p: se3.transform_from_rotation_vector(*p))
H = 1e-6


def velocity(screw, p):
    """Return the velocity ``(3,)`` of a point under a screw ``(6,)``: ``w x p + v``."""
    return np.cross(screw[:3], p) + screw[3:]


@given(vectors, rotation_vectors, vectors)
def test_a_small_screw_moves_points_by_its_velocity(v, w, p):
    """A small screw moves a point by ``dp = w x p + v`` to first order, and ``exp_screw`` is a rigid motion for every argument."""
    T = screws.exp_screw(np.r_[w, v])
    np.testing.assert_allclose(T[:3, :3] @ T[:3, :3].T, np.eye(3), atol=1e-14)
    plus, minus = (screws.exp_screw(sign * H * np.r_[w, v]) for sign in (1.0, -1.0))
    moved = (plus - minus)[:3] @ np.r_[p, 1.0] / (2 * H)
    np.testing.assert_allclose(moved, np.cross(w, p) + v, atol=1e-8)


@given(frames, vectors, vectors, vectors)
def test_a_change_of_frame_leaves_the_velocity_of_a_point_alone(T_a_b, w, v, p_b):
    """A point's velocity from the screw in frame a is that from the screw in frame b, rotated to a."""
    screw_b = np.r_[w, v]
    screw_a = screws.change_frame(T_a_b[None], screw_b[None, :, None])[0, :, 0]
    p_a = (T_a_b @ np.r_[p_b, 1.0])[:3]
    np.testing.assert_allclose(velocity(screw_a, p_a), T_a_b[:3, :3] @ velocity(screw_b, p_b), atol=1e-12)


@given(frames, frames, vectors, vectors)
def test_changes_of_frame_compose(T_a_b, T_b_c, w, v):
    """``Ad(T_a_b T_b_c) = Ad(T_a_b) Ad(T_b_c)``, and the inverse undoes it."""
    screw = np.r_[w, v][None, :, None]
    at_once = screws.change_frame((T_a_b @ T_b_c)[None], screw)
    in_steps = screws.change_frame(T_a_b[None], screws.change_frame(T_b_c[None], screw))
    np.testing.assert_allclose(at_once, in_steps, atol=1e-11)
    back = screws.change_frame(se3.inverse(T_a_b)[None], screws.change_frame(T_a_b[None], screw))
    np.testing.assert_allclose(back, screw, atol=1e-12)


@given(vectors, rotation_vectors, vectors, vectors, vectors)
def test_the_derivative_of_a_screw_motion_is_that_of_central_differences(v, w, dw, dv, p_0):
    """The screw that ``exp_screw_derivative`` gives moves a point as ``exp_screw`` does when its argument changes."""
    screw, change = np.r_[w, v], np.r_[dw, dv]
    found = screws.exp_screw_derivative(screw[None], change[None, :, None])[0, :, 0]
    plus, minus = (screws.exp_screw(screw + sign * H * change) @ np.r_[p_0, 1.0] for sign in (1.0, -1.0))
    p = (screws.exp_screw(screw) @ np.r_[p_0, 1.0])[:3]
    np.testing.assert_allclose(velocity(found, p), (plus - minus)[:3] / (2 * H), atol=1e-7)


@given(directions, vectors, component)
def test_a_rotation_about_a_line_leaves_its_points_alone(axis, through, along):
    """Points on the axis have no velocity, and another point's velocity is perpendicular to the axis."""
    screw = screws.rotations_about(axis[None, :, None], through[None])[0, :, 0]
    np.testing.assert_allclose(velocity(screw, through + along * axis), 0.0, atol=1e-12)
    off = velocity(screw, through + np.cross(axis, [0.3, -0.7, 0.2]))
    assert abs(off @ axis) < 1e-12
