"""The iteration that finds joint angles for wanted frames: Newton's method, then a damped iteration for the poses that it does not solve.

``q <- q + J^+ e``, with e the twist (rotation [rad], shift in units of the arm's length) from where the model says that the sensor is
to where it is wanted, and J the Jacobian of the rigid chain. The Jacobian is computed in the first steps only and then kept. It leaves out what
effects add to it: single steps are a little less accurate for that, but the iteration ends at a solution of the full model. The damped
iteration is that of Levenberg and Marquardt, for each pose by itself.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from scalar.estimation.correction.settings import CorrectionSettings
from scalar.estimation.kinematics import Kinematics
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import Array, cross, log_so3

_LEAST = 1e-13  # of a matrix's size: added to its diagonal, so that an exactly singular one has an inverse
_TINY = 1e-300
_SMALL = 0.02  # rad; the sine of a smaller angle is the angle to a share of 1e-4
_FACTOR, _MOST = 10.0, 1e6  # factor by which the damping is adapted, and its bound: beyond it no step helps
_WHOLE_POSE = 6  # joints: with fewer, an arm cannot meet every position and orientation
KinematicsAt = Callable[[Array, Array], Kinematics]
"""The kinematics of the model at joint angles ``(M, n)`` [rad] of the poses with indices ``(M,)``."""


@dataclass(frozen=True, eq=False)
class Found:
    """Where an iteration ended.

    Attributes:
        q: ``(N, n)`` [rad].
        twist: ``(N, 6)``, from the frame that ``q`` gives to the wanted one: rotation [rad] and shift [m] of the sensor's origin.
        singular_value: ``(N,)``, a lower bound of the smallest singular value of the Jacobian at the start, lengths in units of the arm's; it is
            at most 1.6 times too small.
    """

    q: Array
    twist: Array
    singular_value: Array


def takes_whole_poses(n_joints: int) -> bool:
    """Return whether an arm with so many joints can meet every position and orientation within its reach."""
    return n_joints >= _WHOLE_POSE


def arm_length(robot: Robot) -> float:
    """Return the length [m] by which shifts are divided to compare them with rotations: half the sum of all link lengths and travels."""
    travels = np.ptp(robot.limits, axis=1)[robot.slides]
    return max(float(np.abs(robot.geometry[[0, 2]]).sum() + travels.sum()) / 2, 1e-3)


def twist_to(T: Array, T_wanted: Array) -> Array:
    """Return rotation [rad] and shift [m] ``(N, 6)`` of the origin from frames ``(N, 4, 4)`` to those that are wanted, in the base frame.

    Args:
        T: Where the sensor is.
        T_wanted: Where it is wanted.
    """
    R = T_wanted[:, :3, :3] @ np.swapaxes(T[:, :3, :3], 1, 2)
    # The sine of a small angle stands for the angle, which is much faster. A tool that is upside down has no sine either.
    turn = 0.5 * np.stack([R[:, 2, 1] - R[:, 1, 2], R[:, 0, 2] - R[:, 2, 0], R[:, 1, 0] - R[:, 0, 1]], axis=1)
    large = np.flatnonzero(np.trace(R, axis1=1, axis2=2) < 1.0 + 2.0 * np.cos(_SMALL))
    if len(large):
        turn[large] = log_so3(R[large])
    return np.concatenate([turn, T_wanted[:, :3, 3] - T[:, :3, 3]], axis=1)


def jacobian(kinematics: Kinematics) -> Array:
    """Return the twist of the sensor's origin by each joint of the rigid chain, ``(N, 6, n)`` [rad/rad, m/rad; rad/m, m/m of a prismatic joint]."""
    frames = kinematics.frames[:, 1:]
    axes, points = frames[..., :3, 2], frames[..., :3, 3]
    if kinematics.T_base_tilted is not None:
        R, t = kinematics.T_base_tilted[:, None, :3, :3], kinematics.T_base_tilted[:, None, :3, 3]
        axes, points = (R @ axes[..., None])[..., 0], (R @ points[..., None])[..., 0] + t
    arms = kinematics.T_base_sensor[:, None, :3, 3] - points
    twists = np.concatenate([axes, cross(axes, arms)], axis=2)
    where = list(kinematics.model.robot.prismatic)
    twists[:, where, :3], twists[:, where, 3:] = 0.0, axes[:, where]
    return np.swapaxes(twists, 1, 2)


