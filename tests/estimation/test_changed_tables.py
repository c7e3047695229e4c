"""What a suspected error does to the table of joints: signs, zeros and conventions change it exactly, and back again."""

import numpy as np
import pytest

from scalar.estimation.setup.alternatives import (
    read_as_modified,
    read_as_standard,
    with_sign_changed,
    with_zero_moved,
)
from scalar.geometry.robot import Robot
from scalar.geometry.standard_dh import stated_mapping
from tests import kinematics
from tests.robot_configs import robot_mapping


@pytest.mark.parametrize("joint", range(6))
def test_a_changed_sign_is_undone_by_the_table(joint):
    """The table of an arm whose joint counts the other way gives the same flange at the negated angle."""
    robot = Robot.from_mapping(robot_mapping("vs060"))
    q = np.random.default_rng(1).uniform(-2, 2, (8, 6))
    other = q.copy()
    other[:, joint] *= -1
    np.testing.assert_allclose(with_sign_changed(robot, joint).flange(other), robot.flange(q), atol=1e-12)
    moved = q.copy()
    moved[:, joint] -= 0.3
    np.testing.assert_allclose(with_zero_moved(robot, joint, 0.3).flange(moved), robot.flange(q), atol=1e-12)


def test_a_table_read_one_way_and_back_is_the_same():
    """Standard and modified DH are two readings of one table: one undoes the other."""
    modified = Robot.from_mapping(robot_mapping("vs060"))
    standard = read_as_standard(modified)
    for robot, there, back in (
        (modified, read_as_standard, read_as_modified),
        (standard, read_as_modified, read_as_standard),
    ):
        assert there(robot).standard_dh != robot.standard_dh == back(there(robot)).standard_dh
        again = back(there(robot))
        np.testing.assert_allclose(again.geometry, robot.geometry, atol=1e-12)
        np.testing.assert_allclose(again.T_n_flange, robot.T_n_flange, atol=1e-12)


@pytest.mark.parametrize("joint", range(6))
def test_a_corrected_standard_table_stays_standard(joint):
    """If any joint of a standard-DH table counts the other way, the corrected table is in standard DH too."""
    joints = [
        {"a": 0.1 * (i + 1), "alpha": 0.3 * i - 0.7, "d": 0.2 - 0.1 * i, "theta": 0.1 * i} for i in range(6)
    ]
    robot = Robot.from_mapping({"name": "arm", "convention": "standard-dh", "joints": joints})
    written = stated_mapping(with_sign_changed(robot, joint))
    assert written["convention"] == "standard-dh"
    q = np.random.default_rng(2).uniform(-2, 2, (8, 6))
    other = q.copy()
    other[:, joint] *= -1
    rows = [[row[key] for key in ("theta", "d", "a", "alpha")] for row in written["joints"]]
    by_formula = (
        kinematics.transform(written["base"])
        @ kinematics.standard_chain(rows, other)
        @ kinematics.transform(written["flange"])
    )
    np.testing.assert_allclose(by_formula, robot.flange(q), atol=1e-12)
    near = [[row[key] for key in ("a", "d")] for row in joints]
    np.testing.assert_allclose(np.abs([[row[2], row[1]] for row in rows]), np.abs(near), atol=1e-12)
