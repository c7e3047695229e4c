"""A plane that was guessed far from where it is, is said to be; the calibration does not depend on the guess."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from scalar.data.dataset import Dataset
from scalar.estimation.calibrate import calibrate
from scalar.geometry.robot import Robot
from scalar.units import DEG, MM
from tests.random_scene import make_scene
from tests.robot_configs import robot_mapping


@pytest.fixture(scope="module")
def scans() -> Dataset:
    """Return sixty scans of three planes, whose guesses are right."""
    return make_scene("vs060", poses_per_plane=20, points_per_scan=12, noise=1e-4, seed=5).dataset


def guessed(dataset: Dataset, distance: float) -> Dataset:
    """Return the dataset with another guess of the distance [m] of its second plane."""
    floor, wall, other = dataset.planes
    return replace(dataset, planes=(floor, replace(wall, distance=distance), other))


@pytest.mark.parametrize("times", [-1.0, 1.75])
def test_a_guess_far_off_is_said_and_does_no_harm(scans, times):
    """The remark has the guessed and the fitted distance, and the arm is the same as with a good guess."""
    true = scans.planes[1].distance
    found = calibrate(guessed(scans, times * true))
    (suspicion,) = found.summary["setup"]
    assert suspicion["what"] == "plane_guess" and suspicion["where"] == "wall_x"
    assert f"has the distance {times * true / MM:.0f} mm" in suspicion["sentence"]
    sound = calibrate(scans).model.robot.geometry
    np.testing.assert_allclose(found.model.robot.geometry, sound, atol=1e-6)


def test_a_plane_on_the_other_side_may_be_wrong_signs_of_the_joints(scans):
    """Joints 1, 4 and 6 that all count the other way put the wall at the arm's side on its other side, and no other plane. That is said of this wall,
    and not of one before the arm.
    """
    signs = np.array([-1.0, 1.0, 1.0, -1.0, 1.0, -1.0])
    q = {f"q{j + 1}": scans.q[:, j] * signs[j] for j in range(6)}
    robot = Robot.from_mapping(
        robot_mapping("vs060")
    )  # the table of the data sheet, which is its own mirror image
    (suspicion,) = calibrate(replace(scans, robot=robot, poses=scans.poses.assign(**q))).summary["setup"]
    assert (suspicion["what"], suspicion["where"]) == ("plane_guess", "wall_y")
    assert "joints 1, 4 and 6 look the same" in suspicion["sentence"]
    front = calibrate(guessed(scans, -scans.planes[1].distance)).summary["setup"]
    assert "look the same" not in front[0]["sentence"]


def test_guesses_as_the_documentation_allows_them_are_not_mentioned():
    """Errors of 30 degrees and 10 cm are small enough."""
    rough = make_scene(
        "vs060",
        poses_per_plane=20,
        points_per_scan=12,
        noise=1e-4,
        seed=5,
        plane_tilt=29 * DEG,
        plane_offset=0.1,
    )
    assert not calibrate(rough.dataset).summary["setup"]