class Inverse:
    """The inverse of a model at given poses.

    Args:
        kinematics_at: The kinematics of the model at joint angles of its poses.
        robot: The nominal arm. An arm with fewer than six joints meets the position, and the orientation as closely as it can.
        settings: Thresholds.
    """

    def __init__(self, kinematics_at: KinematicsAt, robot: Robot, settings: CorrectionSettings) -> None:
        self.kinematics_at, self.settings = kinematics_at, settings
        self.place_alone = not takes_whole_poses(robot.n_joints)
        length = arm_length(robot)
        turn = settings.orientation_weight if self.place_alone else 1.0
        self.weights = np.array([turn, turn, turn, 1 / length, 1 / length, 1 / length])

    def fast(self, q: Array, T_wanted: Array) -> Found:
        """Return where Newton's method ends.

        Args:
            q: ``(N, n)`` [rad], joint angles near the solution.
            T_wanted: ``(N, 4, 4)``, frames of the sensor in the base frame.
        """
        q = q.copy()
        going = np.arange(len(q))
        kinematics = self.kinematics_at(q, going)
        twist = twist_to(kinematics.T_base_sensor, T_wanted)
        inverses, singular_value = self._inverses(kinematics)
        for k in range(self.settings.steps):
            step = (inverses @ (twist[going] * self.weights)[:, :, None])[:, :, 0]
            q[going] += step
            kinematics = self.kinematics_at(q[going], going)
            twist[going] = twist_to(kinematics.T_base_sensor, T_wanted[going])
            rest = ~self._ended(twist[going], step)
            rest &= (
                np.abs(step).max(axis=1) < self.settings.largest_correction
            )  # after a larger step, the sine no longer stands for the angle
            going = going[rest]
            if not len(going):
                break
            inverses = self._inverses(kinematics)[0][rest] if k < self.settings.jacobians else inverses[rest]
        return Found(q, twist, singular_value)

    def _inverses(self, kinematics: Kinematics) -> tuple[Array, Array]:
        """Return the pseudo-inverses ``(N, n, 6)`` of the weighted Jacobians, and a lower bound of their smallest singular values ``(N,)``.

        With more than six joints the pseudo-inverse gives the shortest of the steps that solve the linear problem.
        """
        J = jacobian(kinematics) * self.weights[:, None]
        Jt = np.swapaxes(J, 1, 2)
        wide = J.shape[1] <= J.shape[2]
        A = J @ Jt if wide else Jt @ J
        size = np.trace(A, axis1=1, axis2=2) / A.shape[1]
        A_inverse = np.linalg.inv(A + (_LEAST * size + _TINY)[:, None, None] * np.eye(A.shape[1]))
        singular_value = np.maximum(np.linalg.norm(A_inverse, axis=(1, 2)), _TINY) ** -0.5
        return (Jt @ A_inverse if wide else A_inverse @ Jt), singular_value

    def _ended(self, twist: Array, step: Array) -> Array:
        """Return which iterations have ended: at the wanted frame or, for an arm with fewer than six joints, where the step is negligible."""
        if self.place_alone:
            return np.abs(step).max(axis=1) < self.settings.orientation
        return self.reached(twist)

    def reached(self, twist: Array) -> Array:
        """Return whether the remaining twists ``(N, 6)`` are within the thresholds, ``(N,)`` bool."""
        there = np.linalg.norm(twist[:, 3:], axis=1) <= self.settings.position
        turn = self.settings.most_turn_of_few_joints if self.place_alone else self.settings.orientation
        return there & (np.linalg.norm(twist[:, :3], axis=1) <= turn)

    def damped(self, q: Array, index: Array, T_wanted: Array) -> tuple[Array, Array]:
        """Return the joint angles ``(M, n)`` [rad] at which the damped iteration ends, and the remaining twists ``(M, 6)`` [rad, m].

        Args:
            q: ``(M, n)`` [rad], joint angles to start from.
            index: ``(M,)``, which poses these are.
            T_wanted: ``(M, 4, 4)``, their wanted frames.
        """
        q = q.copy()
        kinematics = self.kinematics_at(q, index)
        J = jacobian(kinematics) * self.weights[:, None]
        twist = twist_to(kinematics.T_base_sensor, T_wanted)
        cost = np.sum((twist * self.weights) ** 2, axis=1)
        damping = np.full(len(q), self.settings.damping)
        going = np.arange(len(q))
        for _ in range(self.settings.damped_steps):
            Jt = np.swapaxes(J[going], 1, 2)
            A = Jt @ J[going]
            size = np.maximum(np.trace(A, axis1=1, axis2=2) / A.shape[1], _TINY)
            A += ((damping[going] + _LEAST) * size)[:, None, None] * np.eye(A.shape[1])
            step = np.linalg.solve(A, Jt @ (twist[going] * self.weights)[:, :, None])[:, :, 0]
            tried = q[going] + step
            kinematics = self.kinematics_at(tried, index[going])
            left = twist_to(kinematics.T_base_sensor, T_wanted[going])
            new = np.sum((left * self.weights) ** 2, axis=1)
            better = new < cost[going]
            chosen = going[better]
            q[chosen], twist[chosen], cost[chosen] = tried[better], left[better], new[better]
            J[chosen] = (jacobian(kinematics) * self.weights[:, None])[better]
            damping[going] = np.clip(damping[going] * np.where(better, 1 / _FACTOR, _FACTOR), _LEAST, _MOST)
            ended = self._ended(twist[going], np.where(better[:, None], step, 1.0))
            going = going[~ended & (damping[going] < _MOST)]
            if not len(going):
                break
        return q, twist
