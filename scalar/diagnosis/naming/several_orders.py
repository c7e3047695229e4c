"""Lower the confidence in a harmonic of several orders, some of which another error may have caused.

A gear may err with several periods a turn. So does a belt over a part of a turn, or a worn tooth, which needs many orders; and where the arm gives
way under its weight, an order 1 may stand for what the fitted masses leave. In nine simulated exams, in which no gear erred in more than one order,
fifteen harmonics of several orders had a confidence of 0.8 or more: nine were other errors, and six were true harmonics with additional orders.
"""

from __future__ import annotations

from collections.abc import Sequence

from scalar.diagnosis.naming.finding import Finding, limited_where
from scalar.diagnosis.naming.most_confidence import NEARLY_SURE
from scalar.diagnosis.naming.weight_and_structure import has_unmodelled_structure
from scalar.diagnosis.selection.harmonic_spectrum import is_shrunk
from scalar.effects import Effect
from scalar.effects.effect import WEIGHT
from scalar.effects.series import Series

MANY = 3  # chosen: so many orders, chosen one by one, also describe an error of another form
ANOTHER_FORM = (
    "several orders together also describe an error of another form, as that of a belt or of a worn tooth"
)


def limited_by_several_orders(found: Sequence[Finding], least_confidence: float) -> tuple[Finding, ...]:
    """Return the findings, with the confidence limited in harmonics of several orders that were chosen one by one.

    Two orders are concerned only if there is unmodelled structure as well, or if the first order is one of them and something gives way under the
    weight.

    Args:
        found: All findings.
        least_confidence: A name with less confidence is doubtful, between 0 and 1.
    """
    structure = has_unmodelled_structure(found)
    weight = any(finding.effect.load == WEIGHT for finding in found)

    def applies(finding: Finding) -> bool:
        orders = _chosen_one_by_one(finding.effect)
        return len(orders) >= MANY or (len(orders) > 1 and (structure or (weight and 1 in orders)))

    return limited_where(found, applies, NEARLY_SURE, least_confidence, ANOTHER_FORM)


def _chosen_one_by_one(effect: Effect) -> tuple[int, ...]:
    """Return the orders of an effect that were chosen one by one; none if it has all orders, or is no series."""
    return effect.orders if isinstance(effect, Series) and not is_shrunk(effect) else ()
