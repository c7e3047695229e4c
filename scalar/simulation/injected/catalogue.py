"""All injected effects by name, and the combination of several in one scene.

Joint errors add up, and so do range errors. Changes of the arm, of target planes and of the base are applied one after
the other. Each entry draws from a generator of its own, by its place in the list, so that what one effect draws
does not depend on the others, nor on any size.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
import pandas as pd

from scalar.simulation.arm import Arm
from scalar.simulation.effects import Effects, Rows
from scalar.simulation.injected.base import InjectedEffect
from scalar.simulation.injected.causes import CAUSES
from scalar.simulation.injected.compliance import (
    BaseCompliance,
    JointCompliance,
    PayloadDeflection,
    TorqueCompliance,
)
from scalar.simulation.injected.drift import TargetDrift
from scalar.simulation.injected.heat import RestartedWarmUp
from scalar.simulation.injected.joints import JointBacklash, JointCoupling, JointHarmonic, JointScale
from scalar.simulation.injected.links import AxisNonparallel, ThermalDrift
from scalar.simulation.injected.moves import BacklashByMoves, JointHysteresis, PoseLag
from scalar.simulation.injected.noise import PoseJitter, ScanBias
from scalar.simulation.injected.sensor import RangeDistortion, RangeOffset, RangeScale, SensorSlip
from scalar.simulation.injected.stage import Stage
from scalar.simulation.injected.surface import PlaneBow, PlaneMoved
from scalar.simulation.injected.unknown import Unknown
from scalar.simulation.noise import Noise
from scalar.simulation.plan import Workcell
from scalar.simulation.streams import EFFECTS, stream
from scalar.simulation.target_planes import TargetPlane
from scalar.simulation.transforms import Array
from scalar.simulation.world import World

CLASSES: tuple[type[InjectedEffect], ...] = (
    JointCompliance,
    TorqueCompliance,
    PayloadDeflection,
    JointHarmonic,
    JointScale,
    JointCoupling,
    JointBacklash,
    JointHysteresis,
    PoseLag,
    AxisNonparallel,
    BaseCompliance,
    ThermalDrift,
    RestartedWarmUp,
    TargetDrift,
    SensorSlip,
    RangeScale,
    RangeOffset,
    RangeDistortion,
    PlaneBow,
    PlaneMoved,
    PoseJitter,
    ScanBias,
    Unknown,
)
BY_NAME = {kind.name: kind for kind in CLASSES}


def injected_records(entries: Sequence[Mapping[str, Any]]) -> set[str]:
    """Return what poses.csv has to record for these entries of `injected`."""
    return set().union(*(class_of(entry).needs(entry) for entry in entries))


def class_of(entry: Mapping[str, Any]) -> type[InjectedEffect]:
    """Return the class that injects a complete entry."""
    if entry.get("by_moves"):
        return BacklashByMoves
    return CAUSES.get(entry.get("kind", ""), BY_NAME[entry["effect"]])


def inject(
    entries: Sequence[Mapping[str, Any]],
    workcell: Workcell,
    poses: pd.DataFrame,
    plane_index: Array,
    seed: int,
) -> Effects:
    """Return the effects that complete entries of `injected` describe, in a workcell and at its poses.

    Raises:
        InvalidInput: this workcell cannot have an effect; the message has the effect's place in the config.
    """
    return Injected(
        tuple(
            class_of(entry).inject(entry, Stage(workcell, poses, plane_index, k), stream(seed, EFFECTS, k))
            for k, entry in enumerate(entries)
        )
    )


@dataclass(frozen=True)
class Injected(Effects):
    """Several effects at once."""

    parts: tuple[InjectedEffect, ...]

    def joint_errors(self, world: World, q: Array, poses: pd.DataFrame) -> Array:
        """Return the sum of the effects' errors."""
        return sum((part.joint_errors(world, q, poses) for part in self.parts), np.zeros_like(q))

    def arms(self, arm: Arm, poses: pd.DataFrame, evaluating: bool) -> list[tuple[Rows, Arm]]:
        """Return the stretches in which no effect changes the arm, each with its arm."""
        stretches: list[tuple[Rows, Arm]] = [(np.arange(len(poses)), arm)]
        for part in self.parts:
            stretches = [
                (rows[then], changed)
                for rows, before in stretches
                for then, changed in part.arms(before, poses.iloc[rows], evaluating)
            ]
        return [(rows, changed) for rows, changed in stretches if len(rows)]

    def motions(self, world: World, q: Array, poses: pd.DataFrame) -> Array:
        """Return the product of the effects' motions, the first effect's first."""
        motion = np.eye(4)
        for part in self.parts:
            motion = part.motions(world, q, poses) @ motion
        return motion

    def target_planes(
        self, target_planes: tuple[TargetPlane, ...], poses: pd.DataFrame
    ) -> list[tuple[Rows, tuple[TargetPlane, ...]]]:
        """Return the stretches in which no effect changes a target plane, each with its target planes; bows come before motions."""
        stretches: list[tuple[Rows, tuple[TargetPlane, ...]]] = [(np.arange(len(poses)), target_planes)]
        for part in sorted(self.parts, key=lambda part: part.name):  # plane_bow, then plane_moved
            stretches = [
                (rows[then], changed)
                for rows, before in stretches
                for then, changed in part.target_planes(before, poses.iloc[rows])
            ]
        return [(rows, changed) for rows, changed in stretches if len(rows)]

    def range_errors(self, readings: Array, angles: Array, poses: pd.DataFrame) -> Array:
        """Return the sum of the effects' errors."""
        errors = (part.range_errors(readings, angles, poses) for part in self.parts)
        return sum(errors, np.zeros_like(readings))

    def noise(self, noise: Noise) -> Noise:
        """Return the noise with that of all effects added."""
        for part in self.parts:
            noise = part.noise(noise)
        return noise

    def at_rest(self) -> Self:
        """Return all effects at rest."""
        return replace(self, parts=tuple(part.at_rest() for part in self.parts))

    def record(self) -> list[dict[str, Any]]:
        """Return the entries of all effects, in the config's order."""
        return [entry for part in self.parts for entry in part.record()]
