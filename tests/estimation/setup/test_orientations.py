"""Measured orientations that are read in the wrong way are refused, with what they are and what to do."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from scalar.data.dataset import Dataset
from scalar.data.declared import Sensor
from scalar.data.formats import ORIENTATION
from scalar.errors import InvalidInput
from scalar.estimation.calibrate import calibrate
from scalar.estimation.setup.alternatives import with_sign_changed
from scalar.estimation.setup.orientations import disagreement
from tests.estimation.test_scara import LIMITS, nominal
from tests.tracked_targets import drawn_arm


@pytest.fixture(scope="module")
def tracked():
    """Return 40 whole poses of a target, measured in an independent simulation of an arm with errors."""
    rng = np.random.default_rng(8)
    arm = drawn_arm(rng, ("A",))
    return arm.dataset(arm.poses(40, rng), rng, noise=3e-5, turn_noise=1e-4, stated={"noise": 3e-5})


def with_columns(dataset, vectors):
    """Return a dataset whose columns rx,ry,rz are ``vectors`` ``(P, 3)``."""
    return replace(
        dataset, point_columns={**dataset.point_columns, **dict(zip(ORIENTATION, vectors.T, strict=True))}
    )


def rotations(dataset):
    """Return the measured orientations."""
    return Rotation.from_rotvec(np.column_stack([dataset.point_columns[name] for name in ORIENTATION]))


READINGS = {
    "inverse": (lambda R: R.inv().as_rotvec(), "the inverse rotation"),
    "degrees": (lambda R: np.degrees(R.as_rotvec()), "they are in degrees"),
    "kuka": (lambda R: R.as_euler("ZYX")[:, ::-1], "Euler angles about the fixed axes xyz in radians"),
    "moving": (lambda R: R.as_euler("XYZ"), "Euler angles about the moving axes xyz in radians"),
    "wrist": (lambda R: R.as_euler("ZYZ"), "Euler angles about the moving axes zyz in radians"),
    "inverse_kuka": (lambda R: R.inv().as_euler("ZYX")[:, ::-1], "Euler angles about"),
}


def test_orientations_as_they_should_be_are_accepted(tracked):
    """Nothing is said of rotation vectors; the errors of a real arm turn the target by much less than the limit."""
    assert disagreement(tracked) < np.radians(1)
    assert not [e for e in calibrate(tracked).summary["setup"] if e["what"] == "orientation"]


@pytest.mark.parametrize("reading", READINGS)
def test_another_reading_is_named(tracked, reading):
    """The message says what the columns hold, by how much the orientations then differ from the arm's, and what to do."""
    convert, words = READINGS[reading]
    with pytest.raises(InvalidInput, match=f"points.csv.*{words}.*instead of") as refused:
        calibrate(with_columns(tracked, convert(rotations(tracked))))
    assert (
        "write rotation vectors" in str(refused.value)
        or "multiply" in str(refused.value)
        or "change the sign" in str(refused.value)
    )


@pytest.mark.parametrize(
    ("meant", "stated"), [("ZYX", "zyx"), ("zyx", "ZYX"), ("xyz", "XYZ"), ("ZYX", "XYZ")]
)
def test_euler_angles_about_other_axes_than_a_mapping_states_are_named(tracked, meant, stated):
    """What the mapping should state is named, with what it states."""
    angles = rotations(tracked).as_euler(meant)
    read = Rotation.from_euler(stated, angles).as_rotvec()
    with pytest.raises(InvalidInput, match=f"euler_axes: .*{meant} if it states {stated}.* in the mapping"):
        calibrate(with_columns(tracked, read))


def test_orientations_of_something_else_are_refused_if_positions_fit(tracked):
    """Orientations that fit in no reading, although the positions fit, are blamed with both figures, and how to go on without them is said."""
    turned = Rotation.random(len(tracked.points), rng=np.random.default_rng(3))
    with pytest.raises(InvalidInput, match=r"the positions alone fit to 0.* mm.*leave the columns out"):
        calibrate(with_columns(tracked, turned.as_rotvec()))


def test_a_last_joint_that_counts_the_other_way_is_named():
    """Positions of a target near the last axis hardly show its sign; orientations do, and the joint is named, not the columns."""
    rng = np.random.default_rng(9)
    arm = drawn_arm(rng, ("A",))
    dataset = arm.dataset(arm.poses(40, rng), rng, noise=3e-5, turn_noise=1e-4, stated={"noise": 3e-5})
    last = dataset.robot.n_joints
    wrong = replace(dataset, robot=with_sign_changed(dataset.robot, last - 1))
    with pytest.raises(InvalidInput, match=f"joint {last} counts the other way"):
        calibrate(wrong)


