"""Gross errors are found and set aside; what is only noisy, or only unexplained, is kept."""

import re
from dataclasses import replace

import numpy as np
import pytest

from scalar.errors import InvalidInput, Undetermined
from scalar.estimation.calibrate import calibrate
from scalar.estimation.gross_errors import Cleaned, clean, clean_given_effects
from scalar.estimation.outlying_points import _median_within, without_outlying_points
from tests.diagnosis.cases import knock, slip
from tests.diagnosis.gross_errors import spoiled
from tests.effects.injected import Flaws, make_cell, on_joint
from tests.random_scene import make_scene

FALSE_POINTS = 1e-4  # share of good points that may be set aside
FOUND_POINTS = 0.95  # share of points off by 2 mm and more that are set aside


def test_clean_data_stay_as_they_are():
    """Over 12 workcells with 2,160 scans and 69,120 points, no pose is set aside, and at most one point in 10,000."""
    points = flagged = 0
    for seed in range(12):
        dataset = make_cell(seed=seed).dataset
        found = clean(dataset)
        assert not found.outlier_poses and not found.mislabelled_poses
        points, flagged = points + len(dataset.points), flagged + found.points
    assert flagged <= FALSE_POINTS * points


@pytest.mark.parametrize("counts", [[5, 5, 5], [4, 4], [3, 6, 1], [1]])
def test_the_median_of_each_scan_is_the_larger_of_the_middle_two(counts):
    """It is that of the scan's sorted values, whether or not all scans have as many points."""
    rng, counts = np.random.default_rng(0), np.array(counts)
    starts = np.r_[0, np.cumsum(counts)]
    values = rng.normal(size=starts[-1])
    found = _median_within(values, np.repeat(np.arange(len(counts)), counts), starts[:-1], counts)
    assert found.tolist() == [sorted(own)[len(own) // 2] for own in np.split(values, starts[1:-1])]


@pytest.mark.parametrize("share", [0.002, 0.02, 0.1])
def test_stray_points_are_found(share):
    """Points 2 to 30 mm off along their rays are set aside, and their scans kept."""
    cell = make_cell(seed=3)
    dataset, injected = spoiled(cell.dataset, np.random.default_rng(4), points=share)
    found = clean(dataset)
    assert not found.outlier_poses and not found.mislabelled_poses
    assert FOUND_POINTS * len(injected["points"]) <= found.points <= len(injected["points"]) + 2
    assert found.dataset.n_poses == dataset.n_poses
    assert len(found.dataset.points) == len(dataset.points) - found.points


def test_the_right_points_are_set_aside():
    """The points that remain are those that were not moved."""
    cell = make_cell(seed=5)
    dataset, injected = spoiled(cell.dataset, np.random.default_rng(6), points=0.03)
    kept = {tuple(p) for p in without_outlying_points(dataset)[0].points}
    good = np.ones(len(dataset.points), dtype=bool)
    good[injected["points"]] = False
    assert sum(tuple(p) not in kept for p in dataset.points[good]) <= 2


@pytest.mark.parametrize("seed", range(4))
def test_wrong_poses_and_wrong_labels_are_distinguished(seed):
    """Exactly the poses whose angles belong to no scan are outliers.

    Exactly the poses that name another target plane are listed with the plane on which they lie.
    """
    cell = make_cell(seed=seed)
    dataset, injected = spoiled(cell.dataset, np.random.default_rng(seed), poses=0.04, labels=0.04)
    found = clean(dataset)
    wrong = {pose for pose, _ in found.mislabelled_poses}
    assert set(found.outlier_poses) | wrong == injected["poses"] | injected["labels"]
    # A wrong pose may lie on another target plane by chance; not many do.
    assert injected["labels"] <= wrong and len(wrong - injected["labels"]) <= 1
    truth = dict(zip(cell.dataset.pose_ids.tolist(), cell.dataset.poses["plane"], strict=True))
    assert all(
        target_plane == truth[pose]
        for pose, target_plane in found.mislabelled_poses
        if pose in injected["labels"]
    )


@pytest.mark.parametrize("share", [0.04, 0.15])
def test_wrong_labels_are_found_without_a_nominal_pose(share):
    """A scanner needs no nominal pose. Its first guess then comes from all poses, and wrong labels turn it; still every wrong label is found, and
    no other pose is set aside."""
    cell = make_cell(seed=2)
    sensor = replace(cell.dataset.sensor, T_flange_sensor=None)
    dataset, injected = spoiled(replace(cell.dataset, sensor=sensor), np.random.default_rng(2), labels=share)
    found = clean(dataset)
    assert {pose for pose, _ in found.mislabelled_poses} == injected["labels"] and not found.outlier_poses
    truth = dict(zip(cell.dataset.pose_ids.tolist(), cell.dataset.poses["plane"], strict=True))
    assert all(plane == truth[pose] for pose, plane in found.mislabelled_poses)


@pytest.mark.slow
def test_a_calibration_names_wrong_labels_and_not_the_guesses_of_planes():
    """A few wrong labels can turn the planes that are fitted to all poses by a right angle. The refusal names these poses, and no plane's normal."""
    cell = make_cell(seed=2)
    sensor = replace(cell.dataset.sensor, T_flange_sensor=None)
    dataset, injected = spoiled(replace(cell.dataset, sensor=sensor), np.random.default_rng(2), labels=0.15)
    with pytest.raises(InvalidInput) as refusal:
        calibrate(dataset)
    said = [fault.message for fault in refusal.value.faults]
    assert all("is said to lie on" in message for message in said)
    assert {int(message.split()[1]) for message in said} == injected["labels"]


def test_a_third_of_wrong_poses_is_survived():
    """With 30 % of all poses wrong the others are found and kept."""
    cell = make_cell(seed=8)
    dataset, injected = spoiled(cell.dataset, np.random.default_rng(9), poses=0.3)
    found = clean(dataset)
    flagged = set(found.outlier_poses) | {pose for pose, _ in found.mislabelled_poses}
    assert injected["poses"] <= flagged
    assert len(flagged - injected["poses"]) <= 2


@pytest.mark.parametrize("how", ["at random", "in turn"])
def test_labels_that_say_nothing_are_refused(how):
    """If every pose names another target plane, no data can be trusted over others: the exit status is 3, and the text speaks of labels."""
    data = make_cell(seed=10).dataset
    shift = np.random.default_rng(1).integers(1, 3, data.n_poses) if how == "at random" else 1
    names = np.array([plane.name for plane in data.planes], dtype=object)
    poses = data.poses.assign(plane=names[(data.plane_index + shift) % 3])
    with pytest.raises(Undetermined) as caught:
        clean(replace(data, poses=poses))
    assert caught.value.exit_status == 3
    assert "label" in str(caught.value) and "poses.csv" in str(caught.value)


@pytest.mark.parametrize("case", [knock, slip])
def test_a_change_is_not_an_outlier(case):
    """A change that begins at one pose and stays is kept for forward selection."""
    found = clean(case(11)[0].dataset)
    assert not found.outlier_poses and not found.mislabelled_poses


def test_a_large_effect_is_not_an_outlier():
    """An error of a joint of ten times the natural size is structure and no gross error, so hardly any pose is set aside."""
    error = on_joint(2, lambda at: 5e-3 * np.sin(3 * at.q[:, 1]))
    found = clean(make_cell(Flaws(joints=error), seed=12).dataset)
    assert len(found.outlier_poses) + len(found.mislabelled_poses) <= 3
    assert found.points <= 3


def late(dataset, off, by=3e-3):
    """Return what is set aside beside effects, where poses at the indices ``off`` are off by 3 mm and the others by a tenth."""
    distance = np.full(dataset.n_poses, 1e-4)
    distance[off] = by
    first = Cleaned(dataset, (), (), 0)
    return first, clean_given_effects(first, distance)


def test_a_gross_error_that_hid_behind_an_effect_is_set_aside_late():
    """A single pose that is off given the effects is listed and removed, and the others stay."""
    dataset = make_scene(kind="probe", seed=2, poses_per_plane=60).dataset
    _, again = late(dataset, [17])
    assert again.outlier_poses == (int(dataset.pose_ids[17]),)
    np.testing.assert_array_equal(again.dataset.pose_ids, np.delete(dataset.pose_ids, 17))


def test_nothing_is_set_aside_late_that_may_be_an_effect():
    """If nothing is off given the effects, or too much is, or a whole run of one plane, no pose is set aside late."""
    dataset = make_scene(kind="probe", seed=2, poses_per_plane=60).dataset
    run = np.flatnonzero(dataset.plane_index == 1)[20:23]
    long_run = np.flatnonzero(dataset.plane_index == 1)[20:40]
    for off, by in (([], 0.0), ([17], 2e-4), (np.arange(0, 180, 5), 3e-3), (long_run, 3e-3)):
        first, again = late(dataset, off, by)
        assert again is first
    assert len(late(dataset, run)[1].outlier_poses) == 3


def test_a_refused_pose_is_said_with_its_distance():
    """A pose recorded 300 mm off is refused with that distance, and with the distance of the others, which is near the noise of 0.1 mm."""
    dataset = make_scene("vs060", "tracker", poses_per_plane=25, noise=1e-4, seed=7).dataset
    points = dataset.points.copy()
    points[30] += [0.3, 0.0, 0.0]
    with pytest.raises(InvalidInput) as refusal:
        calibrate(replace(dataset, points=points))
    (fault,) = refusal.value.faults
    said = re.search(r"pose 31 contradicts all others: it lies (\S+) mm .* lie (\S+) mm", fault.message)
    assert said is not None
    # The fit to the others and the root mean square over points hold for one position here: the distance is that by which it was moved.
    assert float(said[1]) == pytest.approx(300.0, rel=0.01)
    assert 0.05 < float(said[2]) < 0.3
