"""Errors from the climate of the hall: links that grow and shrink with the air conditioning, or warm up between pauses."""

from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np
import pandas as pd

from scalar.simulation.arm import Arm
from scalar.simulation.config import LENGTHS
from scalar.simulation.effects import Rows
from scalar.simulation.injected.causes.base import Cause
from scalar.simulation.injected.stage import Stage
from scalar.simulation.transforms import Array

AIR = (200.0, 420.0)  # s: time constant in which the air follows heat or cold
STEPS_A_POSE = 20  # steps of the thermostat's differential equation for each pose
BAND = 0.5  # the thermostat switches at plus and minus this share of the temperature that constant heat (plus) or cold (minus) would reach
ARM_SHARE = (0.3, 0.8)  # ratio of the arm's time constant to the air's
PERIOD_POSES = (42, 48)  # number of poses from pause to pause


@dataclass(frozen=True, eq=False)
class GrowingLinks(Cause):
    """All lengths grow by `states` (N,) [m/m]; at the evaluation poses they have the growth of the run's end."""

    unit: ClassVar[str] = "m/m"

    def arms(self, arm: Arm, poses: pd.DataFrame, evaluating: bool) -> list[tuple[Rows, Arm]]:
        """Return an arm for each different growth."""
        growth = self.state(poses)
        growth = np.full(len(poses), self.details["growth_at_end"]) if growth is None else growth
        values, which = np.unique(growth, return_inverse=True)
        return [
            (np.flatnonzero(which == k), arm.shifted({name: value * getattr(arm, name) for name in LENGTHS}))
            for k, value in enumerate(values)
        ]


@dataclass(frozen=True, eq=False)
class AirConditioning(GrowingLinks):
    """A thermostat switches between heat and cold; the air follows it, and the arm follows the air, each to first order."""

    kind: ClassVar[str] = "air_conditioning"

    @classmethod
    def drawn(cls, target: dict[str, Any], size: float, stage: Stage, rng: np.random.Generator) -> Self:
        """Draw the time constants and where in its period the run begins."""
        time = stage.poses["time"].to_numpy(float)
        air, share, before = rng.uniform(*AIR), rng.uniform(*ARM_SHARE), rng.uniform(3.0, 6.0)
        temperature = thermostat(time, air, air * share, before * air)
        growth = temperature * size / np.abs(temperature).max()
        details = cls.details_of(["time"], air_s=air, arm_s=air * share, growth_at_end=float(growth[-1]))
        return cls({}, size, details, states=growth)


def thermostat(time: Array, air: float, arm: float, before: float) -> Array:
    """Return the arm's temperature (N,) at times (N,) [s], in units of half the distance between heat and cold.

    Args:
        air, arm: time constants [s].
        before: time [s] for which the thermostat has run when the first pose is taken.
    """
    step = float(np.median(np.diff(time))) / STEPS_A_POSE
    grid = np.arange(time[0] - before, time[-1] + step, step)
    heat, T_air, T_arm = 1.0, 0.0, 0.0
    temperature = np.empty(len(grid))
    for k in range(len(grid)):
        T_air += step / air * (heat - T_air)
        T_arm += step / arm * (T_air - T_arm)
        if heat * T_air > BAND:
            heat = -heat
        temperature[k] = T_arm
    return np.interp(time, grid, temperature)


@dataclass(frozen=True, eq=False)
class SawtoothGrowth(GrowingLinks):
    """The arm warms while it works and cools in a pause, every 45 poses or so: growth rises and falls back."""

    kind: ClassVar[str] = "sawtooth_growth"

    @classmethod
    def drawn(cls, target: dict[str, Any], size: float, stage: Stage, rng: np.random.Generator) -> Self:
        """Draw the period and where in it the run begins."""
        period = int(rng.integers(PERIOD_POSES[0], PERIOD_POSES[1] + 1))
        start = int(rng.integers(period))
        growth = size * ((np.arange(len(stage.poses)) + start) % period) / (period - 1)
        details = cls.details_of(["order"], period_poses=period, growth_at_end=float(growth[-1]))
        return cls({}, size, details, states=growth)
