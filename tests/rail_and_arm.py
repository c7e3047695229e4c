"""An arm on a linear axis, simulated without the estimator's formulas: a shift along a line in space, then elementary matrices.

The rail's direction is off by milliradians, the arm is slightly displaced and tilted on its carriage, and every length and angle of the
arm has an error. The estimator gets the nominal arm as a chain of seven joints, the first of them prismatic.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from scalar.data.dataset import Dataset
from scalar.data.declared import PlaneGuess, Sensor
from scalar.geometry.robot import Robot
from tests import kinematics
from tests.kinematics import PARAMETER_KINDS
from tests.robot_configs import robot_mapping

TRAVEL = (-0.2, 1.6)  # m


def nominal_mapping(name: str = "vs060") -> dict[str, Any]:
    """Return the ``robot:`` block: a rail along x of the base frame, and an arm of ``configs/robots`` on it."""
    arm = robot_mapping(name)
    half = np.pi / 2
    rail = {"a": 0.0, "alpha": 0.0, "d": 0.0, "theta": 0.0, "limits": list(TRAVEL), "type": "prismatic"}
    first = dict(arm["joints"][0])
    first |= {"alpha": -half, "theta": first["theta"] - half}
    turn = np.array([[0.0, 0, 1], [1, 0, 0], [0, 1, 0]])  # z of the rail's frame along x, its x along y
    base = {"translation": [0, 0, 0], "rotation_vector": kinematics.rotation_vector(turn).tolist()}
    return {
        "name": f"{name} on a rail",
        "convention": "modified-dh",
        "joints": [rail, first, *arm["joints"][1:]],
        "base": base,
        "flange": arm.get("flange", {"translation": [0, 0, 0], "rotation_vector": [0, 0, 0]}),
    }


@dataclass(frozen=True, eq=False)
class RailAndArm:
    """The true workcell.

    Attributes:
        direction: ``(3,)``, of the rail.
        T_carriage_arm: ``(4, 4)``.
        geometry: ``(5, 6)``, of the arm.
        T_flange_tool: ``(4, 4)``.
        T_tracker_base: ``(4, 4)``.
    """

    direction: np.ndarray
    T_carriage_arm: np.ndarray
    geometry: np.ndarray
    T_flange_tool: np.ndarray
    T_tracker_base: np.ndarray

    @classmethod
    def drawn(cls, rng: np.random.Generator, name: str = "vs060") -> RailAndArm:
        """Return a random workcell with errors of a millimetre and some milliradians."""
        arm = robot_mapping(name)
        geometry = np.array([[j.get(kind, 0.0) for j in arm["joints"]] for kind in PARAMETER_KINDS])
        size = np.array([1e-3, 2e-3, 1e-3, 2e-3, 0.0])[:, None]
        near = np.abs(np.sin(geometry[1])) < 0.1
        error = size * rng.uniform(-1, 1, geometry.shape)
        error[1, near] *= 0.5
        direction = np.array([1.0, 3e-3 * rng.normal(), 3e-3 * rng.normal()])
        tool = (
            kinematics.translation(2, 0.1) @ kinematics.translation(0, 0.06) @ kinematics.translation(1, 0.02)
        )
        return cls(
            direction / np.linalg.norm(direction),
            kinematics.random_transform(rng, 2e-3, 5e-3),
            geometry + error,
            kinematics.transform(arm.get("flange")) @ tool @ kinematics.random_transform(rng, 3e-3, 1e-2),
            kinematics.random_transform(rng, 2.0, 1.0),
        )

    def tool(self, q: np.ndarray) -> np.ndarray:
        """Return where the tool is in the base frame ``(N, 4, 4)`` at travels and angles ``(N, 7)`` [m, rad]."""
        T = np.tile(np.eye(4), (len(q), 1, 1))
        T[:, :3, 3] = q[:, :1] * self.direction
        return T @ self.T_carriage_arm @ kinematics.chain(self.geometry, q[:, 1:]) @ self.T_flange_tool

    def dataset(
        self,
        q: np.ndarray,
        noise: float,
        rng: np.random.Generator,
        *,
        q_true: np.ndarray | None = None,
        columns: dict[str, np.ndarray] | None = None,
    ) -> Dataset:
        """Return what a tracker measures of the tool's origin where the encoders read ``q`` ``(N, 7)`` and the joints stand at ``q_true``."""
        T = self.T_tracker_base @ self.tool(q if q_true is None else q_true)
        points = T[:, :3, 3] + noise * rng.normal(size=(len(q), 3))
        guess = (
            kinematics.translation(2, 0.1) @ kinematics.translation(0, 0.06) @ kinematics.translation(1, 0.02)
        )
        return Dataset.from_arrays(
            robot=Robot.from_mapping(nominal_mapping()),
            sensor=Sensor("tracker", guess, noise=max(noise, 1e-5)),
            q=q,
            points=points,
            columns=columns,
        )

    def scans(self, q: np.ndarray, per_plane: int) -> Dataset:
        """Return scans of three planes, without noise, from the first poses ``(N, 7)`` at which the laser meets a plane well."""
        normals = np.array([[0.02, -0.01, 1.0], [1.0, 0.03, 0.02], [-0.01, 1.0, 0.02]])
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        distances = np.array([-0.6, 2.8, 1.3])
        T, x = self.tool(q), np.linspace(-0.06, 0.06, 15)
        chosen, points, labels = [], [], []
        for k, (n, d) in enumerate(zip(normals, distances, strict=True)):
            steep = np.abs(T[:, :3, 2] @ n) > 0.5
            z = (d - T[:, :3, 3] @ n)[:, None] - x * (T[:, :3, 0] @ n)[:, None]
            z = z / np.where(steep, T[:, :3, 2] @ n, 1.0)[:, None]
            seen = np.flatnonzero(steep & np.all((z > 0.1) & (z < 1.8), axis=1))[:per_plane]
            assert len(seen) == per_plane
            chosen += list(seen)
            labels += [f"plane_{k}"] * per_plane
            points += [np.column_stack([x, z[i]]) for i in seen]
        guess = (
            kinematics.translation(2, 0.1) @ kinematics.translation(0, 0.06) @ kinematics.translation(1, 0.02)
        )
        return Dataset.from_arrays(
            robot=Robot.from_mapping(nominal_mapping()),
            sensor=Sensor("line-laser", guess, noise=1e-5),
            q=q[chosen],
            points=points,
            planes=[PlaneGuess(f"plane_{k}", np.roll([0.0, 0, 1], k), d) for k, d in enumerate(distances)],
            plane=labels,
        )


def poses(count: int, rng: np.random.Generator) -> np.ndarray:
    """Return travels and angles ``(N, 7)`` [m, rad] within the limits."""
    limits = Robot.from_mapping(nominal_mapping()).limits
    return rng.uniform(*limits.T, (count, len(limits)))


def off_by_a_motion(found: np.ndarray, true: np.ndarray) -> np.ndarray:
    """Return how far places ``(N, 3)`` are from others after the best rigid motion, ``(N,)`` [m] (Kabsch)."""
    a, b = found - found.mean(axis=0), true - true.mean(axis=0)
    U, _, Vt = np.linalg.svd(a.T @ b)
    R = U @ np.diag([1, 1, np.linalg.det(U @ Vt)]) @ Vt
    return np.linalg.norm(a @ R - b, axis=1)
