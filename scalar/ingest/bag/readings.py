"""Other readings of a recording: another order, sign or zero of joints, other axes of the scans, or a plane elsewhere."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from scalar.geometry.angles import within_half_turn
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import Array, log_so3
from scalar.ingest.bag.far_guesses import with_far_guesses
from scalar.ingest.bag.straight_scans import Pieces
from scalar.units import DEG

_ZEROS = (90, -90, 180)  # degrees that a table of joints and a controller usually differ by
_BETWEEN_ZEROS = 30  # degrees between zeros from which a fit starts
_LEAST_ZERO = 8 * DEG  # a zero that is less far off is found by a calibration
_AXES = {
    "x of the scan reversed": np.array([[-1.0, 0.0], [0.0, 1.0]]),
    "z of the scan reversed": np.array([[1.0, 0.0], [0.0, -1.0]]),
    "x and z of the scan both reversed": np.array([[-1.0, 0.0], [0.0, -1.0]]),
    "x and z of the scan exchanged": np.array([[0.0, 1.0], [1.0, 0.0]]),
}


@dataclass(frozen=True, eq=False)
class Reading:
    """One other reading of a recording.

    Attributes:
        what: What differs, in words that follow ``with``.
        remedy: How to correct it, in words that follow ``what``; may be empty.
        pieces: The recording under this reading.
        added_cost: What its improbability adds to the cost of its placement.
    """

    what: str
    remedy: str
    pieces: Pieces
    added_cost: float = 0.0

    @property
    def cost(self) -> float:
        """Return the cost by which readings are compared."""
        return self.pieces.placement.cost + self.added_cost


def other_readings(pieces: Pieces, names: Sequence[str]) -> list[Reading]:
    """Return the other readings of a recording, the simplest first; ``names`` are those of the recorded joints in the assumed order."""
    return [
        *_with_planes_elsewhere(pieces),
        *_with_other_orders(pieces, names),
        *_with_other_signs(pieces, names),
        *_with_other_zeros(pieces, names),
        *_with_other_axes(pieces),
    ]


def _with_planes_elsewhere(pieces: Pieces) -> Iterator[Reading]:
    """Yield the readings in which guesses of planes have other distances."""
    for distances, added in with_far_guesses(pieces):
        places = [
            f"{pieces.plane_names[k]} at a distance of {distances[k]:.2f} m in place of {pieces.distances[k]:.2f} m"
            for k in np.flatnonzero(distances != pieces.distances).tolist()
        ]
        remedy = ": correct the guess under planes, if this is that plane and no other surface"
        yield Reading(" and ".join(places), remedy, pieces.read_otherwise(distances=distances), added)


def _with_other_orders(pieces: Pieces, names: Sequence[str]) -> Iterator[Reading]:
    """Yield the readings in which the recorded joints are assigned to q1..qn in another order."""
    for order in dict.fromkeys(_orders(len(names), names)):
        if order != tuple(range(len(names))):
            named = ",".join(names[i] for i in order)
            yield Reading(f"--joint-names {named}", "", pieces.read_otherwise(pieces.q[:, list(order)]))


def _orders(n: int, names: Sequence[str]) -> Iterator[tuple[int, ...]]:
    """Yield likely orders of n joints: alphabetical, reversed, and with two exchanged."""
    yield tuple(sorted(range(n), key=lambda i: names[i]))
    yield tuple(reversed(range(n)))
    for i, j in combinations(range(n), 2):
        order = list(range(n))
        order[i], order[j] = j, i
        yield tuple(order)


def _with_other_signs(pieces: Pieces, names: Sequence[str]) -> Iterator[Reading]:
    """Yield the readings in which one joint counts the other way."""
    for j, name in enumerate(names):
        q = np.where(np.arange(len(names)) == j, -pieces.q, pieces.q)
        what = f"joint {j + 1} ({name}) counted the other way"
        yield Reading(what, _other_way(pieces.robot, j), pieces.read_otherwise(q))


def _other_way(robot: Robot, joint: int) -> str:
    """Return how robot.joints says that a joint (from 0) counts the other way: ``Rz(-q + theta) Tz(d) = Rx(pi) Rz(q - theta) Tz(-d) Rx(-pi)``."""
    first, second = (joint, joint + 1) if robot.standard_dh else (joint + 1, joint + 2)
    before = f"add 3.141593 to alpha of joint {first}" if first else "turn robot.base by pi about its x axis"
    last = second > robot.n_joints
    after = (
        "turn robot.flange by -pi about its x axis" if last else f"subtract it from alpha of joint {second}"
    )
    return f": in robot.joints change the signs of d and theta of joint {joint + 1}, {before}, and {after}"


def _with_other_zeros(pieces: Pieces, names: Sequence[str]) -> Iterator[Reading]:
    """Yield the readings in which the zero of one joint that turns is off by a usual angle."""
    for j in np.flatnonzero(~pieces.robot.slides).tolist():
        for degrees in _ZEROS:
            q = pieces.q + np.where(np.arange(len(names)) == j, degrees * DEG, 0.0)
            what = f"{degrees} degrees added to joint {j + 1} ({names[j]})"
            remedy = f": add {degrees * DEG:.6f} to theta of joint {j + 1} in robot.joints"
            yield Reading(what, remedy + _seen_alike(j, len(names), degrees), pieces.read_otherwise(q))


def readings_with_any_zero(pieces: Pieces, names: Sequence[str]) -> Iterator[Reading]:
    """Yield for every joint that turns the reading in which its zero is where a fit has it.

    The last joint is left out, since a scanner that is turned about its axis explains as much; so are zeros that are hardly off.
    """
    for j in np.flatnonzero(~pieces.robot.slides[:-1]).tolist():
        one = np.arange(len(names)) == j
        starts = np.arange(-180, 180, _BETWEEN_ZEROS) * DEG
        fits = [(start, pieces.read_otherwise(pieces.q + start * one).placed(joint=j)) for start in starts]
        start, placement = min(fits, key=lambda fit: fit[1].cost)
        angle = float(within_half_turn(start + placement.zero))
        if abs(angle) >= _LEAST_ZERO:
            # That of the first joint is determined by the guesses of the planes alone.
            written = f"about {angle / DEG:.0f}" if j == 0 else f"{angle / DEG:.1f}"
            what = f"{written} degrees added to joint {j + 1} ({names[j]})"
            remedy = f": add {angle:.4f} to theta of joint {j + 1} in robot.joints, or correct the zero of its encoder"
            remedy += _seen_alike(j, len(names), round(angle / DEG))
            yield Reading(what, remedy, pieces.read_otherwise(pieces.q + angle * one))


def _seen_alike(joint: int, n: int, degrees: int) -> str:
    """Return which other mistake a recording cannot distinguish from a wrong zero of a joint (from 0), as a remedy; empty if there is none."""
    if joint == n - 1:
        return f", or correct sensor.nominal_pose, if the scanner is mounted turned by {abs(degrees)} degrees about the axis of that joint"
    if joint == 0:
        turned = 180 if degrees == 180 else -degrees
        return f", or turn the guesses of all planes by {turned} degrees about the axis of that joint, if it is the base that stands otherwise"
    return ""


def _with_other_axes(pieces: Pieces) -> Iterator[Reading]:
    """Yield the readings in which axes of the scans are reversed or exchanged."""
    for what, axes in _AXES.items():
        turned = _in_true_axes(pieces.T_flange_sensor[:3, :3], axes)
        numbers = ", ".join(f"{number:.4f}" for number in log_so3(turned))
        remedy = (
            f": correct the rotation in sensor.nominal_pose (rotation_vector: [{numbers}]), if the scanner is mounted so, or else the sign or order "
            "of the axes where the scans are published"
        )
        yield Reading(what, remedy, pieces.read_otherwise(axes=axes))


def _in_true_axes(R: Array, axes: Array) -> Array:
    """Return the orientation ``(3, 3)`` of a scanner whose x and z axes are those of R ``(3, 3)`` after the matrix ``(2, 2)`` of a reading."""
    x, z = (R[:, [0, 2]] @ axes).T
    return np.column_stack([x, np.cross(z, x), z])
