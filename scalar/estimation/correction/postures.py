"""Joint angles for wanted frames that are given without any: the inverse kinematics of the rigid arm, from many starts.

A correction then starts from these joint angles. Many random postures are drawn, and those whose sensor is nearest to the wanted frame are the
starts. Where all their solutions are far from the previous pose, that pose is a start too, because the random ones do not find every posture. Of the
solutions within the joint limits, the one nearest to the previous pose is taken, so that a path keeps its posture where it can. After a large move a
joint does not stay a turn away from the middle of its limits, and a posture within the measured ranges of the joints is preferred.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from scalar.data.poses import Poses
from scalar.estimation.correction.correct import Correction, correct_frames
from scalar.estimation.correction.inverse import takes_whole_poses
from scalar.estimation.correction.settings import CorrectionSettings
from scalar.estimation.measured_ranges import widened
from scalar.estimation.model import Model
from scalar.geometry.se3 import Array

RANDOM_POSTURES = 20_000
"""Chosen: with so many, neighbouring positions of the sensor are some centimetres apart in the workspace of a six-axis arm."""
STARTS, STARTS_OF_FEW_JOINTS = 12, 48
"""Starts of each pose, and those with fewer than six joints. Chosen: an arm of six joints has up to eight postures, and several starts may lead to
the same one. With fewer joints most starts end where the orientation is missed."""
_SEED = 0
_AS_WELL = 1e-3  # rad; postures whose orientations differ by less take a frame as well as each other
_TURN = 2 * np.pi
_LARGE_MOVE = np.pi / 2
"""[rad] A joint that turns further has no path to continue, and takes the turn in the middle of its limits."""
_NEAR_PREVIOUS = 0.2
"""[rad] If every solution found so far turns a joint further than this from the previous pose, the frame is solved from that pose too. Chosen: the
random starts miss the posture of the row before in one of six to sixty rows, and a solution as near as this is in that posture."""


def postures_for(
    model: Model,
    T_wanted: Array,
    first: Array | None = None,
    settings: CorrectionSettings | None = None,
    measured: Array | None = None,
) -> tuple[Array, Array]:
    """Return joint angles of the rigid arm ``(N, n)`` [rad] for wanted frames, and which of them take the frame ``(N,)`` bool.

    A frame that no posture takes gets the one within the limits that comes nearest, or NaN where the search ended beyond the limits throughout.

    Args:
        model: The calibrated one; its effects are left out.
        T_wanted: ``(N, 4, 4)``, frames of the sensor in the base frame.
        first: ``(n,)`` [rad], joint angles to which the first pose shall be near; the middle of the limits if None.
        settings: Thresholds; the defaults if None.
        measured: ``(n, 2)`` [rad; m where a joint slides], the ranges of the joints over the measured poses, where the calibration holds; or None.
            In the first row, and after a large move, a posture within them is preferred.
    """
    settings = settings or CorrectionSettings()
    rigid = replace(model, effects=())
    low, high = model.robot.limits.T
    middle = (low + high) / 2
    reference = middle if first is None else np.asarray(first, dtype=float)
    turn = np.where(model.robot.slides, 0.0, _TURN)
    continues = first is not None
    found = np.full((len(T_wanted), len(low)), np.nan)
    there = np.zeros(len(T_wanted), dtype=bool)
    for at in range(0, len(T_wanted), settings.chunk):
        wanted = T_wanted[at : at + settings.chunk]
        for i, solutions in enumerate(_from_random_starts(rigid, wanted, settings)):
            best, takes_it = solutions.nearest_to(reference, low, high, turn)
            if takes_it and np.abs(best - reference).max() > _NEAR_PREVIOUS:
                continued = _solved(rigid, wanted[i : i + 1], reference[None], settings)
                solutions = solutions.joined_by(_Solutions.of(continued, settings))
                best, _ = solutions.nearest_to(reference, low, high, turn)
            if best is None:
                continue
            if takes_it:
                far = np.abs(best - reference) > _LARGE_MOVE
                best = np.where(far, best - turn * np.round((best - middle) / _TURN), best)
                if measured is not None and (far.any() or not continues):
                    within, is_within = solutions.nearest_to(reference, *_within(measured, low, high), turn)
                    best = within if within is not None and is_within else best
                reference, continues = best, True
            found[at + i], there[at + i] = best, takes_it
    return found, there


def _within(measured: Array, low: Array, high: Array) -> tuple[Array, Array]:
    """Return the lowest and the highest joint positions ``(n,)`` within the limits that are not clearly outside the measured ranges."""
    least, most = widened(measured).T
    return np.maximum(low, least), np.minimum(high, most)


def _from_random_starts(model: Model, T_wanted: Array, settings: CorrectionSettings) -> Iterator[_Solutions]:
    """Yield for each wanted frame ``(N, 4, 4)`` where the searches from its starts end; the model has no effects."""
    whole = takes_whole_poses(model.robot.n_joints)
    n_starts = STARTS if whole else STARTS_OF_FEW_JOINTS
    of_starts = np.repeat(T_wanted, n_starts, axis=0)
    q = _nearest(model, T_wanted, n_starts).reshape(len(of_starts), -1)
    if not whole:
        # First place and orientation alike, which finds the posture in which the arm takes both if there is one.
        q = _solved(model, of_starts, q, replace(settings, orientation_weight=1.0)).q
    ends = _Solutions.of(_solved(model, of_starts, q, settings), settings)
    for k in range(len(T_wanted)):
        yield ends.of_rows(slice(k * n_starts, (k + 1) * n_starts))


@dataclass(frozen=True, eq=False)
class _Solutions:
    """The ends of the searches for one frame, from S starts.

    Attributes:
        q: ``(S, n)`` [rad; m where a joint slides], joint angles.
        reached: ``(S,)`` bool, which of them take the frame.
        misses: ``(S,)``, how far the others miss it: position and orientation error, each as a multiple of what is near enough.
        turned_by: ``(S,)`` [rad], their orientation errors.
    """

    q: Array
    reached: Array
    misses: Array
    turned_by: Array

    @classmethod
    def of(cls, solved: Correction, settings: CorrectionSettings) -> _Solutions:
        """Return the ends of the searches of a correction."""
        misses = (
            solved.position_error / settings.near_enough
            + solved.orientation_error / settings.near_enough_turn
        )
        return cls(solved.q, solved.reached, misses, solved.orientation_error)

    def of_rows(self, rows: slice) -> _Solutions:
        """Return some of these solutions."""
        return _Solutions(self.q[rows], self.reached[rows], self.misses[rows], self.turned_by[rows])

    def joined_by(self, others: _Solutions) -> _Solutions:
        """Return these solutions and others for the same frame."""
        return _Solutions(
            np.concatenate([self.q, others.q]),
            np.concatenate([self.reached, others.reached]),
            np.concatenate([self.misses, others.misses]),
            np.concatenate([self.turned_by, others.turned_by]),
        )

    def nearest_to(self, reference: Array, low: Array, high: Array, turn: Array) -> tuple[Array | None, bool]:
        """Return the joint angles ``(n,)`` within the limits that take the frame with the smallest move from the reference, and True.

        If none take it, those that come nearest to the frame, and False; None in their place if all are beyond the limits.

        Args:
            reference: ``(n,)`` [rad; m where a joint slides], the previous pose.
            low, high: ``(n,)``, the limits.
            turn: ``(n,)`` [rad], a whole turn of each joint; 0 where it slides.
        """
        turned = self.q - turn * np.round((self.q - reference) / _TURN)
        turned += turn * (turned < low) - turn * (turned > high)
        allowed = np.all((turned >= low) & (turned <= high), axis=1)
        sound = self.reached & allowed
        if sound.any():
            # An arm with fewer than six joints may miss the orientation more in one posture than in another.
            sound &= self.turned_by <= self.turned_by[sound].min() + _AS_WELL
            distance = np.where(sound, np.abs(turned - reference).max(axis=1), np.inf)
            return turned[int(np.argmin(distance))], True
        if allowed.any():
            return turned[int(np.argmin(np.where(allowed, self.misses, np.inf)))], False
        return None, False


def _solved(model: Model, T_wanted: Array, q: Array, settings: CorrectionSettings) -> Correction:
    """Return the ends of searches for frames ``(N, 4, 4)`` from joint angles ``(N, n)`` [rad]."""
    return correct_frames(model, Poses.from_arrays(q, {}, model.robot.slides), T_wanted, settings)


def _nearest(model: Model, T_wanted: Array, n_starts: int) -> Array:
    """Return for each wanted frame ``(N, 4, 4)`` the random joint angles whose sensor is nearest to it, ``(N, n_starts, n)`` [rad]."""
    from scipy.spatial import KDTree

    low, high = model.robot.limits.T
    q = np.random.default_rng(_SEED).uniform(low, high, (RANDOM_POSTURES, len(low)))
    T = model.robot.flange(q) @ model.T_flange_sensor
    size = max(float(np.std(T[:, :3, 3])), 1e-3)
    turn = 0.5  # half a turn of the sensor counts as the size of the workspace

    def coordinates(frames: Array) -> Array:
        return np.concatenate([frames[:, :3, 3] / size, turn * frames[:, :3, :2].reshape(-1, 6)], axis=1)

    return q[KDTree(coordinates(T)).query(coordinates(T_wanted), k=n_starts)[1]]
