"""The corrected table of joints that a refusal offers keeps what the correction leaves alone as it is written."""

from dataclasses import replace

import numpy as np
import pytest

from scalar.cli.corrected import corrected_block
from scalar.estimation.setup.alternatives import (
    read_as_modified,
    read_as_standard,
    with_limits_counted_back,
    with_sign_changed,
    with_zero_moved,
)
from scalar.geometry.robot import Robot
from scalar.geometry.standard_dh import stated_mapping

BLOCK = {
    "name": "arm",
    "joints": [
        {"d": 0.345, "type": "revolute"},
        {"alpha": -np.pi / 2, "theta": -np.pi / 2, "limits": [-2.0, 2.0]},
        {"a": 0.25, "theta": np.pi},
        {"a": 0.01, "alpha": np.pi / 2, "d": 0.2, "type": "prismatic"},
        {"alpha": -np.pi / 2, "d": 0.1},
    ],
    "flange": {"translation": [0.0, 0.0, 0.07]},
    "tolerance": {"length": 1e-3, "angle": 2e-3},
}
CORRECTIONS = {
    "sign of joint 2": lambda robot: with_sign_changed(robot, 1),
    "sign of a travel": lambda robot: with_sign_changed(robot, 3),
    "sign of the last joint": lambda robot: with_sign_changed(robot, 4),
    "zero of joint 3": lambda robot: with_zero_moved(robot, 2, np.pi / 2),
    "convention": lambda robot: read_as_modified(robot) if robot.standard_dh else read_as_standard(robot),
}


@pytest.mark.parametrize("convention", ["modified-dh", "standard-dh"])
@pytest.mark.parametrize("correct", CORRECTIONS.values(), ids=CORRECTIONS)
def test_a_corrected_block_is_the_corrected_arm(correct, convention):
    """Its flange stands where that of the corrected arm does; keys that are not stated are added only where a number is no longer zero."""
    described = {**BLOCK, "convention": convention}
    corrected = correct(Robot.from_mapping(described))
    block = corrected_block(described, stated_mapping(corrected))
    q = np.random.default_rng(1).uniform(-1, 1, (20, 5))
    np.testing.assert_allclose(Robot.from_mapping(block).flange(q), corrected.flange(q), atol=1e-12)
    assert block["name"] == "arm" and block["tolerance"] == BLOCK["tolerance"]
    for row, new in zip(BLOCK["joints"], block["joints"], strict=True):
        assert {key: new.get(key) for key in ("type", "limits")} == {
            key: row.get(key) for key in ("type", "limits")
        }
        assert not any(abs(new[key]) < 1e-9 for key in new.keys() - row.keys())


def test_limits_are_counted_back_where_only_these_contain_the_poses():
    """A joint whose recorded angles fit its limits only when these are counted the other way gets them so; one that fits both keeps its own."""
    robot = Robot.from_mapping({**BLOCK, "convention": "modified-dh"})
    limits = robot.limits.copy()
    limits[:2] = [-2.1, 1.4]
    q = np.zeros((3, 5))
    q[:, 0], q[:, 1] = [-1.4, 0.0, 2.0], [-1.0, 0.0, 1.0]
    found = with_limits_counted_back(replace(robot, limits=limits), q).limits
    np.testing.assert_array_equal(found[:2], [[-1.4, 2.1], [-2.1, 1.4]])
    block = corrected_block(
        {**BLOCK, "convention": "modified-dh"},
        stated_mapping(
            replace(robot, limits=np.where(np.arange(5)[:, None] == 1, [-1.0, 2.0], robot.limits))
        ),
    )
    assert [row.get("limits") for row in block["joints"]] == [None, [-1.0, 2.0], None, None, None]


def test_nothing_is_changed_where_nothing_is_corrected():
    """The block of an arm that is right stays as it is written, whole turns and rounding included."""
    described = {**BLOCK, "convention": "modified-dh"}
    mapping = stated_mapping(Robot.from_mapping(described))
    for joint in mapping["joints"]:
        joint["theta"] += 2 * np.pi
        joint["d"] += 1e-17
    assert corrected_block(described, mapping) == described
