"""What the report says of predictions beyond the measured ranges of the joints: how far they may err, with what the data leave open."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

from scalar.data.io.atomic import plain
from scalar.planning.left_open import LeftOpen, left_open
from scalar.report.words import length, listed, quoted

if TYPE_CHECKING:
    from scalar.diagnosis.result import Diagnosis

MUCH_FARTHER = 3.0  # times the expected error within the measured ranges: chosen
_COUNTS = 1.2  # times the error of the found model from which what is left open is mentioned
_SHOWN = 3


def beyond_ranges(diagnosis: Diagnosis) -> list[str]:
    """Return a sentence where predictions over the whole of the joint limits err by much more than within the measured ranges; or none."""
    if diagnosis.shipped.without_effects:
        return []
    choice = diagnosis.shipped.choice
    found, measured = choice.error_as_shipped, choice.error_measured
    more = error_left_open(diagnosis)
    counts = more is not None and more.error > _COUNTS * found
    if (more.error if more is not None and counts else found) <= MUCH_FARTHER * measured:
        return []
    begin = (
        "Use after.json within the ranges of the joints that were measured: there, predictions are expected to err by "
        f"{length(measured)}, but by "
    )
    if more is None or not counts:
        return [f"{begin}{length(found)} over the whole of the joint limits."]
    titles = list(dict.fromkeys(quoted(effect.title) for effect in more.effects))
    rest = [f"{len(titles) - _SHOWN} more"] if len(titles) > _SHOWN else []
    return [
        f"{begin}{length(more.error)} over the whole of the joint limits. The model that was found accounts for {length(found)} of this; the rest is "
        f"what these data leave open, at the size that was found or is usual: {listed([*titles[:_SHOWN], *rest])}."
    ]


def error_left_open(diagnosis: Diagnosis) -> LeftOpen | None:
    """Return how far predictions may err within the joint limits by what a diagnosis left open; None where it found or left open nothing."""
    return _left_open(diagnosis) if diagnosis.findings else None


@lru_cache(maxsize=1)
def _left_open(diagnosis: Diagnosis) -> LeftOpen | None:
    mapping = plain(diagnosis.to_mapping())
    return left_open(diagnosis.dataset, diagnosis.calibration_after, mapping)
