"""Select the named effects of a cleaned dataset: one after the other, as a whole set, and those of common causes."""

from __future__ import annotations

from scalar.diagnosis.fit.fitted_state import FittedState
from scalar.diagnosis.fit.variance_components import JITTER
from scalar.diagnosis.held_out.hold_out import held_out_errors, improvement
from scalar.diagnosis.scoring.candidate_columns import CandidateSet
from scalar.diagnosis.scoring.evidence_of_states import evidence_of
from scalar.diagnosis.selection.common_causes import with_common_causes
from scalar.diagnosis.selection.explained_by_nuisances import explained_by_nuisances
from scalar.diagnosis.selection.forward_selection import select_forward
from scalar.diagnosis.selection.joint_selection import select_jointly
from scalar.diagnosis.selection.terms_of_loads import with_terms_of_loads


def with_selected_effects(before: FittedState, candidates: CandidateSet) -> FittedState:
    """Return the state with the named effects that are selected.

    Args:
        before: The state without effects.
        candidates: The candidate set.
    """
    selected = select_jointly(before, select_forward(before, candidates), candidates)
    if _jitter_may_hide_effects(selected):
        equally = select_forward(before.with_equal_weights(), candidates)
        afresh = select_jointly(before, before.refitted(equally.effects, equally.model), candidates)
        if afresh.effects and _explains_more(afresh, selected, candidates):
            selected = afresh
    complete = with_common_causes(with_terms_of_loads(selected, candidates), candidates)
    return explained_by_nuisances(complete, candidates)


def _jitter_may_hide_effects(state: FittedState) -> bool:
    """Return whether the likeliest variance component of a state is a jitter larger than half of what the worst arms have.

    It may then stand for something that the model lacks. Poses that are weighted by it hide this: with several targets on the flange, a coupling of
    0.25 mm was taken for a jitter of 32 mrad, and nothing was found.
    """
    worst = state.settings.variance_components.worst_repeatability
    return any(c.name == JITTER and c.repeatability > worst / 2 for c in state.variance_components[:1])


def _explains_more(state: FittedState, other: FittedState, candidates: CandidateSet) -> bool:
    """Return whether a state has overwhelmingly more evidence than another, or clearly more and predicts held-out poses better."""
    settings = state.settings
    gain = evidence_of(state, candidates) - evidence_of(other, candidates)
    if gain > settings.selection.overwhelming_evidence:
        return True
    if gain <= settings.flexible_terms.replacement_margin:
        return False
    better = improvement(held_out_errors(other), held_out_errors(state))
    return better >= settings.selection.least_improvement
