"""Columns of effects on joints: kept for the joints that move alone, they give the same angles and derivatives as the full basis."""

import numpy as np

from scalar.effects import SingleJointEffect
from scalar.estimation.effect_bases import JointBasis
from tests.effects.everything import every_effect, optional_columns
from tests.effects.injected import make_cell

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


def test_an_effect_of_one_joint_gives_the_columns_of_that_joint_alone():
    """For every effect on one joint, the columns that are kept without a look at other joints are those of its whole basis."""
    scene = make_cell(seed=5, poses_per_plane=8, points_per_scan=6, columns=optional_columns)
    poses, robot = scene.dataset.known_poses, scene.dataset.robot
    effects = [
        e for e in every_effect(scene.dataset, np.random.default_rng(0)) if isinstance(e, SingleJointEffect)
    ]
    assert len(effects) > 5
    for effect in effects:
        ((joint, columns),) = JointBasis.of_effect(effect, effect.own_columns(robot, poses)).parts
        whole = effect.joint_basis(robot, poses)
        np.testing.assert_array_equal(whole[:, joint], columns)
        whole[:, joint] = 0.0
        assert not whole.any()
