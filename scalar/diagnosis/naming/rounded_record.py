"""Lower the confidence in names where joint angles were rounded and recur: a joint that stands still keeps one rounding error for dozens of poses.

Where each pose has its own angles, rounding is a random error of the poses. If joints move one at a time, or on a grid, it is the same at all poses
with the same angle, and poses that are held out share it with those that are fitted. It then looks like an effect: in two of
nine simulated campaigns without any effect, with angles rounded to 0.01 degrees and one joint moved at a time, an effect was named with a confidence
of 0.95 or more.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from scalar.data.rounding import rounded_angles
from scalar.diagnosis.fit.fitted_state import FittedState
from scalar.diagnosis.naming.finding import Finding, names_limited
from scalar.diagnosis.naming.most_confidence import ONE_OF_TWO
from scalar.geometry.se3 import Array

ROUNDED = "the joint angles were rounded and recur, and their rounding explains the residual as well"
RECUR = 0.5  # chosen: number of different angles of a joint over that of poses; with less, half of the poses repeat an angle


def limited_by_rounding(
    found: Sequence[Finding], before: FittedState, least_confidence: float
) -> tuple[Finding, ...]:
    """Return the findings with the confidence in each name limited if recurring, rounded angles explain the residual; flexible terms are unchanged.

    Args:
        found: All findings.
        before: The state without effects.
        least_confidence: A name with less confidence is doubtful.
    """
    if not found or not _explained_by_rounding(before):
        return tuple(found)
    return names_limited(found, ONE_OF_TWO, least_confidence, ROUNDED)


def _explained_by_rounding(before: FittedState) -> bool:
    """Return whether the joint angles recur and rounding them explains what the model without effects leaves."""
    q = before.dataset.q
    return recur(q) and bool(rounded_angles(before.dataset.robot, q, before.residuals.rms(before.model)))


def recur(q: Array) -> bool:
    """Return whether most joints that move take few different positions ``(N, n)`` [rad, m] for the number of poses."""
    different = np.array([len(np.unique(column)) for column in q.T])
    moved = different > 1
    return bool(moved.any()) and float(np.median(different[moved])) < RECUR * len(q)
