"""A row that was lost or doubled in one of the tables is named with the pose near which it was; single wrong poses are not called so."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from scalar.data.dataset import Dataset
from scalar.errors import InvalidInput
from scalar.estimation.calibrate import calibrate
from scalar.estimation.setup.suspicion import Suspicion, WrongSetup
from scalar.units import MM
from tests.random_scene import make_scene


@pytest.fixture(scope="module")
def tracked() -> Dataset:
    """Return seventy-five poses before a tracker."""
    return make_scene("vs060", "tracker", poses_per_plane=25, noise=1e-4, seed=7).dataset


def with_angles_of(dataset: Dataset, source: np.ndarray, *, labels: bool = False) -> Dataset:
    """Return the dataset with the angles of each row taken from row ``source`` ``(N,)``, the labels of the planes too if asked for."""
    columns = [c for c in dataset.poses.columns if c[0] == "q" or (labels and c == "plane")]
    taken = {name: dataset.poses[name].to_numpy()[source] for name in columns}
    return replace(dataset, poses=dataset.poses.assign(**taken))


def refused_with(dataset: Dataset) -> Suspicion:
    """Return the only suspicion with which a dataset is refused."""
    with pytest.raises(WrongSetup) as refused:
        calibrate(dataset)
    (suspicion,) = refused.value.suspicions
    return suspicion


@pytest.mark.parametrize(
    ("k", "step"), [(30, 1), *(pytest.param(*c, marks=pytest.mark.slow) for c in ((50, -1), (12, -1)))]
)
def test_a_row_lost_before_a_tracker_is_named_with_its_pose(tracked, k, step):
    """From that pose on each measurement belongs to the pose before or after its own, and with its own the residual is that of the noise."""
    rows = np.arange(tracked.n_poses)
    source = np.where(rows < k, rows, np.clip(rows + step, 0, rows[-1]))
    suspicion = refused_with(with_angles_of(tracked, source))
    # If the later angles moved up, those of the measurement at row k are lost; if they moved down, the measurement before it fits both rows.
    first = [k + 1] if step > 0 else [k - 1, k]
    assert suspicion.what == "lost_row"
    assert suspicion.where in [f"from pose {pose} on" for pose in tracked.pose_ids[first]]
    belongs = "before" if step > 0 else "after"
    assert f"belongs to the pose {belongs} the one" in suspicion.sentence
    assert suspicion.rms_after is not None and suspicion.rms_after < 0.5 * MM


@pytest.mark.slow
@pytest.mark.parametrize("labels", [False, True])
def test_a_row_lost_among_scans_is_named_with_its_pose(labels):
    """So it is with planes, whether or not the labels of the planes moved with the angles."""
    scans = make_scene("vs060", poses_per_plane=30, points_per_scan=12, noise=1e-4, seed=5).dataset
    rows = np.arange(scans.n_poses)
    suspicion = refused_with(with_angles_of(scans, np.where(rows < 40, rows, rows - 1), labels=labels))
    assert suspicion.what == "lost_row"
    assert suspicion.where in [f"from pose {pose} on" for pose in scans.pose_ids[[39, 40]]]


@pytest.mark.slow
def test_a_row_lost_and_another_doubled_are_named_with_both_poses(tracked):
    """The poses between the two are concerned."""
    rows = np.arange(tracked.n_poses)
    suspicion = refused_with(with_angles_of(tracked, np.where((rows < 20) | (rows >= 50), rows, rows + 1)))
    first, last = tracked.pose_ids[[21, 49]]  # the angles of the measurement at row 20 are lost
    assert suspicion.what == "lost_row" and suspicion.where == f"from pose {first} to pose {last}"
    assert suspicion.file_at_fault == "poses.csv"


@pytest.mark.slow
def test_two_exchanged_poses_are_no_lost_row(tracked):
    """Each of the two belongs to the pose before or after it, and is named by itself."""
    source = np.arange(tracked.n_poses)
    source[[30, 31]] = 31, 30
    with pytest.raises(InvalidInput) as refused:
        calibrate(with_angles_of(tracked, source))
    assert not isinstance(refused.value, WrongSetup)
    assert all("contradicts all others" in fault.message for fault in refused.value.faults)


@pytest.mark.parametrize("k", [37, 67])
def test_a_row_lost_in_the_middle_or_near_the_end_is_named(tracked, k):
    """In the middle, half of the measurements belong to other rows, so that they seem unrelated to the angles; near the end only some do."""
    rows = np.arange(tracked.n_poses)
    suspicion = refused_with(
        with_angles_of(tracked, np.where(rows < k, rows, np.clip(rows + 1, 0, rows[-1])))
    )
    assert suspicion.what == "lost_row" and suspicion.where == f"from pose {tracked.pose_ids[k + 1]} on"


def test_a_row_lost_near_the_end_of_many_is_named_in_place_of_the_poses_after_it():
    """Most of 150 poses fit well with their own angles, and eight do not."""
    many = make_scene("vs060", "tracker", poses_per_plane=50, noise=1e-4, seed=9).dataset
    rows = np.arange(many.n_poses)
    source = np.where(rows < many.n_poses - 9, rows, np.clip(rows + 1, 0, rows[-1]))
    with pytest.raises(
        InvalidInput, match=f"from pose {many.pose_ids[-8]} on, each measurement belongs"
    ) as refused:
        calibrate(with_angles_of(many, source))
    assert len(refused.value.faults) == 1
