"""Lower the confidence in a tracker or base that moved within a few poses of a boundary of sessions: only these few poses show it.

In each session the base has a place of its own. A step of the base shortly after a session's first pose, or shortly before its last, moves these few
poses against the rest of their session, and nothing else. A few poses with errors of their own look the same. In one campaign, a joint had rested
on the other side of its play at the first pose of a day, whose direction of approach is not known; a tracker that moved after that pose had been
named instead, with a confidence of 0.86.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from scalar.data.dataset import Dataset
from scalar.diagnosis.naming.finding import Finding, limited_where
from scalar.diagnosis.naming.most_confidence import ONE_OF_TWO
from scalar.effects import BaseEffect, Effect

FEW_OF_SESSION = "only a few poses next to a boundary of sessions show the step, and they may as well have errors of their own"


def limited_by_boundaries(
    found: Sequence[Finding], dataset: Dataset, margin: int, least_confidence: float
) -> tuple[Finding, ...]:
    """Return the findings, with the confidence limited in each step of the base that fewer poses of its session show than a step needs.

    Args:
        found: All findings.
        dataset: What was fitted.
        margin: Least number of poses before a change and from it on; not fewer than the change has coefficients in any case.
        least_confidence: A name with less confidence is doubtful.
    """
    return limited_where(
        found,
        lambda f: _at_boundary(f.effect, dataset, max(margin, len(f.effect.coefficients))),
        ONE_OF_TWO,
        least_confidence,
        FEW_OF_SESSION,
    )


def _at_boundary(effect: Effect, dataset: Dataset, least: int) -> bool:
    """Return whether a step of the base has fewer than the least number of poses on one side, in the session in which it lies."""
    session, at = dataset.session, effect.target.get("at")
    if session is None or at is None or effect.flexible or not isinstance(effect, BaseEffect):
        return False
    order = dataset.known_poses.order
    later = np.flatnonzero(order >= at["order"])
    if not len(later):
        return False
    same = session == session[later[np.argmin(order[later])]]
    after = np.count_nonzero(same & (order >= at["order"]))
    return bool(min(after, np.count_nonzero(same) - after) < least)
