"""What may be mistaken for a tracker, a sensor or a plane that was knocked, and for warmth: a change of the arm, or of its load, at one moment."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scalar.effects.effect import Effect
from scalar.effects.flexible.arm_step import UnattributedArmStep, arm_steps
from scalar.effects.flexible.load_step import load_steps
from scalar.effects.flexible.step import clock_of_steps

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset


def rivals_of_change(
    dataset: Dataset, order: float | None = None, but_link: int | None = None
) -> list[Effect]:
    """Return steps of each link, of the whole arm, and of the load on the flange.

    Args:
        dataset: On which they act.
        order: The order of the first pose after the change; None for several moments of the campaign.
        but_link: A link (from 1) whose step is nearly the change itself: the first for the base, the last for the sensor.
    """
    clock, places = clock_of_steps(dataset, order)
    links = [step for step in arm_steps(dataset, order) if step.joints != (but_link,)]
    return [*links, *(step for at in places for step in load_steps(dataset, clock, at))]


def is_of_whole_arm(effect: Effect) -> bool:
    """Return whether it changes the geometry of more than one link: so many coefficients are tried only in the place of a named change."""
    return isinstance(effect, UnattributedArmStep) and len(effect.joints) > 1
