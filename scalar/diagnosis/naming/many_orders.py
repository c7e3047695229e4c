"""Lower the confidence in orders of one joint that were chosen one by one from few poses, since they fit a random error of the joint as well.

A joint that errs at random, by play whose direction nothing records for example, has an independent error at each pose. Of 32 orders, those that
fit these errors best explain more than half of their variance where there are fewer than eight poses for each order that is chosen, whatever the
joint angles. In a simulated campaign of 50 poses, where joint 3 had random errors of plus or minus 0.15 mrad, the orders 3, 8, 10, 11, 26, 27 and 32
had been found, with a confidence of 0.70. All orders at once (``harmonic_spectrum``) have a prior that the data determine, and are not concerned.

If a joint errs in many orders and does not turn all the way round, a scale error may be found in place of a low order: so it was in three of six
simulated campaigns of 60 poses in which joint 3 erred in six orders, with a confidence of 0.70 to 0.74.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

from scalar.diagnosis.naming.finding import Finding
from scalar.diagnosis.naming.most_confidence import ONE_OF_TWO
from scalar.diagnosis.selection.harmonic_spectrum import is_shrunk
from scalar.effects import Effect
from scalar.effects.series import Series

TOO_FEW_POSES = "its orders were found one by one from fewer than eight poses each, and a joint that errs at random has as many that fit"
STANDS_FOR_AN_ORDER = "the same joint errs in many orders, and this may stand for one of them"
POSES_PER_ORDER = 8.0  # with fewer, the best orders explain more than half of a random error


def are_few(effect: Effect, n_poses: int) -> bool:
    """Return whether an effect consists of orders that were chosen one by one, with too few poses for each of them."""
    return (
        isinstance(effect, Series)
        and not is_shrunk(effect)
        and n_poses < POSES_PER_ORDER * len(effect.orders)
    )


def limited_by_many_orders(
    found: Sequence[Finding], n_poses: int, many: int, least_confidence: float
) -> tuple[Finding, ...]:
    """Return the findings, with the confidence limited in orders that a random error explains as well, and in scales that stand for an order.

    Args:
        found: All findings.
        n_poses: Number of poses that were fitted.
        many: Number of orders of a joint from which on its scale may stand for one of them.
        least_confidence: A name with less confidence is doubtful.
    """
    one_by_one = [f.effect for f in found if isinstance(f.effect, Series) and not is_shrunk(f.effect)]
    irregular = {effect.joint for effect in one_by_one if len(effect.orders) >= many}
    result = []
    for f in found:
        if are_few(f.effect, n_poses):
            f = f.limited(ONE_OF_TWO, least_confidence, TOO_FEW_POSES)
        elif _stands_for_an_order(f.effect, irregular):
            f = f.limited(ONE_OF_TWO, least_confidence, STANDS_FOR_AN_ORDER)
        result.append(f)
    return tuple(result)


def _stands_for_an_order(effect: Effect, irregular: Collection[int]) -> bool:
    """Return whether an effect with a name is another error over the angle of a joint that errs in many orders."""
    return not effect.flexible and not isinstance(effect, Series) and effect.own_angle_joint in irregular
