"""What gives way under a weight that an arm hardly has is no sure deflection under the weight of the arm."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from scalar.data.poses import Poses
from scalar.diagnosis.naming.most_confidence import ONE_OF_TWO
from scalar.diagnosis.naming.typical_masses import UNTYPICAL_MASSES, limited_by_typical_masses
from scalar.effects.base_compliance import BaseCompliance
from scalar.effects.joint_compliance import JointCompliance
from scalar.effects.joint_scale import JointScale
from scalar.effects.typical_weight import joints_along_weight
from scalar.geometry.robot import Robot
from tests.diagnosis.stand_ins import finding_of
from tests.robot_configs import robot_mapping

LEAST = 0.6
ARM = Robot.from_mapping(robot_mapping("vs060"))
POSES = Poses(
    np.random.default_rng(0).uniform(*(0.8 * ARM.limits.T), (80, ARM.n_joints)), np.arange(80.0), {}
)
STATE: Any = SimpleNamespace(dataset=SimpleNamespace(robot=ARM, known_poses=POSES))


def answer(effect: Any) -> Any:
    """Return what the rule makes of one finding with a confidence of 0.95."""
    (found,) = limited_by_typical_masses([finding_of(effect, 0.95)], STATE, LEAST)
    return found


def fitted(effect: Any, wanted: np.ndarray) -> Any:
    """Return an effect whose varying error is nearest to the wanted one: (N,) of its first joint, or (N, 3) of a base [rad]."""
    if isinstance(effect, JointCompliance):
        columns = effect.joint_basis(ARM, POSES)[:, effect.target["joints"][0] - 1]
    else:
        columns = effect.base_screws(ARM, POSES)[:, :3].reshape(-1, len(effect.coefficient_names))
    return effect.with_coefficients(np.linalg.lstsq(columns, wanted.ravel(), rcond=None)[0])


def weight_on(joint: int) -> np.ndarray:
    """Return the moment vectors (N, 3) about the origin of a joint of a unit mass half-way along each link that it moves [m]."""
    origins = np.concatenate(
        [ARM.frames(POSES.q)[:, joint:, :3, 3], ARM.flange(POSES.q)[:, None, :3, 3]], axis=1
    )
    middles = 0.5 * (origins[:, 1:] + origins[:, :-1]) - origins[:, :1]
    return np.cross(middles, [0.0, 0.0, -1.0]).sum(axis=1)


def torque_on(joint: int) -> np.ndarray:
    """Return the component (N,) of that moment along the joint's axis."""
    return np.sum(weight_on(joint) * ARM.frames(POSES.q)[:, joint, :3, 2], axis=1)


WHOLE = JointCompliance(tuple((2, frame) for frame in range(2, 7)))
BASE = BaseCompliance((2, 3, 4, 5, 6), True)


@pytest.mark.parametrize(
    "effect",
    [fitted(WHOLE, 1e-3 * torque_on(2)), fitted(BASE, 1e-3 * weight_on(1)), JointScale(4)],
    ids=["a joint under its links", "a base under the arm", "no deflection"],
)
def test_what_follows_the_weight_keeps_its_confidence(effect):
    """Links that have their masses half-way between their joints are typical, although the rule assumes them at their ends."""
    assert (answer(effect).confidence, answer(effect).limit) == (0.95, "")


@pytest.mark.parametrize(
    "effect",
    [
        fitted(WHOLE, -1e-3 * torque_on(2)),
        fitted(WHOLE, 1e-3 * np.cos(POSES.q[:, 1])),
        fitted(BASE, 1e-3 * weight_on(1)[:, [1, 0, 2]] * [1.0, -1.0, 0.0]),
    ],
    ids=[
        "a joint that rises under its load",
        "a joint with its masses beside the link",
        "a base that tilts across the load",
    ],
)
def test_what_follows_no_typical_weight_loses_its_name(effect):
    """Its confidence is that of one of two, so its name is doubtful, and the reason is given."""
    found = answer(effect)
    assert (found.confidence, found.limit, found.doubtful) == (ONE_OF_TWO, UNTYPICAL_MASSES, True)


def test_a_wrist_that_may_bear_an_unknown_tool_is_not_judged():
    """The typical torque on a wrist hardly varies: its weight is that of a tool of unknown shape."""
    wrist = JointCompliance(((6, 6),)).with_coefficients(np.array([1e-3, -2e-3]))
    assert wrist.along_typical_weight(ARM, POSES) is None
    assert answer(wrist).confidence == 0.95


@pytest.mark.parametrize(("share", "cosine"), [(0.3, 1.0), (0.7, -1.0)], ids=["little", "much"])
def test_a_joint_that_is_deflected_little_is_not_judged(share, cosine):
    """Its deflection may be that of the unknown masses of a wrist; shares of the standard deviation over the poses."""
    own, other = torque_on(2), -torque_on(3)
    deflections = {2: own, 3: share * np.std(own) / np.std(other) * other}
    found = joints_along_weight(ARM, POSES.q, deflections)
    assert found == pytest.approx(cosine, abs=0.2)
