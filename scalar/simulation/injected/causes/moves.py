"""Errors from the moves between poses: a structure that still vibrates, and a scan taken while the joints move."""

from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np

from scalar.simulation.injected.causes.base import MoveCause, every_joint, scaled
from scalar.simulation.injected.stage import Stage
from scalar.simulation.transforms import Array

# Bounds of the speed at which the gear's teeth excite the natural frequency, relative to the largest speed.
RESONANCE = (0.25, 0.6)
DAMPING = 0.12  # damping ratio zeta
TRIGGER_STD = 0.1  # standard deviation of the delay relative to its mean, and of a vibration's phase at the trigger [rad]


@dataclass(frozen=True, eq=False)
class Vibration(MoveCause):
    """A joint still vibrates when the scan is taken, and vibrates more if its speed during the move was near a resonance.

    Joints start and stop together, so their speeds are proportional to their steps. The gear's teeth drive the structure at a
    frequency proportional to the speed. With r = speed over resonance, the amplitude is r^2 / sqrt((1 - r^2)^2 + (2 zeta r)^2),
    and the phase lags by atan2(2 zeta r, 1 - r^2). The scan is taken a nearly fixed time after the stop.
    """

    kind: ClassVar[str] = "vibration"
    of_a_joint: ClassVar[bool] = True

    @classmethod
    def drawn(cls, target: dict[str, Any], size: float, stage: Stage, rng: np.random.Generator) -> Self:
        """Draw joint, resonance and the phase at the trigger."""
        joint = target.get("joint", stage.draw_joint(rng))
        step = np.diff(stage.q, axis=0, prepend=stage.q[:1])
        largest = np.abs(step).max(1)  # the farthest joint moves at the largest speed
        speed = np.divide(step[:, joint - 1], largest, out=np.zeros(len(step)), where=largest > 0)
        resonance, phase = rng.uniform(*RESONANCE), rng.uniform(0.0, 2 * np.pi)
        late = TRIGGER_STD * rng.standard_normal(len(step))
        swing = np.sign(speed) * amplitude(speed / resonance) * np.cos(phase + late - lag(speed / resonance))
        dq = np.zeros_like(stage.q)
        dq[:, joint - 1], _ = scaled(swing, size)
        details = cls.details_of([f"q{joint}", "order"], resonance=resonance, phase_rad=phase)
        return cls({"joint": joint}, size, details, states=dq)


def amplitude(r: Array) -> Array:
    """Return the relative amplitude (N,) of a structure that is driven at r times its natural frequency."""
    return r**2 / np.sqrt((1 - r**2) ** 2 + (2 * DAMPING * r) ** 2)


def lag(r: Array) -> Array:
    """Return the phase [rad] by which such a structure lags (N,)."""
    return np.arctan2(2 * DAMPING * np.abs(r), 1 - r**2)


@dataclass(frozen=True, eq=False)
class LateTrigger(MoveCause):
    """The arm scans while it moves; angles are logged at the trigger, and the light is recorded a little later or earlier.

    dq = velocity times the delay. The velocity at a pose is the central difference of the angles of its neighbours over their times.
    """

    kind: ClassVar[str] = "late_trigger"

    @classmethod
    def drawn(cls, target: dict[str, Any], size: float, stage: Stage, rng: np.random.Generator) -> Self:
        """Draw the sign of the delay and its random variation."""
        time = stage.poses["time"].to_numpy(float)
        velocity = np.gradient(stage.q, axis=0) / np.gradient(time)[:, None]
        sign = rng.choice([-1.0, 1.0])
        delay = sign * (1.0 + TRIGGER_STD * rng.standard_normal(len(time)))
        dq, seconds = scaled(velocity * delay[:, None], size)
        details = cls.details_of([*every_joint(stage.arm.n), "time"], delay_s=float(sign * seconds))
        return cls({}, size, details, states=dq)
