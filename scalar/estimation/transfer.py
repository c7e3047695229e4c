"""Which effects of one calibration apply to later datasets of the same arm, and which belong to the campaign in which they were found.

Effects of joints, links and the pedestal belong to the arm, and a range error belongs to the laser. A sensor that slipped or a plane that moved
belongs to one campaign: applied in another, it would add an error. The class of each effect says to what it belongs.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from scalar.effects.effect import Effect
from scalar.errors import Fault, InvalidInput
from scalar.estimation.model import Model
from scalar.geometry.same_arm import difference_of_arms

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset

OPTION = "--effects-from"


@dataclass(frozen=True, eq=False)
class Carried:
    """The effects of another calibration that are applied to a dataset, and those that are not.

    Attributes:
        effects: Effects to apply with the coefficients that the other calibration found.
        left: The other effects, each with the reason why it does not apply.
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
    """Return the effects of another calibration that apply to a dataset of the same arm.

    Args:
        model: The model of the other calibration.
        dataset: The dataset to be calibrated.

    Raises:
        InvalidInput: The other calibration is of another arm.
    """
    if (difference := difference_of_arms(model.nominal, dataset.robot)) is not None:
        raise InvalidInput(Fault(OPTION, f"{difference}; take the effects of a campaign with the same arm"))
    reasons = [(effect, effect.not_transferable(dataset)) for effect in model.effects]
    return Carried(
        tuple(effect for effect, reason in reasons if reason is None),
        tuple((effect, reason) for effect, reason in reasons if reason is not None),
    )


def note_on_names(there: str, here: str) -> list[str]:
    """Return a line that asks about the arm if the other calibration and the dataset name different arms, whose tables of joints agree; else none.

    Args:
        there: Name of the arm in the other calibration.
        here: Name of the arm in the dataset.
    """
    plain = ["".join(filter(str.isalnum, name)).casefold() for name in (there, here)]
    if plain[0] == plain[1]:
        return []
    return [
        f"  check the arm: the effects were found for an arm called '{there}', and this one is called '{here}'. Their tables of joints agree, but "
        "two arms of one model have gears, loads and play of their own: take effects from a campaign with this very arm"
    ]


def describe(entry: object) -> list[str]:
    """Return lines that say which effects were taken and which were not, from a calibration's summary."""
    if not isinstance(entry, dict):
        return []
    fixed, left = entry["held"], entry["not_taken"]
    lines = [f"  effects taken and fixed: {', '.join(fixed) if fixed else 'none'}"]
    return lines + [f"  not taken: {key}: {reason}" for key, reason in left.items()]
