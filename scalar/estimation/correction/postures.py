"""Joint angles for wanted frames that are given without any: the inverse kinematics of the rigid arm, from many starts.

A correction then starts from these joint angles. Many random postures are drawn, and those whose sensor is nearest to the wanted frame are the
starts. Of the solutions within the joint limits, the one nearest to the previous pose is taken, so that a path keeps its posture where it can. After
a large move a joint does not stay a turn away from the middle of its limits.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from scalar.data.poses import Poses
from scalar.estimation.correction.correct import Correction, correct_frames
from scalar.estimation.correction.inverse import takes_whole_poses
from scalar.estimation.correction.settings import CorrectionSettings
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
_A_MOVE = np.pi / 2
"""[rad] A joint that turns further has no path to continue, and takes the turn in the middle of its limits."""


def postures_for(
    model: Model, T_wanted: Array, first: Array | None = None, settings: CorrectionSettings | None = None
) -> tuple[Array, Array]:
    """Return joint angles of the rigid arm ``(N, n)`` [rad] for wanted frames, and which of them take the frame ``(N,)`` bool.

    A frame that no posture takes gets the one within the limits that comes nearest, or NaN where the search ended beyond the limits throughout.

    Args:
        model: The calibrated one; its effects are left out.
        T_wanted: ``(N, 4, 4)``, frames of the sensor in the base frame.
        first: ``(n,)`` [rad], joint angles to which the first pose shall be near; the middle of the limits if None.
        settings: Thresholds; the defaults if None.
    """
    settings = settings or CorrectionSettings()
    rigid = replace(model, effects=())
    low, high = model.robot.limits.T
    middle = (low + high) / 2
    reference = middle if first is None else np.asarray(first, dtype=float)
    found = np.full((len(T_wanted), len(low)), np.nan)
    there = np.zeros(len(T_wanted), dtype=bool)
    turn = np.where(model.robot.slides, 0.0, _TURN)
    whole = takes_whole_poses(model.robot.n_joints)
    n_starts = STARTS if whole else STARTS_OF_FEW_JOINTS
    for at in range(0, len(T_wanted), settings.chunk):
        rows = slice(at, at + settings.chunk)
        wanted = T_wanted[rows]
        starts = _nearest(rigid, wanted, n_starts)
        of_starts, q = np.repeat(wanted, n_starts, axis=0), starts.reshape(-1, len(low))
        if not whole:
            # First place and orientation alike, which finds the posture in which the arm takes both if there is one.
            q = _solved(rigid, of_starts, q, replace(settings, orientation_weight=1.0)).q
        solved = _solved(rigid, of_starts, q, settings)
        q = solved.q.reshape(len(wanted), n_starts, -1)
        reached = solved.reached.reshape(len(wanted), n_starts)
        misses = (
            solved.position_error / settings.near_enough
            + solved.orientation_error / settings.near_enough_turn
        ).reshape(len(wanted), n_starts)
        turned_by = solved.orientation_error.reshape(len(wanted), n_starts)
        for i in range(len(wanted)):
            turned = q[i] - turn * np.round((q[i] - reference) / _TURN)
            turned += turn * (turned < low) - turn * (turned > high)
            allowed = np.all((turned >= low) & (turned <= high), axis=1)
            sound = reached[i] & allowed
            if sound.any():  # an arm with fewer than six joints may miss the orientation more in one posture than in another
                sound &= turned_by[i] <= turned_by[i][sound].min() + _AS_WELL
            if sound.any():
                distance = np.where(sound, np.abs(turned - reference).max(axis=1), np.inf)
                best = turned[int(np.argmin(distance))]
                far = np.abs(best - reference) > _A_MOVE
                best = np.where(far, best - turn * np.round((best - middle) / _TURN), best)
                found[at + i] = reference = best
                there[at + i] = True
            elif allowed.any():
                found[at + i] = turned[int(np.argmin(np.where(allowed, misses[i], np.inf)))]
    return found, there


def _solved(model: Model, T_wanted: Array, q: Array, settings: CorrectionSettings) -> Correction:
    return correct_frames(model, Poses.from_arrays(q, {}, q.shape[1]), T_wanted, settings)


def _nearest(model: Model, T_wanted: Array, n_starts: int) -> Array:
    """Return the starts of each frame, ``(N, n_starts, n)`` [rad]."""
    from scipy.spatial import KDTree

    low, high = model.robot.limits.T
    q = np.random.default_rng(_SEED).uniform(low, high, (RANDOM_POSTURES, len(low)))
    T = model.robot.flange(q) @ model.T_flange_sensor
    size = max(float(np.std(T[:, :3, 3])), 1e-3)
    turn = 0.5  # half a turn of the sensor counts as the size of the workspace

    def coordinates(frames: Array) -> Array:
        return np.concatenate([frames[:, :3, 3] / size, turn * frames[:, :3, :2].reshape(-1, 6)], axis=1)

    return q[KDTree(coordinates(T)).query(coordinates(T_wanted), k=n_starts)[1]]
