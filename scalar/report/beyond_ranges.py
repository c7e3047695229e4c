"""The report's sentence on predictions beyond the measured ranges of the joints: how far they may err, open questions included."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

from scalar.data.io.atomic import plain
from scalar.planning.left_open import LeftOpen, left_open
from scalar.report.words import length, listed, quoted

if TYPE_CHECKING:
    from scalar.diagnosis.result import Diagnosis

MUCH_FARTHER = 3.0  # chosen: ratio of the error over the joint limits to that within the measured ranges beyond which the sentence is given
_COUNTS = 1.2  # chosen: open questions are mentioned if they raise the error of the found model by more than this factor
_SHOWN = 3  # effects in question that are named


def beyond_ranges(diagnosis: Diagnosis) -> list[str]:
    """Return one sentence if predictions over all of the joint limits err by much more than within the measured ranges, else none."""
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
    """Return how far predictions may err because of what a diagnosis left open; None if it found nothing, or left nothing open."""
    return _left_open(diagnosis) if diagnosis.findings else None


@lru_cache(maxsize=1)
def _left_open(diagnosis: Diagnosis) -> LeftOpen | None:
    mapping = plain(diagnosis.to_mapping())
    return left_open(diagnosis.dataset, diagnosis.calibration_after, mapping)
