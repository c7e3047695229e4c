"""Why stops of a recording are lost: another reading is named where it loses few of them, and none where stops are lost in any case."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from scalar.estimation.setup.alternatives import with_sign_changed
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import exp_so3
from scalar.ingest.bag.losses import LEAST_KEPT, Pieces, better_reading, clearly_better_reading
from scalar.robots import read_arm
from tests.kinematics import chain

ROBOT = Robot.from_mapping(read_arm("denso_vs060").mapping)
NAMES = tuple(f"joint_{i + 1}" for i in range(6))
NORMALS, DISTANCES = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]), np.array([-0.1, 0.9, 0.9])
T_FLANGE_SENSOR = np.eye(4)
T_FLANGE_SENSOR[:3, 3] = 0.03, 0.01, 0.08
FAN = np.linspace(-0.3, 0.3, 15)
DIRECTIONS = np.stack([np.sin(FAN), np.cos(FAN)], axis=1)  # x and z of the scanner
ON_FLOOR, ON_WALLS = 60, 20


@pytest.fixture(scope="module")
def pieces() -> Pieces:
    """Return scans of a floor and two walls by an arm as it is described; most are of the floor."""
    rng = np.random.default_rng(2)
    wanted = {0: ON_FLOOR, 1: ON_WALLS, 2: ON_WALLS}
    found: dict[int, list[tuple[np.ndarray, np.ndarray]]] = {0: [], 1: [], 2: []}
    while any(len(found[k]) < n for k, n in wanted.items()):
        q = rng.uniform(*ROBOT.limits.T)
        T = chain(ROBOT.geometry, q[None], ROBOT.T_base_0)[0] @ ROBOT.T_n_flange @ T_FLANGE_SENSOR
        rays = DIRECTIONS[:, :1] * T[:3, 0] + DIRECTIONS[:, 1:] * T[:3, 2]
        with np.errstate(divide="ignore"):
            reach = (DISTANCES - T[:3, 3] @ NORMALS.T) / (rays @ NORMALS.T)
        seen = np.flatnonzero(np.all((reach > 0.1) & (reach < 0.6), axis=0))
        if len(seen) == 1 and len(found[seen[0]]) < wanted[seen[0]]:
            found[seen[0]].append((q, reach[:, seen[0], None] * DIRECTIONS))
    every = [scan for k in found for scan in found[k]]
    q, points = np.array([q for q, _ in every]), [points for _, points in every]
    return Pieces(ROBOT, T_FLANGE_SENSOR, q, points, NORMALS, DISTANCES)


def test_a_wrong_sign_of_joint_1_is_named_though_most_scans_keep_a_plane(pieces: Pieces) -> None:
    """If joint 1 counts the other way, scans of the floor still fit, so that most stops are kept; the sign is named all the same."""
    assert np.all(pieces.plane_index() >= 0)
    wrong = replace(pieces, robot=with_sign_changed(ROBOT, 0))
    kept = int(np.count_nonzero(wrong.plane_index() >= 0))
    assert LEAST_KEPT * len(wrong.points) < kept < 0.9 * len(wrong.points)
    said = clearly_better_reading(wrong, NAMES, kept)
    assert said is not None and f"joint 1 (joint_1) counted the other way {len(wrong.points)} of" in said


def test_stops_that_are_lost_in_any_case_name_nothing(pieces: Pieces) -> None:
    """If a fifth of the stops are above no plane, no other reading keeps them, and none is named."""
    points = [scan + np.array([0.0, 0.4]) if k % 5 == 0 else scan for k, scan in enumerate(pieces.points)]
    lossy = replace(pieces, points=points)
    kept = int(np.count_nonzero(lossy.plane_index() >= 0))
    assert kept < 0.9 * len(points)
    assert clearly_better_reading(lossy, NAMES, kept) is None


@pytest.mark.parametrize(("off", "turn"), [(0.2, 0.3), (-0.2, 0.5)])
def test_a_wrong_guess_of_a_plane_is_not_taken_for_a_wrong_joint(
    pieces: Pieces, off: float, turn: float
) -> None:
    """If the floor is 0.2 m from its guess, and the scanner is turned from its stated pose, no sign and no zero of a joint is named.

    With such readings many scans come within the farthest distance of some plane, but not near it.
    """
    T_flange_sensor = T_FLANGE_SENSOR.copy()
    T_flange_sensor[:3, :3] = exp_so3(np.array([0.1, 0.0, turn]))
    wrong = replace(pieces, distances=DISTANCES + np.array([off, 0.0, 0.0]), T_flange_sensor=T_flange_sensor)
    assert np.count_nonzero(wrong.plane_index() >= 0) < LEAST_KEPT * len(wrong.points)
    assert better_reading(wrong, NAMES) is None
