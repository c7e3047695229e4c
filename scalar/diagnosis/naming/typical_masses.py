"""Lower the confidence in a deflection under the weight of the arm that does not follow the weight of an arm with typical masses.

The first moments of mass are fitted, so errors that follow sums of joint angles for other reasons resemble a deflection. They need masses where
an arm has none. In simulated sets, 177 joints or bases were found to give way that did: two of them have a cosine of less than 0.7 with the weight of
an arm with 1 kg at the end of each link, none of which had a confidence of 0.8. Of 23 that were found in place of springs, hoses, floors that settle
and belts, 19 have.
"""

from __future__ import annotations

from collections.abc import Sequence

from scalar.diagnosis.fit.fitted_state import FittedState
from scalar.diagnosis.naming.finding import Finding, limited_where
from scalar.diagnosis.naming.most_confidence import ONE_OF_TWO

LEAST_COSINE = 0.7  # chosen, between those of the sets above
UNTYPICAL_MASSES = (
    "it does not follow the weight of the arm as it would if each link had its mass between its joints"
)


def limited_by_typical_masses(
    found: Sequence[Finding], state: FittedState, least_confidence: float
) -> tuple[Finding, ...]:
    """Return the findings, with the confidence limited in what gives way under a weight that an arm hardly has.

    Args:
        found: All findings.
        state: The state with their effects.
        least_confidence: A name with less confidence is doubtful, between 0 and 1.
    """
    robot, poses = state.dataset.robot, state.dataset.known_poses

    def applies(finding: Finding) -> bool:
        along = finding.effect.along_typical_weight(robot, poses)
        return along is not None and along < LEAST_COSINE

    return limited_where(found, applies, ONE_OF_TWO, least_confidence, UNTYPICAL_MASSES)
