"""Simulate an arm with several targets on its flange before a tracker, by elementary matrices: nothing here calls the estimator's formulas."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from scalar.data.dataset import Dataset
from scalar.data.declared import Sensor
from scalar.data.io.plain_yaml import load_yaml
from scalar.geometry.robot import Robot
from study.common import kinematics
from study.common.kinematics import PARAMETER_KINDS, best_motion

ROBOTS = Path(__file__).parents[3] / "configs/robots"
GUESS = kinematics.translation(0, 0.05) @ kinematics.translation(2, 0.1)
"""The declared pose ``T_flange_sensor`` of the first target."""


@cache
def robot_mapping(name: str) -> Any:
    """Return the content of ``configs/robots/<name>.yaml``, not to be changed."""
    return load_yaml(ROBOTS / f"{name}.yaml")


@dataclass(frozen=True, eq=False)
class TrackedArm:
    """The true workcell: an arm, targets on its flange, and a tracker.

    Attributes:
        name: Name of the arm in ``configs/robots``.
        geometry: ``(5, n)`` [m, rad], the true parameters, which differ from the nominal ones by a millimetre and a few milliradians.
        targets: ``{name: T_flange_target (4, 4)}``.
        T_tracker_base: ``(S, 4, 4)``, the base in the tracker's frame in each session.
    """

    name: str
    geometry: np.ndarray
    targets: dict[str, np.ndarray]
    T_tracker_base: np.ndarray

    @classmethod
    def drawn(
        cls, rng: np.random.Generator, targets: tuple[str, ...], name: str, sessions: int = 1
    ) -> TrackedArm:
        """Return a workcell whose targets sit within 0.15 m of the flange, the first near ``GUESS``.

        Args:
            rng: Draws the errors of the geometry, the targets' places and the tracker's.
            targets: Names of the targets.
            name: Name of the arm in ``configs/robots``.
            sessions: Number of sessions; in each the tracker has another place.
        """
        joints = robot_mapping(name)["joints"]
        geometry = np.array([[j.get(kind, 0.0) for j in joints] for kind in PARAMETER_KINDS])
        size = np.array([1e-3, 2e-3, 1e-3, 2e-3, 0.0])[:, None]
        error = size * rng.uniform(-1, 1, geometry.shape)
        error[1, np.abs(np.sin(geometry[1])) < 0.1] *= 0.5
        first, *others = targets
        T_flange_target = {first: GUESS @ kinematics.random_transform(rng, 3e-3, 2e-2)}
        for other in others:
            T_flange_target[other] = GUESS @ kinematics.random_transform(rng, 0.15, 1.5)
        frames = np.stack([kinematics.random_transform(rng, 2.0, 1.0) for _ in range(sessions)])
        return cls(name, geometry + error, T_flange_target, frames)

    @property
    def robot(self) -> Robot:
        """Return the nominal arm."""
        return Robot.from_mapping({"name": self.name, **robot_mapping(self.name)})

    def poses(self, count: int, rng: np.random.Generator) -> np.ndarray:
        """Return joint angles ``(N, n)`` [rad] within the limits."""
        low, high = self.robot.limits.T
        return rng.uniform(low, high, (count, self.robot.n_joints))

    @property
    def T_n_flange(self) -> np.ndarray:
        """Return the flange in the last joint's frame ``(4, 4)``."""
        return kinematics.transform(robot_mapping(self.name).get("flange"))

    def at(self, q: np.ndarray, target: str) -> np.ndarray:
        """Return the true frames of a target in the base frame ``(N, 4, 4)``, at joint angles ``(N, n)`` [rad]."""
        return kinematics.chain(self.geometry, q) @ self.T_n_flange @ self.targets[target]

    def dataset(
        self,
        q: np.ndarray,
        rng: np.random.Generator,
        *,
        noise: Any = 0.0,
        turn_noise: float | None = None,
        seen: np.ndarray | None = None,
        session: np.ndarray | None = None,
        stated: dict[str, Any] | None = None,
        q_true: np.ndarray | None = None,
        T_base_flange: np.ndarray | None = None,
        columns: dict[str, Any] | None = None,
    ) -> Dataset:
        """Return the dataset that the tracker measures.

        Args:
            q: ``(N, n)`` [rad], joint angles as the encoders read them.
            rng: Draws the noise.
            noise: Standard deviation of a coordinate [m], one number or ``(N, K)``.
            turn_noise: Standard deviation of a rotation about each axis [rad]; None: positions alone are measured.
            seen: ``(N, K)`` bool, which targets are measured at each pose; None: all.
            session: ``(N,)``, session of each pose.
            stated: What the dataset states of the sensor: ``noise``, ``rotation_noise``, and further ``point_columns``.
            q_true: ``(N, n)`` [rad], true joint angles; None: those that the encoders read.
            T_base_flange: ``(N, 4, 4)``, true frames of the flange; None: those at ``q_true``.
            columns: Further columns of poses.csv.
        """
        stated = dict(stated or {})
        N, K = len(q), len(self.targets)
        seen = np.ones((N, K), dtype=bool) if seen is None else seen
        frames = self.T_tracker_base[np.zeros(N, dtype=int) if session is None else session]
        if T_base_flange is None:
            T_base_flange = kinematics.chain(self.geometry, q if q_true is None else q_true) @ self.T_n_flange
        T = np.stack([frames @ T_base_flange @ target for target in self.targets.values()], axis=1)
        noise = np.broadcast_to(noise, (N, K))
        points = T[:, :, :3, 3] + noise[:, :, None] * rng.normal(size=(N, K, 3))
        further: dict[str, Any] = {}
        if K > 1:
            further["target"] = np.tile(np.array(list(self.targets), dtype=object), (N, 1))[seen]
        if turn_noise is not None:
            small = turn_noise * rng.normal(size=(N, K, 3))
            turns = np.array(
                [
                    kinematics.rotate_about(v, float(np.linalg.norm(v))) if np.any(v) else np.eye(3)
                    for v in small.reshape(-1, 3)
                ]
            ).reshape(N, K, 3, 3)
            vectors = kinematics.rotation_vector(turns @ T[:, :, :3, :3])[seen]
            further |= dict(zip(("rx", "ry", "rz"), vectors.T, strict=True))
        for name, values in stated.pop("point_columns", {}).items():
            further[name] = np.broadcast_to(values, (N, K))[seen]
        if session is not None:
            columns = {**(columns or {}), "session": [f"day {s}" for s in session]}
        options = {key: stated[key] for key in ("rotation_noise",) if key in stated}
        return Dataset.from_arrays(
            robot=self.robot,
            sensor=Sensor("tracker", GUESS, noise=stated.get("noise"), options=options),
            q=q,
            points=[points[i][seen[i]] for i in range(N)],
            point_columns=further,
            columns=columns,
        )


def relative(T: np.ndarray, reference: np.ndarray) -> np.ndarray:
    """Return frames ``T`` ``(N, 4, 4)`` after the rigid motion that fits their origins best to those of ``reference`` ``(N, 4, 4)`` (Kabsch)."""
    return best_motion(T[:, :3, 3], reference[:, :3, 3]) @ T
