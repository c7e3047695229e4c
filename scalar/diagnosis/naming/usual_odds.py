"""Lower the confidence in a name whose log odds are far below what right names of its kind reach.

Some effects are hardly ever mistaken: nothing else is like a sensor that sits elsewhere from one pose on. Where such a name leads its rivals by
little, the cause is more often something else. Each kind of effect states the log odds below which this was so in simulated exams
(``Effect.usual_odds``).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from scalar.diagnosis.naming.finding import Finding, limited_where
from scalar.diagnosis.naming.most_confidence import NEARLY_SURE

LEADS_BY_LITTLE = "the data favour it over other explanations by less than is usual where this is the cause"


def limited_by_usual_odds(found: Sequence[Finding], least_confidence: float) -> tuple[Finding, ...]:
    """Return the findings, with the confidence limited in each whose log odds are below those that are usual for its kind.

    Args:
        found: All findings.
        least_confidence: A name with less confidence is doubtful, between 0 and 1.
    """
    number_of_kind = Counter(type(finding.effect) for finding in found)

    def applies(finding: Finding) -> bool:
        effect = finding.effect
        borne_out = effect.borne_out_by_others and number_of_kind[type(effect)] > 1
        return not borne_out and finding.grounds.log_odds < effect.usual_odds

    return limited_where(found, applies, NEARLY_SURE, least_confidence, LEADS_BY_LITTLE)
