"""The largest confidence that rules allow the likeliest variance component, and why: returns to the same poses, and the two halves of the poses."""

from __future__ import annotations

from scalar.diagnosis.fit.fitted_state import FittedState
from scalar.diagnosis.fit.variance_components import VarianceComponent
from scalar.diagnosis.held_out.outer_split import OuterSplit
from scalar.diagnosis.naming.jitter_at_returns import NO_RETURNS, most_confidence_at_returns
from scalar.diagnosis.naming.two_halves import most_confidence, why_limited


def limit_of_noise(
    state: FittedState, component: VarianceComponent, halves: OuterSplit | None
) -> tuple[float, str]:
    """Return the largest confidence that the rules allow a variance component, and the reason as a clause.

    Args:
        state: The state with all effects that were found.
        component: The component.
        halves: The answers of the two halves of the poses, or None.
    """
    limits = [(most_confidence_at_returns(state, component), NO_RETURNS)]
    if halves is not None:
        share = halves.noise_selected_in(component.name)
        limits.append((most_confidence(share, halves), why_limited(share)))
    return min(limits)
