"""Joint angles that were written with few decimals are said, where the residual shows it."""

from dataclasses import replace

import numpy as np
import pytest

from scalar.data.dataset import Dataset
from scalar.data.rounding import rounded_angles, rounded_points
from scalar.errors import Undetermined
from scalar.estimation.calibrate import calibrate
from tests.random_scene import make_scene


def rounded(dataset: Dataset, step: float) -> Dataset:
    """Return the dataset with its joint angles rounded to multiples of a step [rad]; the measurements stay."""
    poses = dataset.poses.copy()
    names = [f"q{i + 1}" for i in range(dataset.robot.n_joints)]
    poses[names] = np.round(poses[names].to_numpy() / step) * step
    return replace(dataset, poses=poses)


def said(dataset: Dataset) -> list[str]:
    """Return what ``calibrate`` says of the set-up."""
    return [entry["sentence"] for entry in calibrate(dataset).summary["setup"]]


@pytest.mark.parametrize(
    ("step", "named"), [(0.01, "0.01 rad"), (np.deg2rad(0.1), "0.1 degree"), (0.001, "0.001 rad")]
)
@pytest.mark.parametrize("kind", ["tracker", "line-laser"])
def test_rounded_angles_are_said(kind, step, named):
    dataset = make_scene("vs060", kind, poses_per_plane=25, noise=5e-5, seed=1).dataset
    assert not any("multiple" in sentence for sentence in said(dataset))
    told = [sentence for sentence in said(rounded(dataset, step)) if "multiple" in sentence]
    assert len(told) == 1 and f"a multiple of {named}" in told[0]


def test_rounded_degrees_are_recognised_in_radians_with_six_decimals():
    """Converted and rounded again, the angles are multiples of their step to half a microradian alone."""
    robot = make_scene("vs060", seed=1).dataset.robot
    q = np.round(np.deg2rad(np.random.default_rng(2).integers(-900, 900, (40, robot.n_joints)) / 10), 6)
    assert "0.1 degree" in rounded_angles(robot, q, 3e-4)
    assert not rounded_angles(robot, q + np.random.default_rng(3).uniform(-1e-4, 1e-4, q.shape), 3e-4)


def test_a_refusal_names_the_rounding():
    dataset = make_scene("vs060", "tracker", poses_per_plane=25, noise=5e-5, seed=1).dataset
    with pytest.raises(Undetermined, match=r"every joint angle is a multiple of 0\.1 rad"):
        calibrate(rounded(dataset, 0.1))


def test_an_arm_that_was_sent_to_whole_degrees_is_not_blamed():
    """The residual of an arm that stood at whole degrees is far below what rounding to them leaves; that of rounding is not."""
    robot = make_scene("vs060", seed=1).dataset.robot
    q = np.deg2rad(np.random.default_rng(2).integers(-90, 90, (40, robot.n_joints)))
    assert not rounded_angles(robot, q, 3e-4)
    assert "1 degree" in rounded_angles(robot, q, 3e-3)
    assert not rounded_angles(robot, q, 0.1)  # another cause


@pytest.mark.parametrize(("step", "named"), [(1e-3, "1 mm"), (1e-4, "0.1 mm")])
def test_rounded_measurements_are_said(step, named):
    dataset = make_scene("vs060", "tracker", poses_per_plane=25, noise=5e-5, seed=1).dataset
    assert not rounded_points(dataset.points, 5e-5)
    told = said(replace(dataset, points=np.round(dataset.points / step) * step))
    assert any(
        f"multiple of {named}" in sentence and "write them with all decimals" in sentence for sentence in told
    )


def test_rounding_that_does_not_matter_and_few_different_points_are_not():
    points = np.round(np.random.default_rng(3).uniform(-1.0, 1.0, (50, 3)), 4)
    assert rounded_points(points, 1e-4) and not rounded_points(points, 1e-3)
    assert not rounded_points(np.zeros((50, 3)), 1e-5) and not rounded_points(np.zeros((5, 0)), 1e-5)
    two_places = np.array([[0.1, 0.2, 0.3], [0.15, 0.21, 0.32]])[np.arange(50) % 2]
    assert not rounded_points(two_places, 1e-4)  # as stated of the sockets of a plate
