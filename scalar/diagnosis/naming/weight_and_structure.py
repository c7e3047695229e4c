"""Lower the confidence in an effect of the arm's weight where unmodelled structure was found as well.

What gives way under the weight of the arm varies slowly with the posture, and so does the slow part of many errors for which there is no name: of a
floor that gives way, a loose mount, or a vibration that has not died away. The rest of such an error is then found as unmodelled structure. In nine
simulated exams, 109 of these names had a confidence of 0.8 or more together with such structure, and fewer than 100 poses or log odds of less than
20 nats; 20 of them were wrong.
"""

from __future__ import annotations

from collections.abc import Sequence

from scalar.diagnosis.naming.base_and_joints import FEW_POSES
from scalar.diagnosis.naming.finding import Finding, limited_where
from scalar.diagnosis.naming.most_confidence import NEARLY_SURE
from scalar.diagnosis.naming.rival_sets import CLEAR_ODDS

A_PART_OF_IT = (
    "unmodelled structure was found as well, and this may be the part of it that follows the arm's weight"
)


def limited_by_structure(
    found: Sequence[Finding], n_poses: int, least_confidence: float
) -> tuple[Finding, ...]:
    """Return the findings, with the confidence limited in what gives way under the weight if a finding has no name, unless its log odds are clear.

    Args:
        found: All findings.
        n_poses: Number of poses that were fitted.
        least_confidence: A name with less confidence is doubtful, between 0 and 1.
    """
    if not has_unmodelled_structure(found):
        return tuple(found)
    few = n_poses < FEW_POSES

    def applies(finding: Finding) -> bool:
        return finding.is_known_deflection and (few or finding.grounds.log_odds < CLEAR_ODDS)

    return limited_where(found, applies, NEARLY_SURE, least_confidence, A_PART_OF_IT)


def has_unmodelled_structure(found: Sequence[Finding]) -> bool:
    """Return whether some finding has no name and is no error of the measuring instrument."""
    return any(not finding.has_name and not finding.effect.of_instrument for finding in found)
