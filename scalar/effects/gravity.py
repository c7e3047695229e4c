"""Gravity torques of an arm whose masses are unknown, as functions that are linear in the unknown first moments of mass.

A link's weight enters every torque through its first moment of mass in its own frame. The component along a joint's axis acts like one of
the previous link, so two components for each frame, along x and y, generate all gravity torques of a revolute chain (Gautier and Khalil, 1990). A
joint that slides does not turn the links that it carries, but shifts them along its axis. In its frame, the first component is therefore replaced by
its travel along that axis, relative to the farther of its limits.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from scalar.data.poses import Poses
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import Array, cross

AXES = ("x", "y")


def unit_moments(robot: Robot, q: Array) -> tuple[Array, Array]:
    """Return the torque vectors of unit first moments of mass in every frame, and the joints' axes.

    Args:
        robot: Nominal.
        q: ``(N, n)`` [rad, m].

    Returns:
        ``(N, n, 2, 3)``: ``(R_i e_x) x g / |g|`` and the same for e_y, base frame, dimensionless; and the axes ``(N, n, 3)``.
    """
    frames = robot.frames(q)[:, 1:]
    arms = np.swapaxes(frames[..., :3, :2], -1, -2)
    if robot.prismatic:
        where = list(robot.prismatic)
        share = q[:, where] / np.abs(robot.limits[where]).max(axis=1)
        arms = arms.copy()
        arms[:, where, 0] = share[..., None] * frames[:, where][..., :3, 2]
    return cross(arms, np.broadcast_to(robot.down, arms.shape)), frames[..., :3, 2]


@lru_cache(maxsize=1)
def unit_moments_at(robot: Robot, poses: Poses) -> tuple[Array, Array]:
    """Return the ``unit_moments`` of an arm at poses, read-only; the latest are kept, since candidates of every joint and frame share them."""
    found = unit_moments(robot, poses.q)
    for array in found:
        array.setflags(write=False)
    return found


def torque_basis(robot: Robot, q: Array, joint: int, frame: int) -> Array:
    """Return the torques ``(N, 2)`` about a joint of first moments of mass along x and y of a link's frame, over ``|g|`` and the moment.

    Args:
        robot: The nominal arm.
        q: Joint angles ``(N, n)`` [rad].
        joint: The joint about which the torque acts, from 1.
        frame: The link that has the first moments (mass times centre of mass), from 1.
    """
    return torque_about(*unit_moments(robot, q), joint, frame)


def torque_about(moments: Array, axes: Array, joint: int, frame: int) -> Array:
    """Return ``torque_basis`` ``(N, 2)`` from values that are the same for every joint and frame, and are computed once.

    Args:
        moments: The first value that ``unit_moments`` returns.
        axes: The second.
        joint: As in ``torque_basis``.
        frame: As in ``torque_basis``.
    """
    return np.einsum("nax,nx->na", moments[:, frame - 1], axes[:, joint - 1])


def typical_torque(robot: Robot, q: Array, joint: int) -> Array:
    """Return the gravity torque about a joint (from 1) of an arm with 1 kg at the end of each link, ``(N,)`` [N m]; only its sign is reliable."""
    frames = robot.frames(q)
    return np.einsum(
        "nix,nx->n", moments_of_ends(robot, frames, joint, robot.gravity), frames[:, joint, :3, 2]
    )


def moments_of_ends(robot: Robot, frames: Array, joint: int, weight: Array) -> Array:
    """Return the moments about a joint (from 1) of a weight at the end of each link after it, the flange the last ``(N, n - joint + 1, 3)``.

    Args:
        robot: The arm.
        frames: ``(N, n + 1, 4, 4)``, as ``Robot.frames`` returns them.
        joint: From 1.
        weight: ``(3,)``, in the base frame; the moments are in its unit times metres.
    """
    flange = frames[:, -1] @ robot.T_n_flange
    ends = np.concatenate([frames[:, joint + 1 :, :3, 3], flange[:, None, :3, 3]], axis=1)
    arms = ends - frames[:, joint, None, :3, 3]
    return cross(arms, np.broadcast_to(weight, arms.shape))


def torques_at_flange(robot: Robot, q: Array, place: Array, weight: Array) -> Array:
    """Return the torque ``(N, n)`` about each joint's axis of a weight that the flange carries.

    Args:
        robot: The arm.
        q: ``(N, n)`` [rad, m].
        place: ``(N, 3)`` or ``(3,)``, where it acts, in the flange's frame [m].
        weight: ``(3,)``, in the base frame; the torques are in its unit times metres.
    """
    frames = robot.frames(q)
    flange = frames[:, -1] @ robot.T_n_flange
    at = np.broadcast_to(place, (len(q), 3))
    p = np.einsum("nij,nj->ni", flange[:, :3, :3], at) + flange[:, :3, 3]
    arms = p[:, None, :] - frames[:, 1:, :3, 3]
    return np.einsum("njx,njx->nj", cross(arms, np.broadcast_to(weight, arms.shape)), frames[:, 1:, :3, 2])


def torque_of(robot: Robot, q: Array, joint: int, masses: Sequence[float]) -> Array:
    """Return the gravity torque ``(N,)`` about a joint (from 1), in any unit.

    Args:
        robot: Nominal.
        q: ``(N, n)`` [rad, m].
        joint: From 1.
        masses: ``(2 (n - joint + 1),)``, first moments of mass in the frames from the joint on, x and y of each in turn, in any unit.
    """
    return _torques(robot, q, joint) @ np.asarray(masses)


def assumed_torque(robot: Robot, q: Array, joint: int, masses: Sequence[float]) -> Array:
    """Return the gravity torque ``(N,)`` about a joint (from 1) as ``torque_of`` has it, or without masses that of ``typical_torque``.

    Args:
        robot: Nominal.
        q: ``(N, n)`` [rad, m].
        joint: From 1.
        masses: As for ``torque_of``, or none.
    """
    return torque_of(robot, q, joint, masses) if masses else typical_torque(robot, q, joint)


def typical_moment(robot: Robot, frames: Array, joint: int) -> Array:
    """Return the moment of 1 kg at the end of each link after a joint (from 1) about the joint's place, over the weight of 1 kg ``(N, 3)`` [m].

    Args:
        robot: Nominal.
        frames: As for ``moments_of_ends``.
        joint: From 1.
    """
    return moments_of_ends(robot, frames, joint, robot.down).sum(axis=1)


def typical_masses(robot: Robot, q: Array, joint: int) -> Array:
    """Return the first moments ``(2 (n - joint + 1),)``, a vector of length one, whose torque is proportional to ``typical_torque``."""
    B = _torques(robot, q, joint)
    found = np.linalg.lstsq(B, typical_torque(robot, q, joint), rcond=1e-8)[0]
    return found / max(float(np.linalg.norm(found)), 1e-300)


def _torques(robot: Robot, q: Array, joint: int) -> Array:
    frames = range(joint, robot.n_joints + 1)
    return np.concatenate([torque_basis(robot, q, joint, f) for f in frames], axis=1)
