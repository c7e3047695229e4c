"""Distances and angles between axes are the same in every table of one arm, and differ between arms."""

import numpy as np
import pytest

from scalar.estimation.setup.alternatives import with_sign_changed, with_zero_moved
from scalar.geometry.robot import GEOMETRY, Robot
from scalar.robots import arm_names, read_arm
from scalar.robots.axes_between import between_axes, largest_difference

A, D = GEOMETRY.index("a"), GEOMETRY.index("d")


def listed(name):
    """Return an arm of the library."""
    return Robot.from_mapping(read_arm(name).mapping)


@pytest.mark.parametrize("name", arm_names())
def test_signs_zeros_and_frames_do_not_matter(name):
    """A joint that counts the other way or from elsewhere, a base that stands higher and a longer flange leave all of them as they are."""
    robot = listed(name)
    changed = robot
    for joint in range(1, robot.n_joints, 2):
        changed = with_zero_moved(with_sign_changed(changed, joint), joint, 0.7)
    geometry = changed.geometry.copy()
    geometry[D, 0] += 0.4
    geometry[D, -1] += 0.1
    changed = changed.with_geometry(geometry)
    assert largest_difference(robot, changed)[0] < 1e-6


def test_an_offset_may_stand_at_any_of_parallel_axes():
    """The axes 2, 3 and 4 of a UR are parallel: where d stands among them is a choice, and their sum is that of the arm."""
    robot = listed("ur5e")
    geometry = robot.geometry.copy()
    geometry[D, 1:4] += [0.2, 0.1, -0.3]
    assert largest_difference(robot, robot.with_geometry(geometry))[0] < 1e-6
    geometry[D, 3] += 0.05
    size, own, other = largest_difference(robot, robot.with_geometry(geometry))
    assert own.what == "the offset along axes 2 to 4" and size > 1
    assert abs(own.value - other.value) == pytest.approx(0.05)


def test_a_distance_is_that_of_the_lines():
    """The distance and angle of two axes agree with those of the lines along them, at any joint angles."""
    robot = listed("kuka_kr6_r900_sixx")
    values = {value.what: value.value for value in between_axes(robot)}
    q = np.random.default_rng(2).uniform(-1, 1, (1, 6))
    frames = robot.frames(q)[0, 1:]  # those of the joints
    for i in range(1, 6):
        one, two = frames[i - 1], frames[i]
        normal = np.cross(one[:3, 2], two[:3, 2])
        between = two[:3, 3] - one[:3, 3]
        if np.linalg.norm(normal) > 0.1:
            distance = abs(between @ normal) / np.linalg.norm(normal)
        else:
            distance = np.linalg.norm(np.cross(between, one[:3, 2]))
        assert values[f"the distance between axes {i} and {i + 1}"] == pytest.approx(distance, abs=1e-9)
        cosine = abs(one[:3, 2] @ two[:3, 2])
        assert np.cos(values[f"the angle between axes {i} and {i + 1}"]) == pytest.approx(cosine, abs=1e-9)
