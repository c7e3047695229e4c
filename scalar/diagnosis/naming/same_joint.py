"""Lower the confidence in an error of a joint that may be a part of another error of the same joint.

An error over two angles, of a spring between two joints for example, is partly one over a single angle, and so a scale error, a coupling or an order
of the joint is found first, and the rest as unmodelled structure at the same joint. In the simulated trials of effects of real arms and of trackers,
15 such names had a confidence of 0.5 or more: ten with log odds of 31 nats or more, all right, and five with less than 20, all wrong.

Where a joint is read before it has arrived, the share of the step that is missing depends on the length of the step, and the rest grows with the
angle that is reached. Of three scale errors that were found together with such a lag of the same joint in these trials, two were wrong.
"""

from __future__ import annotations

from collections.abc import Sequence

from scalar.diagnosis.naming.finding import Finding, limited_where
from scalar.diagnosis.naming.most_confidence import NOT_SURE, ONE_OF_TWO
from scalar.diagnosis.naming.rival_sets import CLEAR_ODDS

PART_OF_STRUCTURE = (
    "unmodelled structure was found at the same joint, and this may be the part of it that has a name"
)
REST_OF_LAG = "the same joint is read before it has arrived, and this may be what is left of that"


def limited_by_same_joint(found: Sequence[Finding], least_confidence: float) -> tuple[Finding, ...]:
    """Return the findings, with the confidence limited in those that may be parts of another error of their joint, unless their log odds are clear.

    Args:
        found: All findings.
        least_confidence: A name with less confidence is doubtful, between 0 and 1.
    """
    late = {f.effect.erring_joint for f in found if f.effect.read_before_arrival}

    def beside_structure(finding: Finding) -> bool:
        return _is_unclear(finding) and finding.grounds.structure_there

    def beside_lag(finding: Finding) -> bool:
        return _is_unclear(finding) and finding.effect.own_angle_joint in late - {None}

    found = limited_where(found, beside_lag, NOT_SURE, least_confidence, REST_OF_LAG)
    return limited_where(found, beside_structure, ONE_OF_TWO, least_confidence, PART_OF_STRUCTURE)


def _is_unclear(finding: Finding) -> bool:
    """Return whether a finding is a known effect whose log odds are not clear."""
    return not finding.effect.flexible and finding.grounds.log_odds < CLEAR_ODDS
