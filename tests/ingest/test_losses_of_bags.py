"""Another reading of a recording is named where it explains the scans far better, and none where stops are lost, or the arm is wrong, in any case."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from scalar.estimation.setup.alternatives import with_sign_changed
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import exp_so3
from scalar.ingest.bag.better_reading import better_reading
from scalar.ingest.bag.straight_scans import Pieces
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


def roughly(pieces: Pieces) -> Pieces:
    """Return the pieces with guesses as a person makes them: the scanner 7 degrees and 2 cm off, planes 3 degrees and 3 cm."""
    T = T_FLANGE_SENSOR.copy()
    T[:3, :3] = exp_so3(np.radians([4.0, -3.0, 5.0]))
    T[:3, 3] += 0.01, -0.015, 0.01
    tilted = NORMALS @ exp_so3(np.radians([2.0, -2.0, 1.5])).T
    return replace(
        pieces, T_flange_sensor=T, normals=tilted, distances=DISTANCES + np.array([0.03, -0.03, 0.02])
    )


def true_planes() -> np.ndarray:
    """Return the plane of each scan of ``pieces``."""
    return np.repeat([0, 1, 2], [ON_FLOOR, ON_WALLS, ON_WALLS])


def said_of(pieces: Pieces) -> tuple[str, ...]:
    """Return the sentences on other readings; none if none is better."""
    found = better_reading(pieces, NAMES)
    return () if found is None else found.sentences


def test_rough_guesses_are_no_wrong_reading(pieces: Pieces) -> None:
    """Every scan is assigned to its plane, and no other reading is named."""
    rough = roughly(pieces)
    np.testing.assert_array_equal(rough.plane_index(), true_planes())
    assert said_of(rough) == ()


def test_a_wrong_sign_of_joint_1_is_named_though_most_scans_keep_a_plane(pieces: Pieces) -> None:
    """If joint 1 counts the other way, scans of the floor still fit, so that most stops are kept; the sign is named all the same."""
    wrong = replace(pieces, robot=with_sign_changed(ROBOT, 0))
    assert wrong.labels.count > 0.5 * len(wrong.points)
    (said,) = said_of(wrong)
    total = len(wrong.points)
    assert f"{total} of {total} scans" in said and "with joint 1 (joint_1) counted the other way" in said


@pytest.mark.parametrize("joint", range(6))
def test_a_joint_that_counts_the_other_way_is_named(pieces: Pieces, joint: int) -> None:
    q = pieces.q * np.where(np.arange(6) == joint, -1.0, 1.0)
    (said,) = said_of(replace(roughly(pieces), q=q))
    assert f"with joint {joint + 1} (joint_{joint + 1}) counted the other way" in said


@pytest.mark.parametrize("joint", range(6))
@pytest.mark.parametrize("degrees", [90, 180])
def test_a_wrong_zero_is_named(pieces: Pieces, joint: int, degrees: int) -> None:
    """A wrong zero of the last joint looks like a turned scanner: one sentence names both, and half a turn may be a reversed axis as well."""
    said = said_of(replace(roughly(pieces), q=pieces.q + np.radians(degrees) * np.eye(6)[joint]))
    back = 180 if degrees == 180 else -degrees
    assert any(f"with {back} degrees added to joint {joint + 1} (joint_{joint + 1})" in one for one in said)
    assert len(said) == 1 or (joint == 5 and degrees == 180)
    if joint == 5:
        assert any("or correct sensor.nominal_pose" in one for one in said)


def test_a_reading_that_leaves_the_scanner_turned_says_so(pieces: Pieces) -> None:
    """If the sign of joint 2 and the zero of joint 6 are both wrong, the sign is named, and the turn of the scanner that the zero looks like."""
    q = (pieces.q + np.radians(90.0) * np.eye(6)[5]) * np.where(np.arange(6) == 1, -1.0, 1.0)
    (said,) = said_of(replace(roughly(pieces), q=q))
    assert "joint 2 (joint_2) counted the other way" in said
    assert "which may be a second mistake" in said


@pytest.mark.parametrize(("joint", "degrees"), [(1, 20.0), (2, -38.0), (3, 140.0), (4, 64.0)])
def test_a_zero_between_right_angles_is_named(pieces: Pieces, joint: int, degrees: float) -> None:
    """The zero of a joint is fitted together with scanner and planes where no simpler reading explains the scans."""
    (said,) = said_of(replace(roughly(pieces), q=pieces.q + np.radians(degrees) * np.eye(6)[joint]))
    words, _, rest = said.partition(" with ")[2].partition(" degrees added to ")
    assert float(words) == pytest.approx(-degrees, abs=0.5) and rest.startswith(f"joint {joint + 1} ")


@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        (np.diag([-1.0, 1.0]), "x of the scan reversed"),
        (np.diag([1.0, -1.0]), "z of the scan reversed"),
        (np.array([[0.0, 1.0], [1.0, 0.0]]), "x and z of the scan exchanged"),
    ],
)
def test_axes_of_the_scan_are_named_with_the_rotation_that_corrects_them(
    pieces: Pieces, wrong: np.ndarray, says: str
) -> None:
    """With the rotation that the sentence states, the scans are assigned to their planes, and nothing more is named."""
    rough = replace(roughly(pieces), points=[points @ wrong for points in pieces.points])
    (said,) = (one for one in said_of(rough) if says in one)
    numbers = said.split("rotation_vector: [")[1].split("]")[0]
    corrected = rough.T_flange_sensor.copy()
    corrected[:3, :3] = exp_so3(np.array([float(number) for number in numbers.split(",")]))
    right = replace(rough, T_flange_sensor=corrected)
    np.testing.assert_array_equal(right.plane_index(), true_planes())
    assert said_of(right) == ()


def test_a_reversed_x_axis_is_distinguished_from_a_zero_by_the_place_of_the_scanner(pieces: Pieces) -> None:
    """A scanner far from the axis of the last joint would sit on its other side if the zero of that joint were wrong."""
    aside = np.array([0.25, 0.0, 0.0])
    T = T_FLANGE_SENSOR.copy()
    T[:3, 3] += aside
    # The points that a scanner sees that is shifted along its own x axis.
    shifted = replace(pieces, T_flange_sensor=T, points=[points - aside[[0, 2]] for points in pieces.points])
    assert said_of(shifted) == ()
    (said,) = said_of(replace(shifted, points=[points * [-1.0, 1.0] for points in shifted.points]))
    assert "with x of the scan reversed" in said


def test_stops_that_are_lost_in_any_case_name_nothing(pieces: Pieces) -> None:
    """If a fifth of the stops are above no plane, no other reading keeps them, and none is named."""
    points = [scan + np.array([0.0, 0.4]) if k % 5 == 0 else scan for k, scan in enumerate(pieces.points)]
    lossy = replace(pieces, points=points)
    assert lossy.labels.count < 0.9 * len(points)
    assert said_of(lossy) == ()


@pytest.mark.parametrize(("row", "joint", "off"), [(0, 2, 0.06), (2, 3, -0.08), (1, 3, 0.2)])
def test_a_wrong_number_in_the_table_is_no_wrong_sign(
    pieces: Pieces, row: int, joint: int, off: float
) -> None:
    """A length or an angle of the table that is wrong leaves centimetres, and no reading of signs, zeros or axes is named for it."""
    geometry = ROBOT.geometry.copy()
    geometry[row, joint] += off
    assert said_of(replace(roughly(pieces), robot=ROBOT.with_geometry(geometry))) == ()


@pytest.mark.parametrize(("off", "turn"), [(0.2, 0.3), (-0.2, 0.5)])
def test_a_wrong_guess_of_a_plane_is_not_taken_for_a_wrong_joint(
    pieces: Pieces, off: float, turn: float
) -> None:
    """If the floor is 0.2 m from its guess, and the scanner is turned from its stated pose, the planes are found, or the guess is named."""
    T_flange_sensor = T_FLANGE_SENSOR.copy()
    T_flange_sensor[:3, :3] = exp_so3(np.array([0.1, 0.0, turn]))
    wrong = replace(pieces, distances=DISTANCES + np.array([off, 0.0, 0.0]), T_flange_sensor=T_flange_sensor)
    if said := said_of(wrong):
        assert all("with floor at a distance of -0.1" in one and "joint" not in one for one in said)
    else:
        np.testing.assert_array_equal(wrong.plane_index(), true_planes())


def some(pieces: Pieces, floor: int, wall_x: int, wall_y: int) -> Pieces:
    """Return the pieces of a campaign with so many scans of each plane."""
    first = (0, ON_FLOOR, ON_FLOOR + ON_WALLS)
    kept = [
        k for start, n in zip(first, (floor, wall_x, wall_y), strict=True) for k in range(start, start + n)
    ]
    return replace(pieces, q=pieces.q[kept], points=[pieces.points[k] for k in kept])


@pytest.mark.parametrize("off", [-0.3, 0.3, 0.45, 0.7])
@pytest.mark.parametrize(("wall_x", "wall_y", "far"), [(3, 20, 2), (20, 3, 1)])
def test_a_guess_that_is_far_off_is_named_and_no_zero_of_joint_1(
    pieces: Pieces, wall_x: int, wall_y: int, far: int, off: float
) -> None:
    """With the zero of joint 1 turned by 90 degrees, the scans of the wall with the wrong guess lie on the other wall, which is as far away.

    A guess that is 0.3 m off may be corrected by the scans themselves; then nothing is named.
    """
    distances = DISTANCES.copy()
    distances[far] += off
    wrong = replace(some(pieces, 20, wall_x, wall_y), distances=distances)
    said = said_of(wrong)
    if not said and abs(off) == 0.3:
        np.testing.assert_array_equal(wrong.plane_index(), np.repeat([0, 1, 2], [20, wall_x, wall_y]))
        return
    (sentence,) = said
    assert f"{PLANES[far]} at a distance of 0.9" in sentence and "joint" not in sentence
    assert f"{len(wrong.points)} of {len(wrong.points)} scans" in sentence
    assert f"in place of {distances[far]:.2f} m: correct the guess" in sentence


@pytest.mark.parametrize("degrees", [90, -90, 180])
def test_a_wrong_zero_of_joint_1_is_named_before_a_plane(pieces: Pieces, degrees: int) -> None:
    """If the zero is wrong, all scans of walls lie elsewhere, and no other distance of one wall explains them."""
    turned = pieces.q + np.radians(degrees) * np.eye(6)[0]
    (said,) = said_of(replace(pieces, q=turned))
    assert f"{(-degrees + 179) % 360 - 179} degrees added to joint 1" in said
    assert "or turn the guesses of all planes" in said
