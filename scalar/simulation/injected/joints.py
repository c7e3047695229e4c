"""Errors of gears and encoders: harmonics, scale, coupling, backlash."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np
import pandas as pd

from scalar.simulation.injected.base import JointError
from scalar.simulation.injected.stage import Stage
from scalar.simulation.transforms import Array
from scalar.simulation.world import World

HIGHEST_ORDER = 32
NEIGHBOURS = 2  # the gears of a wrist couple a joint to the one before it, or to the one before that


@dataclass(frozen=True, eq=False)
class JointHarmonic(JointError):
    """dq = sum over orders of size sin(order q + phase)."""

    name: ClassVar[str] = "joint_harmonic"
    unit: ClassVar[str] = "rad"

    @classmethod
    def inject(cls, entry: Mapping[str, Any], stage: Stage, rng: np.random.Generator) -> Self:
        """Draw joint, order and phases."""
        target = dict(entry["target"])
        joint = stage.draw_joint(rng)
        order = int(rng.integers(1, HIGHEST_ORDER + 1))
        orders = target.get("orders") or [target.get("order", order)]
        phases = entry["phases_rad"] or rng.uniform(0.0, 2 * np.pi, len(orders)).tolist()
        if len(phases) != len(orders):
            stage.refuse("phases_rad", f"{len(phases)} phases for {len(orders)} orders; give one for each")
        named = {"order": orders[0]} if len(orders) == 1 else {"orders": list(orders)}
        return cls({"joint": target.get("joint", joint)} | named, entry["size"], {"phases_rad": phases})

    def error(self, world: World, q: Array, poses: pd.DataFrame) -> Array:
        """Return the sum of the sines."""
        orders = np.array(self.target.get("orders") or [self.target["order"]])
        angle = q[:, self.target["joint"] - 1, None]
        return self.size * np.sin(angle * orders + self.details["phases_rad"]).sum(1)


@dataclass(frozen=True, eq=False)
class JointScale(JointError):
    """dq = size q."""

    name: ClassVar[str] = "joint_scale"
    unit: ClassVar[str] = "rad/rad"

    @classmethod
    def inject(cls, entry: Mapping[str, Any], stage: Stage, rng: np.random.Generator) -> Self:
        """Draw the joint."""
        return cls({"joint": stage.draw_joint(rng)} | entry["target"], entry["size"], {})

    def error(self, world: World, q: Array, poses: pd.DataFrame) -> Array:
        """Return the error (N,) [rad], proportional to the joint's own angle."""
        return self.size * q[:, self.target["joint"] - 1]


@dataclass(frozen=True, eq=False)
class JointCoupling(JointError):
    """dq = size q_source."""

    name: ClassVar[str] = "joint_coupling"
    unit: ClassVar[str] = "rad/rad"

    @classmethod
    def inject(cls, entry: Mapping[str, Any], stage: Stage, rng: np.random.Generator) -> Self:
        """Draw the joint and its source, a neighbour."""
        near = range(1, NEIGHBOURS + 1)
        pairs = [(j, j - k) for j in stage.influential for k in near if j - k >= 1]
        given = entry["target"]
        fitting = [pair for pair in pairs if given.get("joint", pair[0]) == pair[0]]
        fitting = [pair for pair in fitting if given.get("source", pair[1]) == pair[1]]
        if not fitting and not {"joint", "source"} <= set(given):
            stage.refuse("target", "no neighbouring joint is left to draw; name both joint and source")
        joint, source = fitting[int(rng.integers(len(fitting)))] if fitting else (0, 0)
        return cls({"joint": joint, "source": source} | given, entry["size"], {})

    def error(self, world: World, q: Array, poses: pd.DataFrame) -> Array:
        """Return the error (N,) [rad], proportional to the source's angle."""
        return self.size * q[:, self.target["source"] - 1]


@dataclass(frozen=True, eq=False)
class JointBacklash(JointError):
    """dq = size times -1 or 1, the side of its play on which the joint rests: by the direction of approach, or the sign of gravity's torque."""

    name: ClassVar[str] = "joint_backlash"
    unit: ClassVar[str] = "rad"

    @classmethod
    def needs(cls, entry: Mapping[str, Any]) -> set[str]:
        """Return the directions of approach, unless the torque of weight decides the side."""
        return {"approach"} if entry["recorded"] else set()

    @classmethod
    def inject(cls, entry: Mapping[str, Any], stage: Stage, rng: np.random.Generator) -> Self:
        """Draw the joint; if the torque of weight decides the side, one that carries weight."""
        if entry["recorded"]:
            joint = stage.draw_joint(rng)
        else:
            loaded = [j for j in stage.influential if j in stage.loaded]
            joint = stage.draw_joint(rng, loaded, "no joint carries weight that could choose a side")
            if entry["target"].get("joint", joint) not in stage.loaded:
                stage.refuse("target.joint", f"carries no weight that could choose a side; {stage.loaded} do")
        details = {"by": "approach" if entry["recorded"] else "torque"}
        return cls({"joint": joint} | entry["target"], entry["size"], details)

    def error(self, world: World, q: Array, poses: pd.DataFrame) -> Array:
        """Return half of the play (N,) [rad], to one side or the other."""
        joint = self.target["joint"]
        if self.details["by"] == "approach":
            return self.size * poses[f"approach{joint}"].to_numpy(float)
        return self.size * np.sign(world.gravity_torques(q)[:, joint - 1])
