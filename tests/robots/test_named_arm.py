"""A table of joints that is clearly not that of the library's arm of the same name is doubted in one sentence, and never refused."""

from dataclasses import replace

import numpy as np
import pytest

from scalar.estimation.calibrate import calibrate
from scalar.geometry.robot import GEOMETRY, Robot
from scalar.robots import arm_names, arms_with_axes_of, doubt_of_name, read_arm
from tests.random_scene import make_scene

A = GEOMETRY.index("a")


def described(name="kuka_kr6_r900_sixx", *, longer=0.0, called=None, **changes):
    """Return an arm of the library whose a_3 is longer by some metres, under another name, with other keys of its description."""
    robot = Robot.from_mapping({**read_arm(name).mapping, **changes})
    geometry = robot.geometry.copy()
    geometry[A, 2] += longer
    return replace(robot.with_geometry(geometry), name=called or name)


@pytest.mark.parametrize("name", arm_names())
def test_the_librarys_own_arms_are_not_doubted(name):
    """Their tables are their own."""
    assert doubt_of_name(described(name)) == ""


@pytest.mark.parametrize(
    ("robot", "words"),
    [
        (described(longer=0.03), ["axes 2 and 3 is 485 mm and not 455 mm", "mistyped"]),
        (described(longer=-0.455, called="my KR6 R900 sixx"), ["'my KR6 R900 sixx'", "0 mm and not 455 mm"]),
        (described(convention="standard-dh"), ["under `convention: modified-dh`"]),
    ],
    ids=["longer", "resembling", "convention"],
)
def test_a_clear_difference_is_doubted(robot, words):
    """The sentence states what differs with both numbers, and the other convention where that explains it."""
    doubt = doubt_of_name(robot)
    assert all(word in doubt for word in words) and "\n" not in doubt


@pytest.mark.parametrize(
    "robot",
    [described(longer=0.019), described(longer=0.3, called="arm 3"), described(longer=0.3, called="kr6")],
    ids=["near", "no name", "no model"],
)
def test_small_differences_and_other_names_are_not(robot):
    """Nor is an arm whose name says nothing of a model of the library."""
    assert doubt_of_name(robot) == ""


def test_a_calibration_of_an_arm_of_another_name_is_made():
    """If the data agree with the table, the name alone is doubted, and the calibration is the same."""
    dataset = make_scene("vs060", "tracker", poses_per_plane=20, seed=5).dataset
    plain, named = (
        calibrate(replace(dataset, robot=replace(dataset.robot, name=n))) for n in ("arm", "ur5e")
    )
    assert plain.summary["setup"] == []
    (suspicion,) = named.summary["setup"]
    assert suspicion["where"] == "robot.name" and "UR5e" in suspicion["sentence"]
    assert named.residual_rms == plain.residual_rms


def test_a_measured_arm_is_recognised_among_those_of_the_library():
    """The axes of a calibrated arm name its model, whatever the table that it began with; an arm of no known lengths is not named."""
    robot = read_arm("kuka_kr6_r900_sixx").robot
    geometry = robot.geometry + np.random.default_rng(0).normal(0.0, 3e-4, robot.geometry.shape)
    assert [arm.name for arm in arms_with_axes_of(robot.with_geometry(geometry))] == ["kuka_kr6_r900_sixx"]
    assert arms_with_axes_of(described(longer=0.05)) == []
