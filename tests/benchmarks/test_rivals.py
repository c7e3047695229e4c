"""The rivals of the diagnosis are what they say: the lasso's minimum, and the penalty of least BIC."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.diagnosis.rivals import descended, entries, least_bic
from scalar.effects.joint_scale import JointScale


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10_000), st.floats(0.05, 0.9))
def test_descent_ends_where_the_optimality_conditions_hold(seed, share):
    """The gradient is the penalty against the sign of each nonzero coefficient, and no larger elsewhere."""
    rng = np.random.default_rng(seed)
    A, y = rng.standard_normal((40, 8)), rng.standard_normal(40)
    A /= np.linalg.norm(A, axis=0)
    gram, correlation = A.T @ A, A.T @ y
    penalty = share * np.abs(correlation).max()
    w = descended(gram, correlation, np.zeros(8), penalty, 1e-12)
    gradient = gram @ w - correlation
    assert np.all(np.abs(gradient) <= penalty + 1e-9)
    assert gradient[w != 0] == pytest.approx(-penalty * np.sign(w[w != 0]), abs=1e-9)


def test_orthogonal_columns_are_shrunk_one_by_one():
    """With orthonormal columns the lasso is soft thresholding."""
    correlation = np.array([3.0, -2.0, 0.5])
    w = descended(np.eye(3), correlation, np.zeros(3), 1.0, 1e-12)
    assert w == pytest.approx([2.0, -1.0, 0.0])


def test_noise_is_left_alone_and_a_column_is_found():
    """Of columns without any part in the residual none is taken; one that makes the residual is, and few others."""
    rng = np.random.default_rng(5)
    A = np.linalg.qr(rng.standard_normal((400, 12)))[0]
    noise = rng.standard_normal(400)
    quiet = noise - A @ (A.T @ noise)
    assert not least_bic(A.T @ A, A.T @ quiet, float(quiet @ quiet), 400).any()
    loud = quiet + 40.0 * A[:, 3]
    found = np.flatnonzero(least_bic(A.T @ A, A.T @ loud, float(loud @ loud), 400))
    assert found.tolist() == [3]
    assert least_bic(np.zeros((0, 0)), np.zeros(0), 1.0, 10).shape == (0,)


def test_entries_are_those_of_a_diagnosis():
    """Name and target as the score reads them."""
    (entry,) = entries([JointScale(2)])
    assert (entry["name"], entry["target"]) == ("joint_scale", {"joint": 2})
