"""Lower the confidence in the lesser of two growths in the course of time that were found together.

An arm that warms up, and cools in its pauses, has one course of temperature. A growth with the time since the start and one that starts again after
stops describe the same course, each a part of it where the pauses are short or the links warm up at different rates.
"""

from __future__ import annotations

from collections.abc import Sequence

from scalar.diagnosis.naming.finding import Finding, limited_where
from scalar.diagnosis.naming.most_confidence import ONE_OF_TWO

SAME_WARMTH = "another growth in the course of time explains more, and this may be a part of it"


def limited_by_same_warmth(found: Sequence[Finding], least_confidence: float) -> tuple[Finding, ...]:
    """Return the findings, with the confidence limited in each known growth in the course of time but the one with the largest log odds.

    A growth with a recorded temperature is none of these: the temperature of the surroundings is another course.

    Args:
        found: All findings.
        least_confidence: A name with less confidence is doubtful, between 0 and 1.
    """
    growths = [
        f for f in found if f.has_name and f.effect.growth_of_arm and "temperature" not in f.effect.follows
    ]
    first = max(growths, key=lambda f: f.grounds.log_odds, default=None)
    return limited_where(
        found, lambda f: f in growths and f is not first, ONE_OF_TWO, least_confidence, SAME_WARMTH
    )
