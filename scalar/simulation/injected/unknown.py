"""Effects without a known name: significant structure for which a diagnosis should not state a name."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np
import pandas as pd

from scalar.simulation.arm import Arm
from scalar.simulation.effects import Rows
from scalar.simulation.injected.base import InjectedEffect
from scalar.simulation.injected.sensor import draw_direction
from scalar.simulation.injected.stage import Stage
from scalar.simulation.transforms import Array
from scalar.simulation.world import World

KINDS = (
    "angle_bump",
    "angle_product",
    "angle_step",
    "angle_sum",
    "base_sway",
    "belt",
    "encoder_drift",
    "late_jump",
    "sensor_oscillation",
    "worn_teeth",
)
IN_TIME = ("base_sway", "encoder_drift", "late_jump", "sensor_oscillation")
BUMP_WIDTH = 0.08  # standard deviation of a bump, over the range of the joint's angles in the data
STEEPNESS = 100.0  # steepness of a step: its width is a hundredth of that range
PERIODS = (1.5, 3.5)  # number of periods of an oscillation in a run
MIDDLE = (0.35, 0.65)  # part of the joint's range, or of the run, in which a bump, a step or a jump lies
# Half the width of worn teeth at half their depth, over the joint's range; each flank is as wide.
TEETH = 0.12
BELT_PERIODS = (4.2, 8.8)  # periods of a belt's sawtooth in the joint's range


@dataclass(frozen=True, eq=False)
class Unknown(InjectedEffect):
    """One of `KINDS`; the details say which, and on what it depends.

    These kinds are errors of one joint:
    angle_bump: size exp(-s^2 / 2), s counted in standard deviations from one angle.
    angle_product: size times the product of two joints' angles, each scaled to -1..1 over its range.
    angle_step: size beyond one angle.
    angle_sum: size times the cosine of twice a joint's angle plus that of another.
    belt: a sawtooth from -size to size over the joint's angle.
    worn_teeth: size in one part of the joint's range, with straight flanks.
    encoder_drift: size times the share of the run's time that has passed.
    late_jump: size from one moment on.

    In sensor_oscillation the sensor moves on the flange by size sin(2 pi n t + phase), t from 0 to 1 over the run, along one
    direction; at the evaluation poses it does not. In base_sway the base moves in the same way.
    """

    name: ClassVar[str] = "unknown"
    unit: ClassVar[str] = "rad"

    @classmethod
    def needs(cls, entry: Mapping[str, Any]) -> set[str]:
        """Return the time, for the kinds that depend on it."""
        return {"time"} if entry["kind"] in IN_TIME else set()

    @classmethod
    def inject(cls, entry: Mapping[str, Any], stage: Stage, rng: np.random.Generator) -> Self:
        """Draw the joints, the place in their range or in the run, and directions."""
        kind, target = entry["kind"], dict(entry["target"])
        details: dict[str, Any] = {"kind": kind}
        if kind in ("sensor_oscillation", "base_sway"):
            if "joint" in target:
                stage.refuse("target.joint", f"'{kind}' has no joint")
            details |= {
                "unit": "m",
                "direction": draw_direction(rng).tolist(),
                "periods": rng.uniform(*PERIODS),
                "phase_rad": rng.uniform(0.0, 2 * np.pi),
                "end_s": float(stage.poses["time"].iloc[-1]),
                "depends_on": ["time"],
            }
            return cls({}, entry["size"], details)
        low, high = stage.q.min(0), stage.q.max(0)
        # A drift of the first joint is confounded with target planes that move about its axis, one of the last joint with a sensor that does.
        ends = (1, stage.arm.n) if kind in ("encoder_drift", "late_jump") else ()
        joint = stage.draw_joint(
            rng, [j for j in stage.influential if j not in ends], "no joint is left to drift"
        )
        joint = target.get("joint", joint)
        place = rng.uniform(*MIDDLE)
        j = joint - 1
        if kind in ("angle_product", "angle_sum"):
            pair = sorted(rng.choice(stage.arm.n, 2, replace=False).tolist())
            details["factors"] = [i + 1 for i in pair]
            details["ranges_rad"] = [[float(low[i]), float(high[i])] for i in pair]
            details["depends_on"] = [f"q{i + 1}" for i in pair]
        elif kind in IN_TIME:
            details["end_s"] = float(stage.poses["time"].iloc[-1])
            details["share"] = place
            details["depends_on"] = ["time"]
        else:
            narrow = {"angle_bump": BUMP_WIDTH, "angle_step": 1.0 / STEEPNESS, "worn_teeth": TEETH}
            width = narrow.get(kind) or 1.0 / rng.uniform(*BELT_PERIODS)
            details["place_rad"] = float(low[j] + place * (high[j] - low[j]))
            details["width_rad"] = float(width * (high[j] - low[j]))
            details["depends_on"] = [f"q{joint}"]
        return cls({"joint": joint}, entry["size"], details)

    def joint_errors(self, world: World, q: Array, poses: pd.DataFrame) -> Array:
        """Return dq (N, n) [rad]."""
        dq = np.zeros_like(q)
        if "joint" in self.target:
            j = self.target["joint"] - 1
            dq[:, j] = self.size * _SHAPES[self.details["kind"]](self.details, q, q[:, j], poses)
        return dq

    def arms(self, arm: Arm, poses: pd.DataFrame, evaluating: bool) -> list[tuple[Rows, Arm]]:
        """Return an arm for each pose, with the sensor shifted on the flange as at that time."""
        if self.details["kind"] != "sensor_oscillation" or evaluating:
            return [(slice(None), arm)]
        return [(np.array([k]), arm.shifted({"t": shift})) for k, shift in enumerate(self._sway(poses))]

    def motions(self, world: World, q: Array, poses: pd.DataFrame) -> Array:
        """Return a motion of the base (N, 4, 4) for each pose."""
        T = np.tile(np.eye(4), (len(q), 1, 1))
        if self.details["kind"] == "base_sway" and "time" in poses:
            T[:, :3, 3] = self._sway(poses)
        return T

    def _sway(self, poses: pd.DataFrame) -> Array:
        """Return the shift of sensor or base at each pose (N, 3) [m]."""
        share = poses["time"].to_numpy(float) / self.details["end_s"]
        swing = np.sin(2 * np.pi * self.details["periods"] * share + self.details["phase_rad"])
        return self.size * swing[:, None] * np.array(self.details["direction"])


def _bump(details: Mapping[str, Any], q: Array, angle: Array, poses: pd.DataFrame) -> Array:
    return np.exp(-(((angle - details["place_rad"]) / details["width_rad"]) ** 2) / 2)


def _step(details: Mapping[str, Any], q: Array, angle: Array, poses: pd.DataFrame) -> Array:
    return (np.tanh((angle - details["place_rad"]) / details["width_rad"]) + 1.0) / 2


def _product(details: Mapping[str, Any], q: Array, angle: Array, poses: pd.DataFrame) -> Array:
    low, high = np.array(details["ranges_rad"]).T
    scaled = (2 * q[:, np.array(details["factors"]) - 1] - low - high) / (high - low)
    return scaled.prod(1)


def _teeth(details: Mapping[str, Any], q: Array, angle: Array, poses: pd.DataFrame) -> Array:
    return np.clip(1.5 - np.abs(angle - details["place_rad"]) / details["width_rad"], 0.0, 1.0)


def _belt(details: Mapping[str, Any], q: Array, angle: Array, poses: pd.DataFrame) -> Array:
    return 2 * np.mod((angle - details["place_rad"]) / details["width_rad"], 1.0) - 1.0


def _sum(details: Mapping[str, Any], q: Array, angle: Array, poses: pd.DataFrame) -> Array:
    a, b = (q[:, i - 1] for i in details["factors"])
    return np.cos(2 * a + b)


def _jump(details: Mapping[str, Any], q: Array, angle: Array, poses: pd.DataFrame) -> Array:
    return (poses["time"].to_numpy(float) > details["share"] * details["end_s"]).astype(float)


def _drift(details: Mapping[str, Any], q: Array, angle: Array, poses: pd.DataFrame) -> Array:
    return poses["time"].to_numpy(float) / details["end_s"]


_SHAPES: dict[str, Callable[[Mapping[str, Any], Array, Array, pd.DataFrame], Array]] = {
    "angle_bump": _bump,
    "angle_product": _product,
    "angle_step": _step,
    "angle_sum": _sum,
    "belt": _belt,
    "encoder_drift": _drift,
    "late_jump": _jump,
    "worn_teeth": _teeth,
}
