"""What moves leave behind: a structure that still swings, and a scan taken while the joints pass by."""

from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np

from scalar.simulation.injected.causes.base import MoveCause, every_joint, scaled
from scalar.simulation.injected.stage import Stage
from scalar.simulation.transforms import Array

RESONANCE = (0.25, 0.6)  # of the largest speed: where the gear's teeth meet the structure's own frequency
DAMPING = 0.12
TRIGGER_SPREAD = 0.1  # of the delay, or [rad] of a swing's phase


@dataclass(frozen=True, eq=False)
class Vibration(MoveCause):
    """A joint still swings when the scan is taken, the more the nearer its speed on the way was to a resonance.

    Joints start and stop together, so their speeds are in proportion to their steps. The gear's teeth drive the structure at a
    frequency that is in proportion to speed; r = speed over resonance: r^2 / sqrt((1 - r^2)^2 + (2 zeta r)^2), and the phase
    lags by atan2(2 zeta r, 1 - r^2). The scan comes a fixed time after the stop, give or take.
    """

    kind: ClassVar[str] = "vibration"
    of_a_joint: ClassVar[bool] = True

    @classmethod
    def made(cls, target: dict[str, Any], size: float, stage: Stage, rng: np.random.Generator) -> Self:
        """Draw joint, resonance and the phase at the trigger."""
        joint = target.get("joint", stage.draw_joint(rng))
        step = np.diff(stage.q, axis=0, prepend=stage.q[:1])
        slowest = np.abs(step).max(1)  # in units of the largest speed: the move's duration
        speed = np.divide(step[:, joint - 1], slowest, out=np.zeros(len(step)), where=slowest > 0)
        resonance, phase = rng.uniform(*RESONANCE), rng.uniform(0.0, 2 * np.pi)
        late = TRIGGER_SPREAD * rng.standard_normal(len(step))
        swing = np.sign(speed) * amplitude(speed / resonance) * np.cos(phase + late - lag(speed / resonance))
        dq = np.zeros_like(stage.q)
        dq[:, joint - 1], _ = scaled(swing, size)
        details = cls.details_of([f"q{joint}", "order"], resonance=resonance, phase_rad=phase)
        return cls({"joint": joint}, size, details, states=dq)


def amplitude(r: Array) -> Array:
    """Return how far a structure swings that is driven at r times its own frequency (N,)."""
    return r**2 / np.sqrt((1 - r**2) ** 2 + (2 * DAMPING * r) ** 2)


def lag(r: Array) -> Array:
    """Return by how much [rad] it lags (N,)."""
    return np.arctan2(2 * DAMPING * np.abs(r), 1 - r**2)


@dataclass(frozen=True, eq=False)
class LateTrigger(MoveCause):
    """The arm scans as it passes; angles are logged at the trigger and light is taken a little later, or earlier.

    dq = velocity times the delay. The velocity at a pose is that of a path through its neighbours, over their times.
    """

    kind: ClassVar[str] = "late_trigger"

    @classmethod
    def made(cls, target: dict[str, Any], size: float, stage: Stage, rng: np.random.Generator) -> Self:
        """Draw the sign of the delay and how it varies."""
        time = stage.poses["time"].to_numpy(float)
        velocity = np.gradient(stage.q, axis=0) / np.gradient(time)[:, None]
        sign = rng.choice([-1.0, 1.0])
        delay = sign * (1.0 + TRIGGER_SPREAD * rng.standard_normal(len(time)))
        dq, seconds = scaled(velocity * delay[:, None], size)
        details = cls.details_of([*every_joint(stage.arm.n), "time"], delay_s=float(sign * seconds))
        return cls({}, size, details, states=dq)
