"""Corrected joint angles for nominal joint angles or wanted frames, all effects applied."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from scalar.data.poses import Poses
from scalar.errors import Fault, InvalidInput
from scalar.estimation.correction.inverse import Inverse, takes_whole_poses, twist_to
from scalar.estimation.correction.nearby import nearest_by_small_changes
from scalar.estimation.correction.settings import CorrectionSettings
from scalar.estimation.displacement import kinematics_at
from scalar.estimation.kinematics import Kinematics
from scalar.estimation.model import Model
from scalar.geometry.se3 import Array, inverse


@dataclass(frozen=True, eq=False)
class Correction:
    """Joint angles for N wanted frames of the sensor.

    Attributes:
        q: ``(N, n)`` [rad], joint angles to be commanded; where the wanted frame is not reached, the nearest that were found.
        T_wanted: ``(N, 4, 4)``, the frames in the base frame.
        position_error: ``(N,)`` [m], distance of ``predict(q)`` from the wanted place.
        orientation_error: ``(N,)`` [rad], angle between the orientations of ``predict(q)`` and of the wanted frame.
        reached: ``(N,)`` bool, whether both errors are within the thresholds, and, for ``correct_joints``, whether the correction is smaller than
            ``CorrectionSettings.largest_correction``. Of an arm with fewer than six joints the orientation may be missed by up to
            ``most_turn_of_few_joints``, and for ``correct_joints`` only the position counts.
        beyond_limits: ``(N, n)`` bool, joints that would leave their limits.
        near_singular: ``(N,)`` bool, whether the pose is so near a singularity that a small error asks for a large change of the joints.
    """

    q: Array
    T_wanted: Array
    position_error: Array
    orientation_error: Array
    reached: Array
    beyond_limits: Array
    near_singular: Array

    def refuse_unreached(self) -> None:
        """Refuse a correction with frames that the arm does not reach.

        Raises:
            InvalidInput: There are such frames; the first row is named, counted from 1, with the number of the others.
        """
        wrong = np.flatnonzero(~self.reached)
        if not len(wrong):
            return
        others = f", nor {len(wrong) - 1} more" if len(wrong) > 1 else ""
        remedy = "leave such rows out: scalar.estimation.correction.correct_joints says which are `reached`"
        message = f"row {wrong[0] + 1}: the calibrated arm cannot take this pose near these joint angles{others}; {remedy}"
        raise InvalidInput(Fault("poses", message, None, "q"))


def correct_joints(model: Model, poses: Poses, settings: CorrectionSettings | None = None) -> Correction:
    """Return joint angles that take the sensor where the nominal arm would take it at the joint angles of the poses.

    The wanted frame is ``T_base_flange(q) T_flange_sensor``, the flange by the nominal arm and the sensor as calibrated.

    Args:
        model: The calibrated model.
        poses: Nominal joint angles, with the columns that the effects need.
        settings: Thresholds; the defaults if None.

    Raises:
        InvalidInput: A column that an effect needs is missing.
    """
    settings = settings or CorrectionSettings()
    now = kinematics_at(model, poses)
    # The sensor on the flange, with the displacements that effects cause.
    T_sensor = model.T_flange_sensor @ inverse(now.T_base_mount) @ now.T_base_sensor
    wanted = model.nominal.flange(poses.q) @ T_sensor
    found = correct_frames(model, poses, wanted, settings)
    far = np.abs(found.q - poses.q).max(axis=1, initial=0.0) > settings.largest_correction
    # The orientation of an arm with fewer than six joints is that of its posture, which a small correction keeps.
    there = (
        found.reached
        if takes_whole_poses(model.robot.n_joints)
        else found.position_error <= settings.position
    )
    return replace(found, reached=there & ~far)


def brought_near(
    model: Model, poses: Poses, found: Correction, settings: CorrectionSettings | None = None
) -> tuple[Correction, Correction]:
    """Return a correction whose poses that are not reached come as near to the wanted frame as small changes of the joints bring them.

    At a singularity an error of a milliradian asks for a large change of some joints, and the nearest posture may be far from what was meant. There
    the position is met as well as it can be, and the orientation as far as this leaves it free. ``reached`` stays False.

    Args:
        model: The calibrated one.
        poses: The poses given to ``correct_joints``.
        found: The correction that it returned.
        settings: Thresholds; the defaults if None.

    Returns:
        That correction, and the same with the joint angles of ``poses`` where the frame is not reached, to say what was gained.
    """
    settings = settings or CorrectionSettings()
    left = np.flatnonzero(~found.reached)
    part, wanted = _picked(poses, left), found.T_wanted[left]
    uncorrected = twist_to(kinematics_at(model, part).T_base_sensor, wanted)
    near = nearest_by_small_changes(model, part, wanted, settings)
    return _with_rows(model, found, left, *near), _with_rows(model, found, left, part.q, uncorrected)


def nearest_to_frames(
    model: Model, poses: Poses, found: Correction, settings: CorrectionSettings | None = None
) -> tuple[Correction, Array]:
    """Return a correction whose frames that are not reached are met as nearly as the arm comes, and which of these are met nearly, ``(N,)`` bool.

    The search starts at the given joint angles, and at those where the correction ended if they are the same posture; the nearer of both ends is
    taken. ``reached`` stays False. Nearly met is a frame that is missed by less than ``near_enough`` and ``near_enough_turn`` within the limits
    of the joints. Rows that are not nearly met stay as they were found.

    Args:
        model: The calibrated one.
        poses: The poses given to ``correct_frames``.
        found: The correction that it returned.
        settings: Thresholds; the defaults if None.
    """
    settings = settings or CorrectionSettings()
    left = np.flatnonzero(~found.reached)
    nearly = np.zeros(len(found.q), dtype=bool)
    if not len(left):
        return found, nearly
    part, wanted = _picked(poses, left), found.T_wanted[left]
    same = np.abs(found.q[left] - part.q).max(axis=1, keepdims=True) <= settings.largest_correction
    ends = [
        nearest_by_small_changes(model, replace(part, q=q), wanted, settings)
        for q in (part.q, np.where(same, found.q[left], part.q))
    ]
    errors = [_errors_of(twist) for _, twist in ends]
    turn_counts = takes_whole_poses(model.robot.n_joints)
    misses = [
        position / settings.near_enough + turn_counts * turn / settings.near_enough_turn
        for position, turn in errors
    ]
    best = np.argmin(misses, axis=0)[:, None]
    q, twist = (np.where(best == 0, first, second) for first, second in zip(*ends, strict=True))
    position, turn = _errors_of(twist)
    low, high = model.robot.limits.T
    near = (position < settings.near_enough) & np.all((q >= low) & (q <= high), axis=1)
    if turn_counts:
        near &= turn < settings.near_enough_turn
    nearly[left] = near
    return _with_rows(model, found, left[near], q[near], twist[near]), nearly


def _with_rows(model: Model, found: Correction, rows: Array, q: Array, twist: Array) -> Correction:
    """Return a correction with other joint angles ``(M, n)`` [rad], and the twists ``(M, 6)`` [rad, m] that they leave, in some rows."""
    joints, position, orientation = (
        values.copy() for values in (found.q, found.position_error, found.orientation_error)
    )
    joints[rows] = q
    position[rows], orientation[rows] = _errors_of(twist)
    limits = model.robot.limits
    return replace(
        found,
        q=joints,
        position_error=position,
        orientation_error=orientation,
        beyond_limits=(joints < limits[:, 0]) | (joints > limits[:, 1]),
    )


def correct_frames(
    model: Model, poses: Poses, T_wanted: Array, settings: CorrectionSettings | None = None
) -> Correction:
    """Return joint angles that take the sensor to wanted frames.

    Args:
        model: The calibrated one.
        poses: Joint angles to start from, in the wanted posture (elbow up or down, say), with the columns that the effects need.
        T_wanted: ``(N, 4, 4)``, frames of the sensor in the base frame.
        settings: Thresholds; the defaults if None.

    Raises:
        InvalidInput: A column that an effect needs is missing.
    """
    settings = settings or CorrectionSettings()

    def solver(part: Poses) -> Inverse:
        """Return the inverse kinematics at some of the poses."""

        def kinematics_of(q: Array, index: Array) -> Kinematics:
            return kinematics_at(model, replace(_picked(part, index), q=q))

        return Inverse(kinematics_of, model.nominal, settings)

    chunks = [slice(at, at + settings.chunk) for at in range(0, len(poses), settings.chunk)]
    parts = [solver(_picked(poses, rows)).fast(poses.q[rows], T_wanted[rows]) for rows in chunks]
    q = np.concatenate([part.q for part in parts])
    twist = np.concatenate([part.twist for part in parts])
    singular_value = np.concatenate([part.singular_value for part in parts])
    whole = solver(poses)
    left = np.flatnonzero(~whole.reached(twist))
    if len(left):
        q[left], twist[left] = whole.damped(poses.q[left], left, T_wanted[left])
    limits = model.robot.limits
    position, orientation = _errors_of(twist)
    return Correction(
        q=q,
        T_wanted=T_wanted,
        position_error=position,
        orientation_error=orientation,
        reached=whole.reached(twist),
        beyond_limits=(q < limits[:, 0]) | (q > limits[:, 1]),
        near_singular=singular_value < settings.near_singular,
    )


def _errors_of(twist: Array) -> tuple[Array, Array]:
    """Return the errors of position ``(N,)`` [m] and orientation ``(N,)`` [rad] of twists ``(N, 6)`` [rad, m]."""
    return np.linalg.norm(twist[:, 3:], axis=1), np.linalg.norm(twist[:, :3], axis=1)


def _picked(poses: Poses, index: Array | slice) -> Poses:
    """Return some of the poses."""
    columns = {name: column[index] for name, column in poses.columns.items()}
    return Poses(poses.q[index], poses.order[index], columns)
