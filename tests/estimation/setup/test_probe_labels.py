"""The measurement of a touch probe is the label of its plane: moving labels and angles together leaves rows out, and explains nothing."""

from dataclasses import replace

import pytest

from scalar.errors import InvalidInput, ScalarError
from scalar.estimation.calibrate import calibrate
from scalar.estimation.setup.alternatives import readings_of_labels
from scalar.estimation.setup.tables.unrelated_rows import rows_apart
from tests.random_scene import make_scene


@pytest.fixture(scope="module")
def touched():
    """Return 72 poses of a probe that touches three planes in turn."""
    return make_scene("vs060", "probe", seed=3, poses_per_plane=24).dataset


@pytest.mark.slow
def test_two_exchanged_labels_are_named(touched):
    """Two early poses have each other's plane. They are named, with the planes on which they lie; no shift of all rows, which leaves them out, is."""
    plane = touched.poses["plane"].tolist()
    plane[4], plane[5] = plane[5], plane[4]
    with pytest.raises(InvalidInput) as refusal:
        calibrate(replace(touched, poses=touched.poses.assign(plane=plane)))
    said = [fault.message for fault in refusal.value.faults]
    ids = touched.pose_ids[4:6]
    assert len(said) == 2 and all(
        f"pose {pose} is said to lie on" in line for pose, line in zip(ids, said, strict=True)
    )


def test_rows_are_not_moved_where_all_labels_recur(touched):
    """With planes in turn, rows that are moved by 3, 6 or 9 have the labels that they had; other shifts are real ones and are tried."""
    shifts = {int(alternative.changed.split()[-2]) for alternative in rows_apart(touched)}
    assert shifts == {2, 4, 5, 7, 8, 10}
    assert readings_of_labels(touched) == (False,)


@pytest.mark.slow
def test_a_wrong_sign_blames_no_single_pose(touched):
    """With a joint that counts the other way and two exchanged labels, a fit to the other poses is centimetres off and proves nothing."""
    plane = touched.poses["plane"].tolist()
    plane[4], plane[5] = plane[5], plane[4]
    changed = touched.poses.assign(plane=plane, q4=-touched.poses["q4"])
    with pytest.raises(ScalarError) as refusal:
        calibrate(replace(touched, poses=changed))
    assert "is said to lie on" not in str(refusal.value)


@pytest.mark.slow
def test_a_row_that_was_written_twice_is_named(touched):
    """A copy of a contact is a doubt of the answer; if it has the label of another plane, the refusal says whose joint angles it has."""
    joints = [f"q{i}" for i in range(1, 7)]
    poses = touched.poses.copy()
    poses.loc[9, [*joints, "plane"]] = poses.loc[3, [*joints, "plane"]]
    calibration = calibrate(replace(touched, poses=poses))
    said = " ".join(entry["sentence"] for entry in calibration.summary["setup"])
    ids = touched.pose_ids
    assert f"poses {ids[3]} and {ids[9]} have the same joint angles" in said
    poses.loc[9, "plane"] = next(name for name in poses["plane"] if name != poses.loc[3, "plane"])
    with pytest.raises(InvalidInput, match=f"or its joint angles, which are those of pose {ids[3]}"):
        calibrate(replace(touched, poses=poses))
