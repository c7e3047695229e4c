"""What makers call the axes of their arms: as many names as joints, and none for an arm that may be another one."""

from dataclasses import replace

import pytest

from scalar.geometry.robot import Robot
from scalar.robots import arm_names, axis_in_brackets, axis_names_of, read_arm


@pytest.mark.parametrize("name", arm_names())
def test_names_are_complete_and_have_a_source(name):
    """An arm has a name for every axis, each another one, with its source, or none at all."""
    arm = read_arm(name)
    assert len(set(arm.axis_names)) == len(arm.axis_names) == (arm.robot.n_joints if arm.axis_names else 0)
    assert bool(arm.axis_names) == bool(arm.axis_names_source)


@pytest.mark.parametrize(
    ("name", "joint", "axis"),
    [
        ("kuka_kr6_r900_2", 3, "A3"),
        ("kuka_lbr_iiwa_14_r820", 7, "A7"),
        ("yaskawa_gp8", 4, "R"),
        ("fanuc_m20ia", 2, "J2"),
        ("ur10e", 4, "wrist 1"),
        ("ur5", 3, "elbow"),
        ("abb_irb2600_12_165", 5, "axis 5"),
        ("staubli_tx2_90", 6, "J6"),
    ],
)
def test_an_arm_of_the_library_has_its_makers_names(name, joint, axis):
    """The joint of the table is the axis that the maker's pendant shows."""
    assert axis_names_of(read_arm(name).robot)[joint - 1] == axis


def test_an_arm_that_may_be_another_one_has_no_names():
    """A table of joints that is not that of the named arm, a joint more, and a name that means nothing get no names of axes."""
    robot = read_arm("yaskawa_gp7").robot
    assert axis_names_of(replace(robot, name="our GP7 in hall 3")) == tuple("SLURBT")
    assert axis_names_of(replace(robot, name="welder")) == ()
    assert axis_names_of(replace(read_arm("kuka_kr6_r900_2").robot, name="yaskawa_gp7")) == ()
    rail = {"a": 0.0, "alpha": 0.0, "d": 0.0, "theta": 0.0, "type": "prismatic"}
    mapping = read_arm("yaskawa_gp7").mapping
    on_rail = Robot.from_mapping({**mapping, "joints": [rail, *mapping["joints"]]})
    assert axis_names_of(on_rail) == ()


def test_joints_without_names_have_no_brackets():
    """The brackets name the joints in their order, and are left out where no name is known."""
    assert axis_in_brackets(("S", "L", "U"), [3, 1]) == " (U, S)"
    assert axis_in_brackets((), [1]) == "" and axis_in_brackets(("S",), []) == ""
    assert axis_in_brackets(("S",), [0, 2]) == ""
