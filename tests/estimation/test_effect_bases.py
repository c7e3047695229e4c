"""Columns of effects on joints: kept for the joints that move alone, they give the same angles and derivatives as the full basis."""

import numpy as np

from scalar.estimation.effect_bases import JointBasis

N, JOINTS, K = 7, 6, 3


def basis():
    """Return a basis ``(N, n, k)`` that moves joints 2 and 5 alone, counted from 1."""
    full = np.zeros((N, JOINTS, K))
    full[:, [1, 4]] = np.random.default_rng(0).standard_normal((N, 2, K))
    return full


def test_only_joints_that_move_are_kept():
    """Of six joints, the basis keeps the two that have columns."""
    parts = JointBasis.of(basis()).parts
    assert [joint for joint, _ in parts] == [1, 4]


def test_angles_and_derivatives_are_those_of_the_full_basis():
    """The angles are ``q + basis c``, and derivatives are those of the chain rule over all joints."""
    rng = np.random.default_rng(1)
    q, c, by_angle = (
        rng.standard_normal((N, JOINTS)),
        rng.standard_normal(K),
        rng.standard_normal((N, 2, JOINTS)),
    )
    kept = JointBasis.of(basis())
    np.testing.assert_allclose(kept.added(q, c), q + basis() @ c, atol=1e-14)
    np.testing.assert_allclose(kept.columns(by_angle), by_angle @ basis(), atol=1e-13)


def test_the_angles_that_were_given_stay_as_they_are():
    """The effect is added to a copy, and the given angles do not change."""
    q = np.zeros((N, JOINTS))
    JointBasis.of(basis()).added(q, np.ones(K))
    assert not q.any()
