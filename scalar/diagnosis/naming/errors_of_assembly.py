"""Lower the confidence in a name where an error of assembly that every arm has explains about as much.

No axis is quite parallel to another, and between axes that are nominally parallel one direction of the tilt is none of the parameters of the rigid
model: it counts as an effect, and competes with others as if it were as rare as they are. Over few poses it may look like an error of a joint. Of 26
tracked poses of a real arm whose joints 2 and 3 are parallel, a tilt of 0.1 degrees and a coupling of joint 1 from joint 2, for which that arm has no
mechanism, leave 0.21 mm both; from 20 of them the coupling had been named with a confidence of 0.97, and the report said at the same time
that the data do not distinguish it from the tilt.
"""

from __future__ import annotations

from collections.abc import Sequence

from scalar.diagnosis.naming.finding import Finding, limited_where
from scalar.diagnosis.naming.most_confidence import NOT_SURE

TILT_EXPLAINS_AS_MUCH = "a tilt of an axis explains about as much, and no arm is assembled without such tilts"


def limited_by_assembly(found: Sequence[Finding], least_confidence: float) -> tuple[Finding, ...]:
    """Return the findings, with the confidence limited in each that is confounded with a parameter of the geometry that the rigid model leaves out.

    Args:
        found: All findings.
        least_confidence: A name with less confidence is doubtful, between 0 and 1.
    """
    return limited_where(found, _may_be_a_tilt, NOT_SURE, least_confidence, TILT_EXPLAINS_AS_MUCH)


def _may_be_a_tilt(finding: Finding) -> bool:
    """Return whether a finding with a name is confounded with a parameter of the geometry, and is none itself."""
    effect = finding.effect
    return not effect.flexible and not effect.frees and any(rival.frees for rival in finding.confounded_with)
