"""Measured orientations beside those of the arm: ``M_i = Y R_i X`` in a pose i, with two constant rotations X and Y.

M_i is measured, R_i is that of the nominal arm's flange. The turns between poses, ``R_i' R_j`` and ``M_i' M_j``, have the same angles, and axes that
differ by X. This determines both constants in closed form (Park and Martin, IEEE Transactions on Robotics and Automation 10, 1994).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from scalar.data.dataset import Dataset
from scalar.data.formats import ORIENTATION
from scalar.geometry.se3 import Array, log_so3, nearest_rotation, rotation_angle


@dataclass(frozen=True, eq=False)
class Orientations:
    """Where orientations were measured, and which of them have constants in common.

    Attributes:
        vectors: ``(P, 3)``, rotation vectors from a target's axes to the tracker's.
        arm: ``(P, 3, 3)``, the nominal flange in the base frame.
        group: ``(P,)``, the target and the session of each, as one number from 0.
    """

    vectors: Array
    arm: Array
    group: Array

    @classmethod
    def of(cls, dataset: Dataset) -> Orientations:
        """Return those of a dataset that has them (``were_measured``)."""
        columns, pose = dataset.point_columns, dataset.pose_of_point
        target = columns.get("target", np.zeros(len(pose)))
        session = np.zeros(dataset.n_poses) if dataset.session is None else np.asarray(dataset.session)
        group = np.unique(np.column_stack([target, session[pose]]), axis=0, return_inverse=True)[1].ravel()
        return cls(vectors_of(dataset), dataset.robot.flange(dataset.q)[pose, :3, :3], group)

    def groups(self) -> list[Array]:
        """Return which points ``(P,)`` bool belong to each group."""
        return [self.group == g for g in range(int(self.group.max()) + 1)]


def were_measured(dataset: Dataset) -> bool:
    """Return whether a dataset has orientations."""
    return all(name in dataset.point_columns for name in ORIENTATION)


def vectors_of(dataset: Dataset) -> Array:
    """Return the measured rotation vectors ``(P, 3)`` [rad] of a dataset that has them."""
    return np.column_stack([dataset.point_columns[name] for name in ORIENTATION])


def angles_left(arm: Array, measured: Array, X: Array, Y: Array) -> Array:
    """Return the angle ``(N,)`` [rad] of each measured rotation from ``Y arm X``; arguments ``(N, 3, 3)`` and ``(3, 3)``."""
    return rotation_angle(np.swapaxes(Y @ arm @ X, 1, 2) @ measured)


def constants(arm: Array, measured: Array, i: Array, j: Array, most: float = np.inf) -> tuple[Array, Array]:
    """Return the rotations X and Y that fit best.

    Args:
        arm: ``(N, 3, 3)``.
        measured: ``(N, 3, 3)``.
        i: ``(k,)``, first rows of the pairs between which the turns are compared.
        j: ``(k,)``, second rows.
        most: Largest turn [rad] of a pair that counts: near half a turn, a small error may turn the axis round.
    """
    of_arm = log_so3(np.swapaxes(arm[i], 1, 2) @ arm[j])
    of_measured = log_so3(np.swapaxes(measured[i], 1, 2) @ measured[j])
    clear = np.maximum(np.linalg.norm(of_arm, axis=1), np.linalg.norm(of_measured, axis=1)) < most
    # M_i' M_j = X' (R_i' R_j) X turns the axes by X'.
    X = nearest_rotation(of_arm[clear].T @ of_measured[clear])
    Y = nearest_rotation(np.sum(measured @ np.swapaxes(arm @ X, 1, 2), axis=0))
    return X, Y
