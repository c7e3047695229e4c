"""Compliance of joints under the arm's weight, by the engine's inverse dynamics, and under a payload, by virtual work; and of the pedestal."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np
import pandas as pd

from scalar.simulation.injected.base import InjectedEffect
from scalar.simulation.injected.stage import Stage
from scalar.simulation.load import payload_torques
from scalar.simulation.transforms import Array, rotation_from_vector, transform
from scalar.simulation.world import World


class CompliantJoints(InjectedEffect):
    """Compliance of joints under a torque: of the joints that the entry names, or of all that carry weight."""

    unit: ClassVar[str] = "rad/(N m)"

    @staticmethod
    def joints_of(entry: Mapping[str, Any], stage: Stage) -> list[int]:
        """Return the compliant joints, from 1."""
        return sorted(entry["target"].get("joints", stage.loaded))

    def are_compliant(self, q: Array) -> Array:
        """Return which of the joints of q (N, n) are compliant, (n,) bool."""
        return np.isin(np.arange(q.shape[1]) + 1, self.target["joints"])


@dataclass(frozen=True, eq=False)
class JointCompliance(CompliantJoints):
    """dq_j = size times the torque of the weight about joint j [N m], for some joints or all that carry weight."""

    name: ClassVar[str] = "joint_compliance"

    @classmethod
    def inject(cls, entry: Mapping[str, Any], stage: Stage, rng: np.random.Generator) -> Self:
        """Take all joints that carry weight if the entry names none."""
        joints = cls.joints_of(entry, stage)
        largest = np.abs(stage.torques).max(0)
        assert stage.arm.weights is not None
        details = {
            "largest_deflection_rad": {f"joint{j}": float(entry["size"] * largest[j - 1]) for j in joints},
            "masses_kg": stage.arm.weights.masses.tolist(),
            "centres_m": stage.arm.weights.centres.tolist(),
            "sensor_kg": stage.arm.weights.sensor,
        }
        return cls({"joints": joints}, entry["size"], details)

    def joint_errors(self, world: World, q: Array, poses: pd.DataFrame) -> Array:
        """Return the deflections (N, n) [rad]."""
        return self.size * self.are_compliant(q) * world.gravity_torques(q)


@dataclass(frozen=True, eq=False)
class PayloadDeflection(CompliantJoints):
    """dq_j = size times the torque of the payload about joint j [N m], for some joints or all that carry weight."""

    T_flange_sensor: Array

    name: ClassVar[str] = "payload_deflection"

    @classmethod
    def needs(cls, entry: Mapping[str, Any]) -> set[str]:
        """Return the payload."""
        return {"payload"}

    @classmethod
    def inject(cls, entry: Mapping[str, Any], stage: Stage, rng: np.random.Generator) -> Self:
        """Take all joints that carry weight if the entry names none."""
        joints = cls.joints_of(entry, stage)
        return cls({"joints": joints}, entry["size"], {}, stage.arm.T_flange_sensor)

    def joint_errors(self, world: World, q: Array, poses: pd.DataFrame) -> Array:
        """Return the deflections (N, n) [rad]."""
        return self.size * self.are_compliant(q) * payload_torques(world, self.T_flange_sensor, q, poses)


@dataclass(frozen=True, eq=False)
class TorqueCompliance(PayloadDeflection):
    """dq_j = size times the torque of the weight of arm and payload about joint j [N m], where poses.csv records the torques."""

    name: ClassVar[str] = "torque_compliance"

    @classmethod
    def needs(cls, entry: Mapping[str, Any]) -> set[str]:
        """Return torques and payload."""
        return {"payload", "torque"}

    def joint_errors(self, world: World, q: Array, poses: pd.DataFrame) -> Array:
        """Return the deflections (N, n) [rad]."""
        return super().joint_errors(world, q, poses) + self.size * self.are_compliant(
            q
        ) * world.gravity_torques(q)


@dataclass(frozen=True, eq=False)
class BaseCompliance(InjectedEffect):
    """The arm turns about its pedestal's pivot by size times the moment of its weight about the pivot [N m]."""

    name: ClassVar[str] = "base_compliance"
    unit: ClassVar[str] = "rad/(N m)"

    @classmethod
    def inject(cls, entry: Mapping[str, Any], stage: Stage, rng: np.random.Generator) -> Self:
        """Draw nothing."""
        assert stage.arm.weights is not None
        details = {
            "pivot_m": list(entry["pivot_m"]),
            "masses_kg": stage.arm.weights.masses.tolist(),
            "centres_m": stage.arm.weights.centres.tolist(),
            "sensor_kg": stage.arm.weights.sensor,
        }
        with World() as world:
            world.place_arm(stage.arm)
            tilts = entry["size"] * world.weight_moments(stage.q, np.array(entry["pivot_m"], float))
        details["largest_tilt_rad"] = float(np.linalg.norm(tilts, axis=1).max())
        return cls({}, entry["size"], details)

    def motions(self, world: World, q: Array, poses: pd.DataFrame) -> Array:
        """Return the turn about the pivot at each pose (N, 4, 4)."""
        pivot = np.array(self.details["pivot_m"], float)
        frames = np.empty((len(q), 4, 4))
        for k, vector in enumerate(self.size * world.weight_moments(q, pivot)):
            R = rotation_from_vector(vector)
            frames[k] = transform(R, pivot - R @ pivot)
        return frames
