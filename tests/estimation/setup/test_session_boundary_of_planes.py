"""A session that begins too late or too early is named where target planes are scanned one after the other, or in turn."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from scalar.diagnosis import diagnose
from scalar.effects.plane_moved import PlaneMoved
from scalar.estimation.calibrate import calibrate
from scalar.estimation.gross_errors import clean
from scalar.estimation.setup.sessions.session_boundary import boundaries_near_changes, misplaced_boundaries
from tests.random_scene import make_scene

EACH = 20  # poses on each plane before the planes were moved, and as many after it
MOVED_AT = 3 * EACH  # row
SHIFTS = np.array([0.02, -0.015, 0.025])  # m, of the planes along their normals


def moved_planes(*, one_after_the_other):
    """Return scans of three planes that were moved after half of the poses, without a column ``session``."""
    scene = make_scene("vs060", "line-laser", poses_per_plane=2 * EACH, seed=7)
    dataset, index = scene.dataset, scene.dataset.plane_index
    order = np.arange(dataset.n_poses)
    if one_after_the_other:
        order = np.concatenate(
            [np.flatnonzero(index == k)[half * EACH :][:EACH] for half in (0, 1) for k in range(3)]
        )
    T, normals = scene.truth.sensor(dataset.q), scene.truth.normals[index]
    points = dataset.points.copy()
    for i in order[
        MOVED_AT:
    ]:  # a plane that moves along its normal shifts the points of a scan along the sensor's z
        points[dataset.starts[i] : dataset.starts[i + 1], 1] += SHIFTS[index[i]] / (normals[i] @ T[i, :3, 2])
    scans = [points[dataset.starts[i] : dataset.starts[i + 1]] for i in order]
    poses = dataset.poses.iloc[order].reset_index(drop=True)
    poses["pose"] = np.arange(1, len(poses) + 1)
    starts = np.r_[0, np.cumsum([len(scan) for scan in scans])]
    return replace(dataset, poses=poses, points=np.concatenate(scans), starts=starts)


@pytest.fixture(scope="module")
def in_blocks():
    """Return the scans of planes one after the other."""
    return moved_planes(one_after_the_other=True)


def changing_at(dataset, row):
    """Return the dataset with the column ``session`` changing at a row."""
    session = np.where(np.arange(dataset.n_poses) < row, "one", "two")
    return replace(dataset, poses=dataset.poses.assign(session=session))


@pytest.mark.parametrize("late", [8, EACH, EACH + 6])
def test_a_late_boundary_is_said_where_the_next_session_lacks_the_plane(in_blocks, late):
    """If all poses of a plane in the second session are labelled with the first, no plane of that session is known: it is fitted to them."""
    stated = changing_at(in_blocks, MOVED_AT + late)
    rows = np.arange(stated.n_poses)
    off = (rows >= MOVED_AT) & (rows < MOVED_AT + late)
    model = calibrate(stated.subset(~off)).model
    (suspicion,) = misplaced_boundaries(stated, set(stated.pose_ids[off].tolist()), model)
    assert "too late" in suspicion.sentence and f"change at pose {MOVED_AT + 1} " in suspicion.sentence
    assert suspicion.rms_after < 2e-4 < suspicion.rms_before


def test_gross_errors_lie_on_no_plane_of_their_own(in_blocks):
    """Poses with random errors are not called those of another session, although the plane that is fitted to them is free."""
    stated = changing_at(in_blocks, MOVED_AT + EACH)
    rows = np.arange(stated.n_poses)
    off = (rows >= MOVED_AT) & (rows < MOVED_AT + EACH)
    model = calibrate(stated.subset(~off)).model
    points, rng = stated.points.copy(), np.random.default_rng(2)
    for i in np.flatnonzero(off):
        points[stated.starts[i] : stated.starts[i + 1], 1] += 0.03 * rng.normal()
    wrong = replace(stated, points=points)
    assert misplaced_boundaries(wrong, set(stated.pose_ids[off].tolist()), model) == []


def test_poses_on_the_same_plane_of_another_session_are_not_mislabelled():
    """A pose that lies where its own plane stands in the other session has the right label: it is set aside, and its session is said to be wrong."""
    cleaned = clean(changing_at(moved_planes(one_after_the_other=False), MOVED_AT + 8))
    assert cleaned.mislabelled_poses == ()
    assert cleaned.outlier_poses == tuple(range(MOVED_AT + 1, MOVED_AT + 9))


def test_a_wrong_label_is_found_within_its_session(in_blocks):
    """With two sessions, the plane on which a mislabelled pose lies is still named."""
    dataset = changing_at(in_blocks, MOVED_AT)
    labels = dataset.poses["plane"].to_numpy(dtype=object).copy()
    labels[[3, MOVED_AT + 5]] = ["wall_x", "wall_y"]
    cleaned = clean(replace(dataset, poses=dataset.poses.assign(plane=labels)))
    assert cleaned.mislabelled_poses == ((4, "floor"), (MOVED_AT + 6, "floor"))


@pytest.mark.parametrize(
    ("boundary", "words"),
    [(68, ["8 poses before", "at pose 69", "too late", "pose 61,"]), (52, ["8 poses after", "too early"]), (60, []), (90, [])],
)  # fmt: skip
def test_a_movement_close_to_a_boundary_may_be_that_boundary(in_blocks, boundary, words):
    """A change at the last or first fifth of a session is said to be perhaps the session's own; one at its boundary, or far from it, is not."""
    stated = changing_at(in_blocks, boundary)
    told = [
        s.sentence
        for s in boundaries_near_changes(stated, [PlaneMoved("floor", 60.0, None, (0.0, 0.0, 0.0))])
    ]
    assert len(told) == bool(words)
    assert all(word in told[0] for word in words)
    assert boundaries_near_changes(in_blocks, [PlaneMoved("floor", 60.0, None, (0.0, 0.0, 0.0))]) == []


@pytest.mark.slow
def test_a_diagnosis_of_planes_in_blocks_says_that_the_boundary_is_late(in_blocks):
    """The movement that is found for the poses between is said to be perhaps that of all planes."""
    diagnosis = diagnose(changing_at(in_blocks, MOVED_AT + 8))
    sentences = [entry["sentence"] for entry in diagnosis.calibration_after.summary["setup"]]
    assert any("the session changes too late; let it change at pose 61" in told for told in sentences)
