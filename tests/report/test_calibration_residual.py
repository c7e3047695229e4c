"""What `scalar calibrate` says of the residual: a few poses that lie far from the model are named."""

import numpy as np
import pytest

from scalar import calibrate
from scalar.data.dataset import Dataset
from scalar.estimation.residuals import Residuals
from scalar.report.calibration_residual import far_poses_in_words, residual_in_words
from tests.random_scene import make_scene


def displaced(count: int, poses_per_plane: int = 20) -> Dataset:
    """Return poses before a tracker; the last ``count`` are recorded 4 mm off."""
    dataset = make_scene(kind="tracker", poses_per_plane=poses_per_plane).dataset
    points = dataset.points.copy()
    points[len(points) - count :, 1] += 4e-3
    return Dataset.from_arrays(
        robot=dataset.robot,
        sensor=dataset.sensor,
        q=dataset.q,
        points=points,
        pose_ids=range(101, 101 + len(points)),
    )


@pytest.mark.parametrize("count", [0, 1, 2])
def test_a_few_poses_far_off_are_named(count):
    """Each is named with its number and distance, and where all poses fit nothing is said."""
    dataset = displaced(count)
    said = " ".join(far_poses_in_words(calibrate(dataset, explain=False), dataset))
    numbers = dataset.pose_ids[len(dataset.pose_ids) - count :]
    assert bool(said) == bool(count)
    assert all(f"pose {number} by 3." in said or f"pose {number} by 4." in said for number in numbers)
    assert said.count("pose ") == count


def test_a_pose_to_which_few_others_adapt_is_named_with_its_own_error():
    """Of 30 poses one is 4 mm off: the fit to all spreads that over them, and the pose is named with its distance from the fit to the others."""
    dataset = displaced(1, poses_per_plane=10)
    calibration = calibrate(dataset, explain=False)
    distances = Residuals.of(dataset, calibration.model).pose_distances(calibration.model)
    assert distances[-1] < 10 * np.median(distances)
    (said,) = far_poses_in_words(calibration, dataset)
    assert f"pose {dataset.pose_ids[-1]} by 3." in said or f"pose {dataset.pose_ids[-1]} by 4." in said


def test_many_poses_far_off_are_no_gross_errors():
    """If a quarter of the poses does not fit, the model is wrong and no pose is blamed."""
    dataset = displaced(15)
    assert not far_poses_in_words(calibrate(dataset, explain=False), dataset)


def test_the_scatter_within_poses_is_mentioned_where_there_is_one():
    """A tracker measures one point at a pose, which has no scatter."""
    assert residual_in_words({"poses": 50, "points": 50}) == "the residual"
    assert residual_in_words({"poses": 50, "points": 5000}).startswith(
        "apart from the scatter of the points within"
    )