@pytest.mark.parametrize(
    ("order", "signs", "words"),
    [((2, 1, 0), (1, 1, 1), "the columns x and z are exchanged"), ((0, 1, 2), (1, -1, 1), "the column y counts the other way")],
)  # fmt: skip
def test_columns_of_positions_are_named_beside_orientations(tracked, order, signs, words):
    """Orientations tell in which way positions are left-handed: the columns are named, and no joints."""
    wrong = replace(tracked, points=tracked.points[:, order] * np.array(signs))
    with pytest.raises(InvalidInput, match=words) as refused:
        calibrate(wrong)
    assert "count the other way" not in str(refused.value).replace(words, "")


@pytest.fixture(scope="module")
def scara():
    """Return 60 whole poses of a target on an arm whose axes are all parallel, which turns it about one direction only."""
    rng = np.random.default_rng(9)
    robot = nominal()
    q = rng.uniform(*LIMITS.T, (60, 4))
    T = robot.flange(q)
    R_tracker, R_target = Rotation.random(rng=rng), Rotation.random(rng=rng)
    offset = np.array([0.03, 0.01, 0.05])
    points = (
        R_tracker.apply(T[:, :3, 3] + T[:, :3, :3] @ offset)
        + [1.0, 2.0, 0.5]
        + 2e-5 * rng.normal(size=(60, 3))
    )
    turned = (
        R_tracker
        * Rotation.from_matrix(T[:, :3, :3])
        * R_target
        * Rotation.from_rotvec(1e-4 * rng.normal(size=(60, 3)))
    )
    guess = np.eye(4)
    guess[:3, 3] = offset
    columns = dict(zip(ORIENTATION, turned.as_rotvec().T, strict=True))
    return Dataset.from_arrays(
        robot=robot, sensor=Sensor("tracker", guess, noise=2e-5), q=q, points=points, point_columns=columns
    )


def test_an_arm_with_parallel_axes_shows_wrong_orientations_by_its_positions(scara):
    """Inverse rotations are those of the same arm before a tracker that lies on its back; only the positions tell it from the true one."""
    assert disagreement(with_columns(scara, rotations(scara).inv().as_rotvec())) < np.radians(1)
    assert not [e for e in calibrate(scara).summary["setup"] if e["what"] == "orientation"]
    with pytest.raises(InvalidInput, match="the inverse rotation"):
        calibrate(with_columns(scara, rotations(scara).inv().as_rotvec()))
    swapped = Rotation.from_euler(
        "ZYX", rotations(scara).as_euler("zyx")
    )  # another convention than that of the file
    with pytest.raises(InvalidInput, match="zyx if it states ZYX"):
        calibrate(with_columns(scara, swapped.as_rotvec()))


def test_swapped_euler_angles_are_not_called_the_inverse(tracked):
    """Angles A and C exchanged are the inverse rotations between other frames; with the tracker's axes that the positions show they are neither."""
    angles = rotations(tracked).as_euler("ZYX")[:, ::-1]
    with pytest.raises(InvalidInput) as refused:
        calibrate(with_columns(tracked, Rotation.from_euler("ZYX", angles).as_rotvec()))
    assert "inverse" not in str(refused.value)


@pytest.mark.parametrize(
    ("shift", "words"), [(1, "qw,qx,qy,qz and were read as"), (-1, "qx,qy,qz,qw and were read as")]
)
def test_quaternions_whose_columns_were_exchanged_are_named(tracked, shift, words):
    """Their orientations are the inverse ones in other frames, and the positions show which of the three readings is right."""
    swapped = Rotation.from_quat(np.roll(rotations(tracked).as_quat(), shift, axis=1)).as_rotvec()
    with pytest.raises(InvalidInput, match=f"quaternions whose columns are {words}"):
        calibrate(with_columns(tracked, swapped))


def test_whole_poses_that_are_inverse_are_named(tracked):
    """Poses of the tracker in the target's frame are inverse in their places as well, and to change the signs of the orientations is not enough."""
    R = rotations(tracked).inv()
    inverse = replace(with_columns(tracked, R.as_rotvec()), points=-R.apply(tracked.points))
    with pytest.raises(
        InvalidInput, match="x,y,z,rx,ry,rz: these are the poses of the tracker in the frame of the target"
    ):
        calibrate(inverse)
