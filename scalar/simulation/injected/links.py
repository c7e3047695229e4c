"""Injected errors of links: an axis that is not parallel to the one before, and lengths that grow."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np
import pandas as pd

from scalar.simulation.arm import Arm
from scalar.simulation.config import LENGTHS, length_names
from scalar.simulation.effects import Rows
from scalar.simulation.injected.base import InjectedEffect
from scalar.simulation.injected.stage import Stage
from scalar.simulation.transforms import Array

_NEARLY_PARALLEL = 0.05  # rad; axes at a smaller angle to each other are meant to be parallel
_TIME_CONSTANTS = 3.0  # that a warm-up lasts: the campaign ends at 1 - exp(-3) = 95 % of the growth that an endless one would reach


@dataclass(frozen=True, eq=False)
class AxisNonparallel(InjectedEffect):
    """A tilt by Hayati's beta of a joint whose axis is meant to be parallel to the one before."""

    name: ClassVar[str] = "axis_nonparallel"
    unit: ClassVar[str] = "rad"

    @classmethod
    def inject(cls, entry: Mapping[str, Any], stage: Stage, rng: np.random.Generator) -> Self:
        """Draw the joint among those with near-parallel axes."""
        n = stage.arm.n
        alpha = stage.workcell.nominal.alpha
        parallel = [j for j in range(2, n + 1) if abs(np.sin(alpha[j - 1])) < _NEARLY_PARALLEL]
        joint = entry["target"].get("joint")
        if joint is None:
            joint = stage.draw_joint(rng, parallel, "this arm has no axis parallel to the one before")
        if joint not in parallel:
            others = f"; those of joints {', '.join(map(str, parallel))} are" if parallel else ""
            stage.refuse(
                "target.joint", f"the axis of joint {joint} is not parallel to the one before{others}"
            )
        return cls({"joint": joint}, entry["size"], {})

    def arms(self, arm: Arm, poses: pd.DataFrame, evaluating: bool) -> list[tuple[Rows, Arm]]:
        """Return one arm for all poses: that with the tilt."""
        beta = np.zeros(arm.n)
        beta[self.target["joint"] - 1] = self.size
        return [(slice(None), arm.shifted({"beta": beta}))]


@dataclass(frozen=True, eq=False)
class ThermalDrift(InjectedEffect):
    """Lengths grow by ``size`` times a profile over the temperature or the time; the profile is 0 at the first pose and 1 at the last."""

    name: ClassVar[str] = "thermal_drift"
    unit: ClassVar[str] = "m/m"

    @classmethod
    def needs(cls, entry: Mapping[str, Any]) -> set[str]:
        """Return the column of the poses over which lengths grow: ``temperature`` or ``time``."""
        return {entry["by"]}

    @classmethod
    def inject(cls, entry: Mapping[str, Any], stage: Stage, rng: np.random.Generator) -> Self:
        """Return the drift of the lengths that the entry names, or of all if it names none; nothing is drawn."""
        lengths = entry["lengths"] or length_names(stage.arm.n)
        driver = stage.poses[entry["by"]].to_numpy(float)
        details = {
            "by": entry["by"],
            "course": entry["profile"],  # truth.json keeps the former name of the key
            "from": float(driver[0]),
            "to": float(driver[-1]),
            "lengths": lengths,
        }
        return cls({}, entry["size"], details)

    def growth(self, poses: pd.DataFrame) -> Array:
        """Return the relative growth of the lengths at each pose (N,) [m/m]."""
        start, end = self.details["from"], self.details["to"]
        share = (poses[self.details["by"]].to_numpy(float) - start) / (end - start or 1.0)
        if self.details["course"] == "warm_up":
            share = 1.0 - np.exp(-_TIME_CONSTANTS * share)
            share = share / (1.0 - np.exp(-_TIME_CONSTANTS))
        return self.size * share

    def arms(self, arm: Arm, poses: pd.DataFrame, evaluating: bool) -> list[tuple[Rows, Arm]]:
        """Return an arm for each different growth, with the indices of the poses at which the lengths have grown so far."""
        growths, which = np.unique(self.growth(poses), return_inverse=True)
        grows = np.isin(length_names(arm.n), self.details["lengths"]).reshape(len(LENGTHS), arm.n)
        grown = []
        for k, growth in enumerate(growths):
            errors = {kind: growth * grows[i] * getattr(arm, kind) for i, kind in enumerate(LENGTHS)}
            grown.append((np.flatnonzero(which == k), arm.shifted(errors)))
        return grown
