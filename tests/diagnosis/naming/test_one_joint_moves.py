"""Where one joint alone moved, a deflection under the weight and an eccentric gear are the same sinusoid, and neither has a sure name."""

import numpy as np
import pytest

from scalar.diagnosis.naming.one_joint_moves import ALIKE, MOST_CONFIDENCE, limited_by_one_joint
from scalar.effects.base_compliance import BaseCompliance
from scalar.effects.joint_compliance import JointCompliance
from scalar.effects.joint_harmonic import JointHarmonic
from scalar.effects.joint_scale import JointScale
from tests.diagnosis.stand_ins import finding_of

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
    assert (found.confidence, found.limit) == ((MOST_CONFIDENCE, ALIKE) if limited else (0.95, ""))


@pytest.mark.parametrize("axis", ["tilted", "level"])
def test_a_deflection_and_an_order_are_one_sinusoid(axis):
    """The torque of a weight about any axis is a constant and a sinusoid of the only angle that turns, which is why the two cannot be told apart."""
    angle = np.linspace(-np.pi, np.pi, 40)
    about = np.array([0.3, 0.2, 0.9]) if axis == "tilted" else np.array([1.0, 0.0, 0.0])
    about /= np.linalg.norm(about)
    cross = np.array([[0, -about[2], about[1]], [about[2], 0, -about[0]], [-about[1], about[0], 0]])
    R = (
        np.eye(3)
        + np.sin(angle)[:, None, None] * cross
        + (1 - np.cos(angle))[:, None, None] * (cross @ cross)
    )
    other, lever = np.array([0.1, -0.7, 0.7]), np.array([0.05, 0.2, 0.1])
    torque = np.cross(R @ lever, [0.0, 0.0, -9.81]) @ other
    shape = np.stack([np.ones_like(angle), np.sin(angle), np.cos(angle)], axis=1)
    left = torque - shape @ np.linalg.lstsq(shape, torque, rcond=None)[0]
    assert np.abs(left).max() < 1e-12
