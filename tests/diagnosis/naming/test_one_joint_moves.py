"""Where one joint alone moved, a deflection under the weight and an eccentric gear are the same sinusoid, and neither has a sure name."""

import numpy as np
import pytest

from scalar.data.poses import Poses
from scalar.diagnosis.naming.most_confidence import ONE_OF_TWO
from scalar.diagnosis.naming.one_joint_moves import MOVED_ALONE, limited_by_one_joint
from scalar.effects.base_compliance import BaseCompliance
from scalar.effects.joint_compliance import JointCompliance
from scalar.effects.joint_harmonic import JointHarmonic
from scalar.effects.joint_scale import JointScale
from scalar.geometry.robot import Robot
from tests.diagnosis.stand_ins import finding_of
from tests.robot_configs import robot_mapping
from tests.turning import turning

LEAST = 0.6


def turned(*joints):
    """Return 60 poses in which these joints (from 1) turn, and the others stand still."""
    q = np.full((60, 6), 0.3)
    for joint in joints:
        q[:, joint - 1] = np.random.default_rng(joint).uniform(-3, 3, 60)
    return q


def of_order(order):
    """Return an error of joint 4 in one order."""
    return JointHarmonic(4, (order,), coefficients=np.zeros(2))


@pytest.mark.parametrize(
    ("effect", "joints", "limited"),
    [
        (of_order(1), (4,), True),
        (of_order(2), (4,), False),
        (of_order(1), (2, 4), False),
        (JointCompliance(((5, 5),)), (4,), True),
        (JointCompliance(((5, 5),)), (3, 4), False),
        (BaseCompliance((2, 3), True), (4,), True),
        (JointScale(4), (4,), False),
        (JointScale(5), (4,), True),
    ],
    ids=[
        "order 1",
        "order 2",
        "two moved",
        "weight",
        "weight, two moved",
        "base",
        "scale",
        "a joint that stood still",
    ],
)
def test_names_that_one_moving_joint_does_not_tell_apart_are_doubtful(effect, joints, limited):
    """Only what is a sinusoid of the one angle, or belongs to a joint that stood still, is limited."""
    (found,) = limited_by_one_joint([finding_of(effect, 0.95)], turned(*joints), LEAST)
    assert found.doubtful == limited
    assert (found.confidence, found.limit) == ((ONE_OF_TWO, MOVED_ALONE) if limited else (0.95, ""))


@pytest.mark.parametrize("joint", [2, 3, 5])
def test_a_deflection_and_an_order_are_one_sinusoid(joint):
    """Where joint 4 turns alone, a compliance of each joint is a constant and a sinusoid of its angle; where joint 3 moves as well, it is not."""
    arm = Robot.from_mapping({"name": "vs060", **robot_mapping("vs060")})
    weight = JointCompliance(tuple((joint, frame) for frame in range(joint, 7)))
    for joints, is_sinusoid in (((4,), True), ((3, 4), False)):
        q = turned(*joints)
        shape = np.stack([np.ones(len(q)), np.sin(q[:, 3]), np.cos(q[:, 3])], axis=1)
        columns = weight.joint_basis(arm, Poses.from_arrays(q, {}, turning(6))).reshape(len(q), -1)
        left = columns - shape @ np.linalg.lstsq(shape, columns, rcond=None)[0]
        assert np.ptp(columns, axis=0).max() > 0.1
        assert (np.abs(left).max() < 1e-12) == is_sinusoid
