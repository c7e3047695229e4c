"""Lower the confidence in names where another scale of one measured coordinate explains nearly all that a rigid arm leaves."""

from __future__ import annotations

from collections.abc import Sequence

from scalar.diagnosis.fit.fitted_state import FittedState
from scalar.diagnosis.naming.finding import Finding, names_limited
from scalar.diagnosis.naming.most_confidence import ONE_OF_TWO
from scalar.estimation.setup.sensor.stretched_axis import stretched_axis

STRETCHED = "another scale of one measured coordinate explains the residual as well, and no instrument is known to be free of that"


def limited_by_stretched_axis(
    found: Sequence[Finding], before: FittedState, least_confidence: float
) -> tuple[Finding, ...]:
    """Return the findings, with each name limited if a coordinate seems stretched; arguments as for ``limited_by_rounding``."""
    if not found or stretched_axis(before.dataset, before.model, before.free) is None:
        return tuple(found)
    return names_limited(found, ONE_OF_TWO, least_confidence, STRETCHED)
