"""Lower the confidence in changes in time where the poses follow one path, since errors that depend on the place cannot be distinguished there.

From 250 poses on one path of a UR3 that four cameras measured, a diagnosis had named a movement of the tracker from pose 97 on, with a confidence of
0.99. From that place on the errors of the four cameras changed with different signs, so they were errors of the cameras that depend on the place.
"""

from __future__ import annotations

from collections.abc import Sequence

from scalar.data.dataset import Dataset
from scalar.diagnosis.naming.finding import Finding, limited_where
from scalar.diagnosis.naming.most_confidence import ONE_OF_TWO
from scalar.effects.acquisition import on_one_path

TIME_OR_PLACE = (
    "the poses follow one path and never come back to an earlier part of it, "
    "so an error that depends on the place explains it as well"
)


def limited_by_path(
    found: Sequence[Finding], dataset: Dataset, least_confidence: float
) -> tuple[Finding, ...]:
    """Return the findings, with the confidence limited in changes in time if the poses follow one path.

    Args:
        found: All findings.
        dataset: What was measured.
        least_confidence: A name with less confidence is doubtful.
    """
    if not any(f.effect.is_change_in_time for f in found) or not on_one_path(dataset):
        return tuple(found)
    return limited_where(
        found,
        lambda f: f.effect.is_change_in_time and not f.effect.flexible,
        ONE_OF_TWO,
        least_confidence,
        TIME_OR_PLACE,
    )
