"""Lower the confidence in names that a campaign cannot distinguish because a single joint moved.

Where one joint turns and all others stand still, each error is a function of that one angle. A deflection under the weight of the arm is then a
sinusoid of it, whichever joint gives way, and so is the error of an eccentric gear, of order 1: turned alone over 6.2 rad, a joint 4 that erred by 1
mrad in order 1 had been called a compliance of joint 5, which stood still, with a confidence of 0.94. An error of the angle of a joint that stood
still has no evidence of its own either. Errors of the joint that moved in higher orders, steps and changes in time keep their names.
"""

from __future__ import annotations

from collections.abc import Sequence

from scalar.data.motion import still_joints
from scalar.diagnosis.naming.finding import Finding, limited_where
from scalar.diagnosis.naming.most_confidence import ONE_OF_TWO
from scalar.effects import Effect
from scalar.effects.effect import WEIGHT
from scalar.effects.series import Series
from scalar.geometry.se3 import Array

MOVED_ALONE = (
    "one joint alone moved, and over its angle a deflection under the weight and an error of order 1 look the same, "
    "in this joint and in others"
)


def limited_by_one_joint(found: Sequence[Finding], q: Array, least_confidence: float) -> tuple[Finding, ...]:
    """Return the findings; if only one joint moved, with the confidence limited in those that its motion does not distinguish.

    Args:
        found: All findings.
        q: ``(N, n)`` [rad; m of a joint that slides], the measured positions.
        least_confidence: A name with less confidence is doubtful, between 0 and 1.
    """
    still = still_joints(q)
    if q.shape[1] - len(still) != 1:
        return tuple(found)
    return limited_where(
        found, lambda f: _is_ambiguous(f.effect, still), ONE_OF_TWO, least_confidence, MOVED_ALONE
    )


def _is_ambiguous(effect: Effect, still: Sequence[int]) -> bool:
    """Return whether an effect with a name follows the weight of the arm, is of order 1, or concerns a joint that stood still."""
    if effect.flexible:
        return False
    first_order = isinstance(effect, Series) and tuple(effect.orders) == (1,)
    return first_order or effect.load == WEIGHT or effect.erring_joint in still
