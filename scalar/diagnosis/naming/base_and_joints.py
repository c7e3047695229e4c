"""Lower the confidence in the compliance of the base if joints are compliant too and the poses are too few to distinguish the two.

The base and the joints of an arm give way under the same weight, and the masses of the links are fitted with each of them. Where joints are
compliant, a compliance of the base can therefore fit what the masses fitted with the joints leave. In seven simulated exams such a base was named
with a confidence of 0.8 or more and log odds of less than 20 nats in seven sets of 60 poses, and was compliant in one of them; of thirteen such sets
of 120 or 300 poses, it was compliant in ten.
"""

from __future__ import annotations

from collections.abc import Sequence

from scalar.diagnosis.naming.finding import Finding, limited_where
from scalar.diagnosis.naming.most_confidence import ONE_OF_TWO
from scalar.diagnosis.naming.rival_sets import CLEAR_ODDS
from scalar.effects import BaseEffect

FEW_POSES = 100  # chosen, between the 60 and the 120 poses of the sets above
SAME_WEIGHT = "joints that give way were found too, under the same weight, and so few poses hardly distinguish a base that does from them"


def limited_by_joint_compliance(
    found: Sequence[Finding], n_poses: int, least_confidence: float
) -> tuple[Finding, ...]:
    """Return the findings, with the confidence limited in a compliance of the base if a joint is compliant too, unless its log odds are clear.

    Args:
        found: All findings.
        n_poses: Number of poses that were fitted.
        least_confidence: A name with less confidence is doubtful, between 0 and 1.
    """
    joint_is_compliant = any(
        f.has_name and f.is_known_deflection and not isinstance(f.effect, BaseEffect) for f in found
    )
    if not joint_is_compliant or n_poses >= FEW_POSES:
        return tuple(found)
    return limited_where(found, _is_unclear_base, ONE_OF_TWO, least_confidence, SAME_WEIGHT)


def _is_unclear_base(finding: Finding) -> bool:
    """Return whether a finding is a base that gives way under the weight of the arm, without clear log odds."""
    of_base = isinstance(finding.effect, BaseEffect) and finding.is_known_deflection
    return of_base and finding.grounds.log_odds < CLEAR_ODDS
