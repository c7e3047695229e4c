"""Joint selection: the set of effects that explains the data best as a whole, tested effect by effect.

Forward selection adds one effect after the other. This may fail in two ways. First, if several strong effects are present, each of them explains a
small share of the residual, while the others look like a large scatter of the poses; with few poses no effect is significant against that scatter.
Second, several wrong effects, added one by one, may together imitate a right one. Here whole sets are compared (``subset_search``). Each effect of
the best set is tested given the others, as in forward selection. The set replaces the result of forward selection if it has clearly more evidence and
predicts held-out poses clearly better.
"""

from __future__ import annotations

from dataclasses import replace

from scalar.diagnosis.fit.fitted_state import FittedState
from scalar.diagnosis.held_out.hold_out import (
    held_out_errors,
    improvement,
    improves_with_limited_blocks,
    no_worse,
)
from scalar.diagnosis.scoring.candidate_columns import CandidateSet
from scalar.diagnosis.scoring.conditional_scores import without_weakest
from scalar.diagnosis.scoring.evidence_of_states import evidence_of
from scalar.diagnosis.selection.backward_elimination import eliminate_backward
from scalar.diagnosis.selection.forward_selection import reconsidered, select_forward
from scalar.diagnosis.selection.subset_search import best_subset
from scalar.diagnosis.settings import Settings

SEARCHES = 2  # the second is linearised at the optimum with the effects of the first, because large effects are not linear about a model without them


def select_jointly(before: FittedState, forward: FittedState, candidates: CandidateSet) -> FittedState:
    """Return the state with the set of effects that explains most, if it explains the data better than the one of forward selection.

    ``forward`` is returned unchanged if the residual consists of rounding errors, or if there are more than ``settings.subset_search.most_poses``
    poses, because every effect is then significant alone. If the search proposes nothing, or nothing clearly better, ``forward`` is returned after
    backward elimination.

    Args:
        before: The state without effects.
        forward: The state that forward selection found.
        candidates: The candidate set.
    """
    if before.is_rounding or before.dataset.n_poses > before.settings.subset_search.most_poses:
        return forward
    state = before
    for _ in range(SEARCHES):
        effects = best_subset(state, candidates)
        if not effects:
            return eliminate_backward(forward, candidates)
        state = before.refitted(effects, state.model)
    significant = _weakest_dropped(state, candidates)
    tested = eliminate_backward(reconsidered(significant, candidates)[0], candidates)
    tested = _without_implausible(tested, candidates)
    completed = select_forward(tested, candidates)
    chosen = clearly_better(forward, completed, candidates)
    return chosen if chosen is tested else eliminate_backward(chosen, candidates)


def settings_for_parts(settings: Settings, n_poses: int) -> Settings:
    """Return the settings with which parts of a dataset are diagnosed in the same way as all its poses.

    A part of a dataset of many poses may have few enough for the comparison of whole sets of effects. It would then be diagnosed in another way, and
    say nothing of the way that found the effects of the whole.

    Args:
        settings: Thresholds for the whole.
        n_poses: Number of poses of the whole.
    """
    search = settings.subset_search
    if n_poses <= search.most_poses:
        return settings
    return replace(settings, subset_search=replace(search, most_poses=0))


def clearly_better(
    state: FittedState, trial: FittedState, candidates: CandidateSet, least_improvement: float | None = None
) -> FittedState:
    """Return the trial if its coefficients are plausible, it has clearly more evidence and it predicts held-out poses clearly better, else the state.

    *Clearly* means by ``swap_margin`` [nats] of evidence and by ``least_improvement`` [standard errors] of the whitened held-out error; the error in
    metres must not clearly grow either (``no_worse``). With more than ``overwhelming_evidence`` [nats], it is enough that both errors fall if no
    single block may decide (``improves_with_limited_blocks``), or that the whitened error does not grow and that in metres does not clearly grow.

    Args:
        state: A fitted state.
        trial: Another one of the same data.
        candidates: The candidate set.
        least_improvement: Least improvement [standard errors] in place of these; None for these.
    """
    settings = state.settings.selection
    more = evidence_of(trial, candidates) - evidence_of(state, candidates)
    if not trial.is_plausible or more <= settings.swap_margin:
        return state
    whitened = held_out_errors(state, state.whitening), held_out_errors(trial, state.whitening)
    if least_improvement is None:
        overwhelming = more > settings.overwhelming_evidence
        if overwhelming and improves_with_limited_blocks(*whitened):
            return trial
        least_improvement = 0.0 if overwhelming else settings.least_improvement
    gain = improvement(*whitened)
    if gain < least_improvement or not no_worse(held_out_errors(state), held_out_errors(trial)):
        return state
    return trial


def _without_implausible(state: FittedState, candidates: CandidateSet) -> FittedState:
    """Return the state without implausible effects: one of them is no reason to refuse all others."""
    return without_weakest(state, candidates, lambda s: s.implausible_effects, lambda score: False)


def _weakest_dropped(state: FittedState, candidates: CandidateSet) -> FittedState:
    """Return the state without its insignificant effects: the one with the least evidence is dropped until all are significant given the others."""
    alpha = state.settings.selection.alpha_named_effect
    return without_weakest(
        state,
        candidates,
        lambda s: range(len(s.effects)),
        lambda score: score.evidence > 0 and score.p_value <= alpha,
    )
