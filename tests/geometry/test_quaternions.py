"""Quaternions become rotation vectors and come from rotations; what cannot be a rotation is said by its norm."""

import numpy as np
import pytest
from scipy.linalg import expm

from scalar.geometry.quaternions import quaternions_from_rotations, rotation_vectors_from_quaternions
from scalar.geometry.se3 import skew

AXIS = np.array([2.0, -1.0, 2.0]) / 3


def test_a_quaternion_is_half_the_angle_about_the_axis():
    """Cosine of half the angle, then the axis times its sine; the negative quaternion is the same rotation."""
    angles = np.array([0.0, 1e-9, 0.4, 3.0])
    q = np.column_stack([np.cos(angles / 2), np.sin(angles / 2)[:, None] * AXIS])
    for given in (q, -q):
        vectors, wrong_norm = rotation_vectors_from_quaternions(given)
        assert vectors == pytest.approx(angles[:, None] * AXIS, abs=1e-15)
        assert np.isnan(wrong_norm).all()
    R = np.array([expm(skew(angle * AXIS)) for angle in angles])
    assert quaternions_from_rotations(R) == pytest.approx(q, abs=1e-14)


def test_a_norm_that_is_not_one_is_returned():
    """Rounding to three digits is accepted. A norm of 0, 0.98 or 2 is returned, and a quaternion with a NaN has no norm; both stand for no turn."""
    rounded = np.round([np.cos(0.2), *(np.sin(0.2) * AXIS)], 3)
    given = np.array([rounded, [0, 0, 0, 0], [0.98, 0, 0, 0], [0, 0, 2, 0], [np.nan, 0, 0, 1]])
    vectors, wrong_norm = rotation_vectors_from_quaternions(given)
    assert np.flatnonzero(~np.isnan(wrong_norm)).tolist() == [1, 2, 3]
    assert wrong_norm[1:4] == pytest.approx([0.0, 0.98, 2.0])
    assert vectors[0] == pytest.approx(0.4 * AXIS, abs=1e-3)
    assert not vectors[1:].any()
