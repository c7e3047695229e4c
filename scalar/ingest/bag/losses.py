"""Explain why stops of a recording became no poses: the most frequent reason, and a reading of the joints or of the scan's axes that would fit."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from scalar.geometry.robot import Robot
from scalar.geometry.se3 import Array
from scalar.ingest.bag.far_guesses import with_far_guesses
from scalar.ingest.bag.labels import FARTHEST, Labels, label_scans
from scalar.units import DEG

LEAST_KEPT = 0.5
"""Least share of the stops that have to become poses. Chosen: stops between poses are few, and with a wrong order of joints hardly any scan is on a
plane."""
_ENOUGH = 0.8  # another order, or other axes, are suggested only if at least this share of the pieces then lies on planes
_FEW_LOST = 0.1  # share of the pieces on no plane up to which no other reading is looked for: stops on the way are lost in any case
# Another reading is suggested only if at most this share of these pieces lies on no plane with it either.
_STILL_LOST = 1.0 / 3.0
_CLOSE = 0.02
"""[m] A reading is suggested only if half of its scans are as near to their planes, as fitted. Chosen: with a nominal_pose that was wrong by 17 to 20
degrees the true reading left 9 to 14 mm, and a false one that put 84 of 90 scans within FARTHEST of a plane, whose guess was wrong, left 31 mm."""
_AXES = {
    "x of the scan reversed": np.array([[-1.0, 0.0], [0.0, 1.0]]),
    "z of the scan reversed": np.array([[1.0, 0.0], [0.0, -1.0]]),
    "x and z of the scan both reversed": np.array([[-1.0, 0.0], [0.0, -1.0]]),
    "x and z of the scan exchanged": np.array([[0.0, 1.0], [1.0, 0.0]]),
}
_REMEDIES = {
    "without a scan": "record the scanner all the time, stop longer than a scan takes, and check that the stamps of both topics are of one clock",
    "without a straight piece in the scan": (
        "check that the scanner sees 2 cm or more of a target plane there, that its topic is in metres, and that sensor.noise is not too small"
    ),
    "on no plane, or near two": (
        "check the order of the joints (--joint-names), whether each counts in the direction and from the zero that robot.joints states, "
        f"sensor.nominal_pose with the direction of its axes, and the guesses of the planes, which may be off by {FARTHEST:g} m"
    ),
}


@dataclass(frozen=True)
class StopCounts:
    """How many stops of a recording became poses, and why the others did not.

    Attributes:
        still: Number of moments at which the arm stood still.
        without_scan: Of these, moments without a scan.
        without_piece: Scans without a straight piece.
        without_plane: Pieces near no plane, or near two.
        joint_names: Names of the recorded joints in the order in which they became q1..qn.
    """

    still: int
    without_scan: int
    without_piece: int
    without_plane: int
    joint_names: tuple[str, ...]

    @property
    def kept(self) -> int:
        """Return the number of stops that became poses."""
        return self.still - self.without_scan - self.without_piece - self.without_plane

    @property
    def reasons(self) -> dict[str, int]:
        """Return the number of stops that were left out for each reason, the most frequent first."""
        counts = (self.without_scan, self.without_piece, self.without_plane)
        found = zip(_REMEDIES, counts, strict=True)
        return dict(sorted(((why, n) for why, n in found if n), key=lambda entry: -entry[1]))

    def sentence(self, more: str = "") -> str:
        """Return a message: how many stops became poses, the text `more`, why the others did not, and what to try."""
        reasons = self.reasons
        listed = ", ".join(f"{n} {why}" for why, n in reasons.items())
        left = f" (left out: {listed})" if reasons else ""
        first = next(iter(reasons), "on no plane, or near two")
        return f"{self.kept} of {self.still} stops became poses{left}{more}: {_REMEDIES[first]}"


@dataclass(frozen=True, eq=False)
class Pieces:
    """Straight pieces of scans, one of each stop, and the planes on which they are expected to lie.

    Attributes:
        robot: The nominal robot.
        T_flange_sensor: ``(4, 4)``, the scanner's nominal pose.
        q: ``(S, n)`` [rad, m], the recorded joint positions of the robot's joints, in the assumed order q1..qn.
        points: S arrays ``(M, 2)`` [m], x and z.
        normals, distances: ``(K, 3)`` and ``(K,)`` [m], guesses of the planes.
        plane_names: Names of the planes.
    """

    robot: Robot
    T_flange_sensor: Array
    q: Array
    points: Sequence[Array]
    normals: Array
    distances: Array
    plane_names: Sequence[str]

    def plane_index(self) -> Array:
        """Return the index of the plane of each piece, ``(S,)``, -1 where it is not clear."""
        return self.labels().index

    def labels(self, q: Array | None = None, axes: Array | None = None) -> Labels:
        """Return the plane of each piece, and how far the piece is from it.

        Args:
            q: ``(S, n)``, other joint positions; None for the recorded ones.
            axes: ``(2, 2)``, a matrix by which x and z of the scans are multiplied; None for the unit matrix.
        """
        if not len(self.points):
            return Labels(np.zeros(0, dtype=int), np.zeros(0))
        return label_scans(self.scans(q, axes), self.normals, self.distances)

    def scans(self, q: Array | None = None, axes: Array | None = None) -> list[Array]:
        """Return the points of each piece in the base frame, ``(M, 3)`` [m]; the arguments are those of ``labels``."""
        T = self.robot.flange(self.q if q is None else q) @ self.T_flange_sensor
        turned = self.points if axes is None else [points @ axes.T for points in self.points]
        return [
            points[:, :1] * pose[:3, 0] + points[:, 1:] * pose[:3, 2] + pose[:3, 3]
            for pose, points in zip(T, turned, strict=True)
        ]


def clearly_better_reading(pieces: Pieces, names: Sequence[str], kept: int) -> str | None:
    """Return what ``better_reading`` returns where many pieces are lost, and another reading loses few of these; else None.

    A joint that counts the other way may put most scans on some plane all the same: a wrong sign of joint 1 leaves the floor where it is.

    Args:
        pieces: The pieces of the recording.
        names: Names of the recorded joints in the assumed order.
        kept: How many pieces lie on planes as things stand.
    """
    total = len(pieces.points)
    if total - kept <= _FEW_LOST * total:
        return None
    return better_reading(pieces, names, total - _STILL_LOST * (total - kept))


def better_reading(pieces: Pieces, names: Sequence[str], least: float = 0.0) -> str | None:
    """Return advice if another order, sign or zero of joints, other axes of the scan, or a plane elsewhere put most pieces on planes.

    A plane whose guess is too far off is named before another reading that puts no more pieces on planes. None if nothing does.

    Args:
        pieces: The pieces of the recording.
        names: Names of the recorded joints in the assumed order.
        least: Least number of pieces on planes with which another reading is suggested.
    """
    total = len(pieces.points)
    best, words = int(np.count_nonzero(pieces.plane_index() >= 0)), None
    for what, remedy, labels in _readings(pieces, names):
        on_plane = labels.index >= 0
        found = int(np.count_nonzero(on_plane))
        if (
            found > best
            and found >= max(_ENOUGH * total, least)
            and np.median(labels.distance[on_plane]) <= _CLOSE
        ):
            best = found
            words = f"{found} of {total} scans would lie on a plane with {what}{remedy}"
    return words


def _readings(pieces: Pieces, names: Sequence[str]) -> Iterator[tuple[str, str, Labels]]:
    """Yield other readings of the recording, the simplest first: what differs, how to correct it, and the planes of the pieces then."""
    q = pieces.q
    distances, labels = with_far_guesses(pieces.scans(), pieces.normals, pieces.distances)
    if len(moved := np.flatnonzero(distances != pieces.distances).tolist()):
        places = [
            f"{pieces.plane_names[k]} at a distance of {distances[k]:.2f} m in place of {pieces.distances[k]:.2f} m"
            for k in moved
        ]
        remedy = ": correct the guess under planes, if this is that plane and no other surface"
        yield " and ".join(places), remedy, labels
    for order in _orders(len(names), names):
        yield f"--joint-names {','.join(names[i] for i in order)}", "", pieces.labels(q[:, list(order)])
    for j in range(q.shape[1]):
        turned = np.where(np.arange(q.shape[1]) == j, -q, q)
        yield (
            f"joint {j + 1} ({names[j]}) counted the other way",
            _other_way(pieces.robot, j),
            pieces.labels(turned),
        )
    for j in np.flatnonzero(~pieces.robot.slides).tolist():
        for degrees in (90, -90, 180):
            moved = q + np.where(np.arange(q.shape[1]) == j, degrees * DEG, 0.0)
            remedy = f": add {degrees * DEG:.6f} to theta of joint {j + 1} in robot.joints"
            yield f"{degrees} degrees added to joint {j + 1} ({names[j]})", remedy, pieces.labels(moved)
    for what, axes in _AXES.items():
        yield what, ": correct the rotation in sensor.nominal_pose", pieces.labels(axes=axes)


def _other_way(robot: Robot, joint: int) -> str:
    """Return how robot.joints says that a joint (from 0) counts the other way: ``Rz(-q + theta) Tz(d) = Rx(pi) Rz(q - theta) Tz(-d) Rx(-pi)``."""
    first, second = (joint, joint + 1) if robot.standard_dh else (joint + 1, joint + 2)
    before = f"add 3.141593 to alpha of joint {first}" if first else "turn robot.base by pi about its x axis"
    last = second > robot.n_joints
    after = (
        "turn robot.flange by -pi about its x axis" if last else f"subtract it from alpha of joint {second}"
    )
    return f": in robot.joints change the signs of d and theta of joint {joint + 1}, {before}, and {after}"


def _orders(n: int, names: Sequence[str]) -> Iterator[tuple[int, ...]]:
    """Yield likely orders of n joints: alphabetical, reversed, and with two exchanged."""
    yield tuple(sorted(range(n), key=lambda i: names[i]))
    yield tuple(reversed(range(n)))
    for i, j in combinations(range(n), 2):
        order = list(range(n))
        order[i], order[j] = j, i
        yield tuple(order)
