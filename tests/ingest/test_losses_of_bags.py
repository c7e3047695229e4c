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
PLANES = ("floor", "wall_x", "wall_y")
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
    return Pieces(ROBOT, T_FLANGE_SENSOR, q, points, NORMALS, DISTANCES, PLANES)


def test_a_wrong_sign_of_joint_1_is_named_though_most_scans_keep_a_plane(pieces: Pieces) -> None:
    """If joint 1 counts the other way, scans of the floor still fit, so that most stops are kept; the sign is named all the same."""
    assert np.all(pieces.plane_index() >= 0)
    wrong = replace(pieces, robot=with_sign_changed(ROBOT, 0))
    kept = int(np.count_nonzero(wrong.plane_index() >= 0))
    assert LEAST_KEPT * len(wrong.points) < kept < 0.9 * len(wrong.points)
    said = clearly_better_reading(wrong, NAMES, kept)
    total = len(wrong.points)
    assert said is not None and f"{total} of {total} scans" in said
    assert "with joint 1 (joint_1) counted the other way" in said


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
    """If the floor is 0.2 m from its guess, and the scanner is turned from its stated pose, the guess is named, and no sign and no zero of a joint.

    With such readings many scans come within the farthest distance of some plane, but not near it.
    """
    T_flange_sensor = T_FLANGE_SENSOR.copy()
    T_flange_sensor[:3, :3] = exp_so3(np.array([0.1, 0.0, turn]))
    wrong = replace(pieces, distances=DISTANCES + np.array([off, 0.0, 0.0]), T_flange_sensor=T_flange_sensor)
    assert np.count_nonzero(wrong.plane_index() >= 0) < LEAST_KEPT * len(wrong.points)
    said = better_reading(wrong, NAMES)
    assert said is not None and "with floor at a distance of -0.1" in said and "joint" not in said


def some(pieces: Pieces, floor: int, wall_x: int, wall_y: int) -> Pieces:
    """Return the pieces of a campaign with so many scans of each plane."""
    first = (0, ON_FLOOR, ON_FLOOR + ON_WALLS)
    kept = [
        k for start, n in zip(first, (floor, wall_x, wall_y), strict=True) for k in range(start, start + n)
    ]
    return replace(pieces, q=pieces.q[kept], points=[pieces.points[k] for k in kept])


@pytest.mark.parametrize("off", [-0.3, 0.3, 0.45])
@pytest.mark.parametrize(("wall_x", "wall_y", "far"), [(3, 20, 2), (20, 3, 1)])
def test_a_guess_that_loses_half_of_the_stops_is_named_and_no_zero_of_joint_1(
    pieces: Pieces, wall_x: int, wall_y: int, far: int, off: float
) -> None:
    """With the zero of joint 1 turned by 90 degrees, the scans of the wall with the wrong guess lie on the other wall, which is as far away."""
    distances = DISTANCES.copy()
    distances[far] += off
    wrong = replace(some(pieces, 20, wall_x, wall_y), distances=distances)
    kept = int(np.count_nonzero(wrong.plane_index() >= 0))
    assert LEAST_KEPT <= kept / len(wrong.points) < 0.65
    for said in (better_reading(wrong, NAMES), clearly_better_reading(wrong, NAMES, kept)):
        assert said is not None and f"{PLANES[far]} at a distance of 0.9" in said and "joint" not in said
        assert f"{len(wrong.points)} of {len(wrong.points)} scans" in said
        assert f"in place of {distances[far]:.2f} m: correct the guess" in said


@pytest.mark.parametrize("degrees", [90, -90, 180])
def test_a_wrong_zero_of_joint_1_is_named_before_a_plane(pieces: Pieces, degrees: int) -> None:
    """If the zero is wrong, all scans of walls lie elsewhere, and no other distance of one wall explains them."""
    turned = pieces.q + np.radians(degrees) * np.eye(6)[0]
    said = better_reading(replace(pieces, q=turned), NAMES)
    assert said is not None and f"{(-degrees + 179) % 360 - 179} degrees added to joint 1" in said
