"""The rules that limit the confidence in the likeliest variance component: returns to a pose, poses near one another, successive readings, halves."""

from __future__ import annotations

from scalar.diagnosis.fit.fitted_state import FittedState
from scalar.diagnosis.fit.variance_components import JITTER, VarianceComponent
from scalar.diagnosis.held_out.outer_split import OuterSplit
from scalar.diagnosis.naming.jitter_at_neighbours import excludes_smooth_error
from scalar.diagnosis.naming.jitter_at_returns import NO_RETURNS, most_confidence_at_returns
from scalar.diagnosis.naming.most_confidence import ONE_OF_TWO
from scalar.diagnosis.naming.scatter_in_time import FOLLOWS_TIME, most_confidence_in_time
from scalar.diagnosis.naming.two_halves import confidence_by_halves, why_limited

MAY_BE_SMOOTH = "an error that varies smoothly with the joint angles, as that of a hose or a floor does, would scatter these poses alike"
MAY_BE_A_REST = "unmodelled structure was found as well, of which this scatter may be the rest"


def limit_of_noise(
    state: FittedState, component: VarianceComponent, halves: OuterSplit | None, *, beside_structure: bool
) -> tuple[float, str]:
    """Return the largest confidence that the rules allow a variance component, and the reason as a clause.

    Args:
        state: The state with all effects that were found.
        component: The component.
        halves: The answers of the two halves of the poses, or None.
        beside_structure: Whether unmodelled structure was found as well.
    """
    limits = [
        (most_confidence_at_returns(state, component), NO_RETURNS),
        (most_confidence_in_time(state, component), FOLLOWS_TIME),
    ]
    if component.name == JITTER and limits[0][0] < 1.0:
        if beside_structure:
            limits.append((ONE_OF_TWO, MAY_BE_A_REST))
        elif not excludes_smooth_error(state, component):
            limits.append((ONE_OF_TWO, MAY_BE_SMOOTH))
    if halves is not None:
        share = halves.noise_selected_in(component.name)
        limits.append((confidence_by_halves(share, halves), why_limited(share)))
    return min(limits)
