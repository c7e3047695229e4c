"""Lower the confidence in changes of one kind that are found many times: one cause that acts all the time is more probable than so many accidents.

A target plane is knocked, or a sensor slips, by accident and at one moment. A base that sways or an encoder that drifts acts all the time. Several
changes at different moments then approximate its effect, as the steps of a staircase approximate a slope. The evidence for each change is large, but
all their names are wrong.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from scalar.diagnosis.finding import Finding

MOST_ACCIDENTS = 2  # changes of one kind in a campaign, each at another place, that may be accidents


def repeated_changes_doubted(found: Sequence[Finding], least_confidence: float) -> tuple[Finding, ...]:
    """Return the findings; if a kind of change is found more often than by accident, the confidence in each is divided by their number.

    Args:
        found: All findings.
        least_confidence: A name with less confidence is doubtful.
    """
    result = []
    for f, times in zip(found, repetitions([(f.effect.name, f.effect.target) for f in found]), strict=True):
        confidence = f.confidence / times
        doubtful = f.doubtful or (times > 1 and confidence < least_confidence)
        result.append(replace(f, confidence=confidence, doubtful=doubtful))
    return tuple(result)


def repetitions(answers: Sequence[tuple[str, Mapping[str, Any]]]) -> list[int]:
    """Return for each answer (name, target) the number of changes of its kind; one if it is no change, or if these may be accidents.

    They may be accidents if there are at most ``MOST_ACCIDENTS`` and each is at another place.
    """
    result = []
    for name, target in answers:
        places = [
            {k: v for k, v in other.items() if k != "at"}
            for kind, other in answers
            if kind == name and "at" in other
        ]
        again = any(place in places[:i] for i, place in enumerate(places))
        many = "at" in target and (again or len(places) > MOST_ACCIDENTS)
        result.append(len(places) if many else 1)
    return result
