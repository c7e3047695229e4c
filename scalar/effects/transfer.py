"""Which effects go with an arm from one campaign to the next, and which stay where they were found.

Joints, links and the pedestal are the arm's own. A range error is the laser's. A slip, a plate that moved or is bent, a warm-up by the
clock belong to one day in one cell: held in another they would be errors of our own making.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from scalar.data.poses import is_joint
from scalar.effects.effect import Effect, JointEffect, PointEffect, SensorEffect
from scalar.effects.joints import JointBacklash
from scalar.effects.links import ThermalDrift
from scalar.effects.sensor import SensorSlip
from scalar.effects.surface import PlaneBow, PlaneMoved
from scalar.effects.unattributed import GRAVITY, Unattributed
from scalar.errors import Fault, InvalidInput
from scalar.estimation.model import Model
from scalar.sensors import kind_of

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset

OPTION = "--effects-from"


@dataclass(frozen=True, eq=False)
class Carried:
    """What another calibration gives to a dataset.

    Attributes:
        effects: To be held as they were found.
        left: The others, each with the reason why it was not taken.
    """

    effects: tuple[Effect, ...]
    left: tuple[tuple[Effect, str], ...]

    def to_mapping(self) -> dict[str, object]:
        """Return what a calibration's summary keeps of it."""
        return {
            "held": [effect.key for effect in self.effects],
            "not_taken": {e.key: reason for e, reason in self.left},
        }


def carried(model: Model, dataset: Dataset) -> Carried:
    """Return the effects of another calibration that hold for a dataset of the same arm.

    Args:
        model: Of the other calibration.
        dataset: To be calibrated.

    Raises:
        InvalidInput: The other calibration is of an arm with another number of joints.
    """
    theirs, ours = model.robot.n_joints, dataset.robot.n_joints
    if theirs != ours:
        raise InvalidInput(
            [
                Fault(
                    OPTION,
                    f"it calibrates an arm with {theirs} joints, and '{dataset.robot.name}' has {ours}; "
                    "take the effects of a campaign with the same arm",
                )
            ]
        )
    reasons = [(effect, _why_not(effect, dataset)) for effect in model.effects]
    return Carried(
        tuple(effect for effect, reason in reasons if reason is None),
        tuple((effect, reason) for effect, reason in reasons if reason is not None),
    )


def _why_not(effect: Effect, dataset: Dataset) -> str | None:
    """Return why an effect does not hold for a dataset, or None where it does."""
    if isinstance(effect, SensorSlip):
        return "a slip happens once"
    if isinstance(effect, (PlaneMoved, PlaneBow)):
        return "the plates are set up anew for every campaign"
    if isinstance(effect, ThermalDrift):
        if effect.by != "temperature":
            return f"its course by {effect.by} is that of one campaign"
        return _missing(["temperature"], dataset)
    if isinstance(effect, JointBacklash) and effect.by == "approach":
        return _missing([f"approach{effect.joint}"], dataset)
    if isinstance(effect, PointEffect):
        return None if kind_of(dataset).measures_range else "it is an error of a laser's range"
    if isinstance(effect, Unattributed):
        return _why_not_unattributed(effect)
    return None


def _why_not_unattributed(effect: Unattributed) -> str | None:
    if isinstance(effect, SensorEffect):
        return "the sensor is mounted anew for every campaign"
    foreign = [name for name in effect.depends_on if name != GRAVITY and not is_joint(name)]
    if isinstance(effect, JointEffect) and foreign:
        return f"its course by {', '.join(foreign)} is that of one campaign"
    return None


def _missing(columns: Sequence[str], dataset: Dataset) -> str | None:
    absent = [name for name in columns if name not in dataset.poses]
    return f"poses.csv has no column '{absent[0]}'" if absent else None


def describe(entry: object) -> list[str]:
    """Return lines that say which effects were taken and which were not, from a calibration's summary."""
    if not isinstance(entry, dict):
        return []
    held, left = entry["held"], entry["not_taken"]
    lines = [f"  effects taken and held: {', '.join(held) if held else 'none'}"]
    return lines + [f"  not taken: {key}: {reason}" for key, reason in left.items()]
