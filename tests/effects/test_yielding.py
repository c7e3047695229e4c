"""A gear that is softer under small torques is not called a compliance, which is in proportion to the torque."""

import numpy as np
import pytest

from scalar.data.poses import Poses
from scalar.diagnosis import diagnose
from scalar.effects.effect import Effect
from scalar.effects.flexible.bent_deflection import KNEES
from scalar.effects.flexible.yielding import UnattributedYielding, yielding_rivals
from scalar.effects.joint_compliance import JointCompliance
from tests.effects.injected import Flaws, PoseData, make_cell, shares_of_torque
from tests.random_scene import make_scene

TERMS = ((2, 2), (2, 3), (3, 3))
WEIGHTS = np.array([1e-3, 2e-4, 5e-4, -1e-4, 7e-4, 3e-4])
SEED = 24


def sagging(two_slopes: bool):
    """Return the diagnosis of an arm whose joint 2 gives way: by 0.6 mrad at most, or by 0.5 mrad more until a quarter of the largest torque."""
    truth = make_scene(seed=SEED, poses_per_plane=60).truth

    def joints(at: PoseData) -> np.ndarray:
        share = shares_of_torque(truth, at.q, 2)
        dq = np.zeros_like(at.q)
        dq[:, 1] = 6e-4 * share + (5e-4 * np.clip(share / 0.25, -1.0, 1.0) if two_slopes else 0.0)
        return dq

    return diagnose(
        make_cell(Flaws(joints=joints), seed=SEED, poses_per_plane=60, points_per_scan=40).dataset
    )


def test_the_last_column_is_the_torque_up_to_the_knee():
    """It is the deflection by the given compliance in units of that at the knee, between -1 and 1; the others are those of the compliance."""
    dataset = make_scene(kind="tracker", seed=2, poses_per_plane=8).dataset
    poses = Poses(dataset.q, np.arange(dataset.n_poses, dtype=float), {})
    compliance = JointCompliance(TERMS).joint_basis(dataset.robot, poses)
    columns = UnattributedYielding(2, TERMS, tuple(WEIGHTS), 3e-4).joint_basis(dataset.robot, poses)
    np.testing.assert_array_equal(columns[:, :, :-1], compliance)
    deflection = (compliance @ WEIGHTS)[:, 1]
    small = np.abs(deflection) < 3e-4
    assert small.any() and not small.all()
    np.testing.assert_allclose(columns[small, 1, -1], deflection[small] / 3e-4)
    np.testing.assert_array_equal(columns[~small, 1, -1], np.sign(deflection[~small]))
    assert not columns[:, [0, 2, 3, 4, 5], -1].any()


def test_each_joint_that_gives_way_has_its_rivals():
    """A compliance that was fitted is imitated at each of its joints and each knee, and one without coefficients at none."""
    dataset = make_scene(kind="tracker", seed=2, poses_per_plane=8).dataset
    found = yielding_rivals(dataset, TERMS, WEIGHTS)
    assert [(e.joint) for e in found] == [2] * len(KNEES) + [3] * len(KNEES)
    assert len({e.key for e in found}) == len(found)
    compliance: Effect = JointCompliance(TERMS)
    fitted = compliance.with_coefficients(WEIGHTS)
    for effect, rivals in ((compliance, []), (fitted, found)):
        changes = [e.key for e in effect.imitators(dataset) if isinstance(e, UnattributedYielding)]
        assert changes == [e.key for e in rivals]


@pytest.mark.parametrize("two_slopes", [True, False])
def test_a_gear_with_two_slopes_is_described_as_one(two_slopes):
    """With two slopes the compliance has no name, and the joint is described; in proportion to the torque, it has its name for sure."""
    found = sagging(two_slopes)
    named = {f.effect.name for f in found.findings if f.has_name}
    described = [f.effect.described_as for f in found.findings if not f.has_name]
    if two_slopes:
        assert "joint_compliance" not in named
        assert (
            "a deflection of joint 2 under the weight of the arm that is not in proportion to the torque on it"
            in described
        )
    else:
        assert named == {"joint_compliance"} and not described
        assert found.findings[0].confidence >= 0.8
