"""Lower the confidence in a name that the report lists together with another one from which the data do not distinguish it.

The name that is given is the one with more evidence, and mostly it is right; but whoever reads that the data do not distinguish two causes does not
expect one of them to be nearly certain. In simulated trials of single effects, of trackers and of effects of real arms, 21 names with a
confidence of 0.8 or more were listed with another one. Of the eleven with log odds of less than 10 nats two were wrong, and so was
one of an independent simulator (a scale error, 0.89, for a gear of order 1 over a third of a turn); of the ten others one.
"""

from __future__ import annotations

from collections.abc import Sequence

from scalar.diagnosis.naming.finding import Finding, limited_where
from scalar.diagnosis.naming.most_confidence import NEARLY_SURE

NOT_DISTINGUISHED = "the data do not clearly distinguish it from another one"
CLEAR = 10.0  # nats, chosen: the log odds from which on a name keeps its confidence although another is listed with it


def limited_by_listed_rivals(found: Sequence[Finding]) -> tuple[Finding, ...]:
    """Return the findings, with the confidence limited in each name that is listed with another one and leads by little.

    No name becomes doubtful by that: it is given if it or one of those that are listed with it is likely.
    """
    return limited_where(found, _leads_by_little, NEARLY_SURE, 0.0, NOT_DISTINGUISHED)


def _leads_by_little(finding: Finding) -> bool:
    """Return whether a finding is a known effect that is listed with another known one, and has log odds below ``CLEAR``."""
    known = [rival for rival in finding.confounded_with if not rival.flexible]
    return bool(known) and not finding.effect.flexible and finding.grounds.log_odds < CLEAR
