"""Boards that were recognised the wrong way round, and positions of a camera that was told the wrong size of its board."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from scalar.data.formats import ORIENTATION
from scalar.diagnosis.diagnose import diagnose
from scalar.errors import InvalidInput
from scalar.estimation.calibrate import calibrate
from scalar.estimation.settings import DEFAULTS
from scalar.estimation.turned_orientations import not_turned, turned_by
from scalar.geometry.robot import Tolerance
from tests.tracked_targets import drawn_arm

TURNED = [5, 17, 31]


@pytest.fixture(scope="module")
def tracked():
    """Return 40 whole poses, measured in an independent simulation of an arm with errors."""
    rng = np.random.default_rng(21)
    arm = drawn_arm(rng, ("A",))
    return arm.dataset(arm.poses(40, rng), rng, noise=2e-4, turn_noise=1e-3, stated={"noise": 2e-4})


def turned(dataset, rows, angle):
    """Return a dataset in which the frame of the board, at the mean of what was measured, is turned about its z axis at some poses."""
    about = Rotation.from_rotvec([0.0, 0.0, angle])
    points, vectors = (
        dataset.points.copy(),
        np.column_stack([dataset.point_columns[name] for name in ORIENTATION]),
    )
    middle = points.mean(axis=0)
    points[rows] = about.apply(points[rows] - middle) + middle
    vectors[rows] = (about * Rotation.from_rotvec(vectors[rows])).as_rotvec()
    columns = {**dataset.point_columns, **dict(zip(ORIENTATION, vectors.T, strict=True))}
    return replace(dataset, points=points, point_columns=columns)


def everything(dataset):
    """Return that all poses are usable, ``(N,)`` bool."""
    return np.ones(dataset.n_poses, dtype=bool)


def test_poses_that_are_turned_are_found_with_their_angle(tracked):
    """By half a turn and by a quarter; none is found where nothing is turned."""
    assert not turned_by(tracked, everything(tracked), DEFAULTS.gross_errors).any()
    for angle in (np.pi, np.pi / 2):
        found = turned_by(turned(tracked, TURNED, angle), everything(tracked), DEFAULTS.gross_errors)
        assert list(np.flatnonzero(found)) == TURNED
        np.testing.assert_allclose(found[TURNED], angle, atol=np.radians(3))


def test_many_or_successive_turned_poses_are_left_to_other_explanations(tracked):
    """Half of the poses, and five in a row: rows may be shifted there, or read in another way."""
    for rows in (np.arange(0, 40, 2), np.arange(20, 25)):
        changed = turned(tracked, rows, np.pi)
        assert not_turned(changed, everything(changed), DEFAULTS.gross_errors).all()


def test_a_calibration_names_the_poses_of_a_board_seen_the_wrong_way_round(tracked):
    """Each is named with its cause, and none of the others."""
    with pytest.raises(InvalidInput, match="half a turn") as refused:
        calibrate(turned(tracked, TURNED, np.pi))
    named = [fault.message.split(":")[0] for fault in refused.value.faults]
    assert named == [f"pose {tracked.pose_ids[row]}" for row in TURNED]


def test_a_diagnosis_sets_them_aside(tracked):
    """These poses, and no other."""
    found = diagnose(turned(tracked, TURNED, np.pi))
    assert sorted(found.cleaned.outlier_poses) == [tracked.pose_ids[row] for row in TURNED]


@pytest.mark.parametrize("factor", [0.55, 1.4])
def test_the_wrong_size_of_a_board_is_named_with_the_factor(tracked, factor):
    """The maker's tolerance of the arm allows no length to take the factor up; also beside views of the board the wrong way round."""
    arm = replace(tracked.robot, tolerance=Tolerance(5e-4, 5e-4))
    scaled = replace(tracked, robot=arm, points=tracked.points * factor)
    size = "small" if factor < 1 else "large"
    for refuses, dataset in ((calibrate, scaled), (diagnose, turned(scaled, TURNED, np.pi))):
        with pytest.raises(InvalidInput, match=f"all measured positions are .* times too {size}") as refused:
            refuses(dataset)
        stated = float(str(refused.value).split("multiplied by ")[1].split()[0])
        assert stated == pytest.approx(1 / factor, rel=0.02)
