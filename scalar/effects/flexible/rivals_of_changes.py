"""What may be mistaken for a tracker, a sensor or a plane that was knocked, and for warmth: a change of the arm, or of its load, at one moment."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scalar.effects.effect import Effect
from scalar.effects.flexible.arm_step import link_steps, whole_arm_steps
from scalar.effects.flexible.load_step import load_steps
from scalar.effects.flexible.step import clock_of_steps

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset


def changes_of_parts(
    dataset: Dataset, order: float | None = None, but_link: int | None = None
) -> list[Effect]:
    """Return steps of each link, and of the load on the flange.

    Args:
        dataset: On which they act.
        order: The order of the first pose after the change; None for several moments of the campaign.
        but_link: A link (from 1) whose step is nearly the change itself: the first for the base, the last for the sensor.
    """
    clock, places = clock_of_steps(dataset, order)
    links = [step for step in link_steps(dataset, clock, places) if step.joints != (but_link,)]
    return [*links, *load_steps(dataset, clock, places)]


def rivals_of_change(
    dataset: Dataset, order: float | None = None, but_link: int | None = None
) -> list[Effect]:
    """Return ``changes_of_parts``, and steps of the whole arm, which have so many coefficients that they are tried in the place of a name alone."""
    return [
        *changes_of_parts(dataset, order, but_link),
        *whole_arm_steps(dataset, *clock_of_steps(dataset, order)),
    ]
