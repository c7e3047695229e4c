"""Measurements of other rows, of another campaign, and with the columns of one target exchanged are refused by name, without a long search."""

from dataclasses import replace

import numpy as np
import pytest

from scalar.estimation.calibrate import calibrate
from scalar.estimation.setup.suspicion import WrongSetup
from scalar.estimation.setup.tables.exchanged_columns import exchanged_columns
from scalar.estimation.setup.tables.unrelated_rows import unrelated
from tests.random_scene import make_scene
from tests.tracked_targets import drawn_arm

JOINTS = [f"q{i}" for i in range(1, 7)]


@pytest.fixture(scope="module")
def tracked():
    """Return ninety poses before a tracker."""
    return make_scene("vs060", "tracker", poses_per_plane=30, noise=1e-4, seed=7).dataset


@pytest.fixture(scope="module")
def two_targets():
    """Return forty poses of two targets on one flange, measured in turn at each pose."""
    rng = np.random.default_rng(3)
    arm = drawn_arm(rng, ("a", "b"))
    return arm.dataset(arm.poses(40, rng), rng, noise=1e-4, stated={"noise": 1e-4})


def refused(dataset):
    """Return the suspicion for which a dataset is refused, and the file that the refusal names."""
    with pytest.raises(WrongSetup) as error:
        calibrate(dataset)
    (suspicion,) = error.value.suspicions
    return suspicion, error.value.faults[0].file


@pytest.mark.parametrize(("rows", "word"), [(5, "after"), pytest.param(-9, "before", marks=pytest.mark.slow)])
def test_a_shift_by_some_rows_is_named(tracked, rows, word):
    """The sentence states by how many rows and in which direction, and the refusal names poses.csv."""
    moved = np.roll(tracked.poses[JOINTS].to_numpy(), rows, axis=0)
    suspicion, file = refused(
        replace(tracked, poses=tracked.poses.assign(**dict(zip(JOINTS, moved.T, strict=True))))
    )
    assert suspicion.what == "shifted_poses" and file == "poses.csv"
    assert f"the pose {abs(rows)} rows {word} the one" in suspicion.sentence


def test_points_of_another_campaign_are_named(tracked):
    """They have nothing to do with the joint angles, and are refused for that before signs and zeros are tried two by two."""
    other = make_scene("vs060", "tracker", poses_per_plane=30, noise=1e-4, seed=8).dataset
    suspicion, file = refused(replace(tracked, points=other.points))
    assert suspicion.what == "unrelated_rows" and file == "poses.csv"
    assert "points.csv do not belong to the joint angles" in suspicion.sentence


@pytest.mark.parametrize("robot", ["vs060", "ur10e", "panda"])
@pytest.mark.parametrize("seed", range(5))
def test_only_measurements_of_other_poses_are_unrelated(robot, seed):
    """Whatever is wrong with signs, zeros, the frame and units, the measurements follow the angles; another arm's or a random order's do not."""
    dataset = make_scene(robot, "tracker", poses_per_plane=20, seed=seed).dataset
    rng = np.random.default_rng(seed)
    columns = [f"q{i + 1}" for i in range(dataset.robot.n_joints)]
    signs = rng.choice([-1.0, 1.0], len(columns))
    zeros = rng.uniform(-np.pi, np.pi, len(columns))
    other = dataset.poses.assign(**dict(zip(columns, (dataset.q * signs + zeros).T, strict=True)))
    mirrored = 1e3 * dataset.points * [1.0, -1.0, 1.0]
    assert not unrelated(replace(dataset, poses=other, points=mirrored))
    assert not unrelated(dataset.subset(np.arange(30)))  # too few to tell
    assert unrelated(replace(dataset, points=rng.permutation(dataset.points)))


@pytest.mark.parametrize(
    ("matrix", "says"),
    [
        ([[0, 1, 0], [1, 0, 0], [0, 0, 1]], "the columns x and y are exchanged"),
        ([[1, 0, 0], [0, 1, 0], [0, 0, -1]], "the column z counts the other way"),
    ],
)
def test_exchanged_columns_of_one_target_are_named(two_targets, matrix, says):
    """The target is named, and the table to correct; a pair of targets cannot tell in which of the two the columns are wrong without the arm."""
    b = two_targets.point_columns["target"] == 1
    points = two_targets.points.copy()
    points[b] = points[b] @ np.array(matrix, dtype=float).T
    suspicion, _ = refused(replace(two_targets, points=points))
    assert suspicion.what == "exchanged_columns" and suspicion.where == "target b"
    assert suspicion.file_at_fault == "points.csv"
    assert f"{says} in the rows of target 'b' in points.csv" in suspicion.sentence


def test_targets_that_stay_equally_far_are_not_tried(two_targets):
    """Where the distance of the targets is constant, no change of one target's columns is proposed."""
    assert list(exchanged_columns(two_targets)) == []


@pytest.mark.parametrize("strange", [False, True])
def test_a_tracker_that_was_moved_is_not_taken_for_another_campaign(tracked, strange):
    """Its places in a later session are in another frame; angles in random order are still recognised within the longest session."""
    later = np.arange(tracked.n_poses) >= 65
    points = tracked.points.copy()
    points[later] = points[later, ::-1] * [1.0, -1.0, 1.0] + [3.0, 0.0, 0.0]
    moved = replace(tracked, points=points, poses=tracked.poses.assign(session=later.astype(int)))
    if strange:
        order = np.random.default_rng(1).permutation(tracked.n_poses)
        moved = replace(
            moved, poses=moved.poses.assign(**{q: moved.poses[q].to_numpy()[order] for q in JOINTS})
        )
    assert unrelated(moved) == strange


def test_a_few_readings_that_are_metres_off_do_not_make_the_others_unrelated(tracked):
    """One coordinate of every fifteenth reading is ten times too large, as a digit too many makes it."""
    points = tracked.points.copy()
    points[::15, 0] *= 10.0
    assert not unrelated(replace(tracked, points=points))
