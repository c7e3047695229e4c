"""On which side of its play a joint rests: from the order of the poses or, if that is not given, from the recorded directions of approach."""

import numpy as np
import pytest

from scalar.data.poses import Poses
from scalar.effects.joint_backlash import JointBacklash
from scalar.geometry.robot import Robot
from tests.robot_configs import robot_mapping

Q = np.zeros((4, 6))
Q[:, 1] = [0.1, 0.4, 0.2, 0.3]  # joint 2 comes from below, from above, from below
SIDES = [1.0, -1.0, 1.0]


def sides(columns) -> np.ndarray:
    """Return the sides ``(4,)`` on which joint 2 is said to rest, for play that was found from the order of the poses."""
    robot = Robot.from_mapping(robot_mapping("vs060"))
    return JointBacklash(2, "moves").joint_basis(robot, Poses.from_arrays(Q, columns, 6))[:, 1, 0]


@pytest.mark.parametrize(
    "columns",
    [
        {"order": np.arange(4.0)},
        {"approach2": np.array([0.0, *SIDES])},
        {"order": np.arange(4.0), "approach2": -np.array([0.0, *SIDES])},
    ],
)
def test_play_found_from_the_order_is_predicted_from_the_order_or_the_approach(columns):
    """Predictions use the order if it is given, as the fit did, and otherwise the directions of approach."""
    np.testing.assert_array_equal(sides(columns)[1:], SIDES)


def test_one_order_for_all_poses_says_nothing_on_moves():
    """It is the state at the end of a campaign, say, and no sequence; directions of approach that are given count."""
    assert not sides({"order": 50.0}).any()
    assert list(sides({"order": 50.0, "approach2": np.array([1.0, *SIDES])})) == [1.0, *SIDES]


def test_without_order_and_approach_the_play_is_left_out():
    """The middle of the play is the best guess if nothing is known of the move."""
    assert not sides({}).any()
