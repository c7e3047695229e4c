"""A target that returns to places whose coordinates are stated, as a ball on the flange that is put into the sockets of a plate."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from scalar import calibrate
from scalar.errors import InvalidInput
from scalar.estimation.gross_errors import clean
from scalar.estimation.pose_consistency import best_fitting, places_returned_to
from scalar.estimation.settings import DEFAULTS
from tests.kinematics import joint_names
from tests.random_scene import make_scene

SOCKETS = np.array([[0.1, 0.2, 0.3], [0.13, 0.232, 0.324]])  # m, in the frame of the plate
PLAY = 1e-4  # m, of the ball in its socket along each axis


def in_sockets(seed, counts=((12, 12), (12, 12), (12, 12))):
    """Return a tracked VS060 whose ball stands in the two sockets of a plate, ``counts`` poses in each, at one place of the plate after another.

    The angles are those at which the true arm reaches the ball's place, found by the tests' own kinematics.
    """
    made = make_scene("vs060", "tracker", seed=seed, poses_per_plane=12, noise=PLAY, angle_error=2e-3)
    rng, truth = np.random.default_rng(seed), made.truth
    rows, points, sessions = [], [], []
    starts = iter(made.dataset.q)
    for session, per_socket in enumerate(counts):
        near = next(starts)
        T_base_plate = truth.sensor(near[None])[0]
        for socket, count in zip(SOCKETS - SOCKETS[0], per_socket, strict=True):
            place = T_base_plate[:3, :3] @ socket + T_base_plate[:3, 3]
            for _ in range(count):
                rows.append(_reaching(truth, place + rng.normal(0.0, PLAY, 3), near, rng))
                points.append(socket + SOCKETS[0])
                sessions.append(f"place-{session}")
    frame = pd.DataFrame(np.array(rows), columns=joint_names(6))
    frame.insert(0, "pose", np.arange(1, len(rows) + 1))
    frame["session"] = sessions
    return replace(made.dataset, poses=frame, points=np.array(points), starts=np.arange(len(rows) + 1))


def _reaching(truth, place, near, rng):
    """Return joint angles ``(6,)`` [rad], not far from ``near``, with which the ball reaches a place ``(3,)`` [m] of the base frame: Newton's."""
    step = 1e-6 * np.vstack([np.zeros(6), np.eye(6)])
    while True:
        q = near + rng.uniform(-0.7, 0.7, 6)
        for _ in range(12):
            at = truth.sensor(q + step)[:, :3, 3]
            jacobian = (at[1:] - at[0]).T / 1e-6
            q = q + np.linalg.lstsq(jacobian, place - at[0], rcond=1e-3)[0]
        if np.abs(at[0] - place).max() < 1e-9 and np.abs(q - near).max() < 2.0:
            return q


@pytest.fixture(scope="module")
def sockets():
    return in_sockets(1)


def test_poses_at_either_place_are_trusted_at_first(sockets):
    """Of the poses in each socket of each session half and more are trusted, however much farther off those in one of the sockets are."""
    index = places_returned_to(sockets)
    assert len(np.unique(index)) == 6 and np.bincount(index)[1:].tolist() == [12] * 6
    distance = np.where(index == index[0], 1.0, 1e-4)
    core = best_fitting(sockets, distance, np.ones(len(index), dtype=bool), DEFAULTS.gross_errors)
    assert (np.bincount(index[core])[1:] >= 6).all()


def test_readings_that_differ_are_of_no_place(sockets):
    """A tracker's readings differ by their noise; and a reading that a tracker repeats, having lost its target, is no place either."""
    noisy = replace(sockets, points=sockets.points + np.random.default_rng(2).normal(0, 1e-5, (72, 3)))
    assert not places_returned_to(noisy).any()
    stale = noisy.points.copy()
    stale[10:20] = stale[10]
    assert not places_returned_to(replace(noisy, points=stale)).any()


def test_no_pose_in_a_socket_is_set_aside(sockets):
    """The plate may be turned about the line of its sockets as it likes; the rest is determined, and all poses agree."""
    assert not clean(sockets).outlier_poses
    calibration = calibrate(sockets)
    assert calibration.residual_rms < 3 * PLAY
    assert not any("multiple of" in suspicion["sentence"] for suspicion in calibration.summary["setup"])


def test_places_may_have_a_coordinate_in_common_and_readings_may_not(sockets):
    """In a frame along the line of its sockets, the plate's places differ in one coordinate; a column that a log filled in has one value too."""
    along = np.where(sockets.points[:, :1] == SOCKETS[0, 0], [[0.1, 0.0, 0.0]], [[0.15, 0.0, 0.0]])
    expected = calibrate(sockets).residual_rms
    assert calibrate(replace(sockets, points=along)).residual_rms == pytest.approx(expected, rel=1e-3)
    measured = make_scene("vs060", "tracker", seed=1, poses_per_plane=12).dataset
    filled_in = replace(measured, points=measured.points * [1.0, 1.0, 0.0])
    with pytest.raises(InvalidInput, match="column z: every value is 0 m"):
        calibrate(filled_in)
