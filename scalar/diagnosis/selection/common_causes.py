"""Add effects that one cause brings about together: the lags of all joints of an arm that is measured before it stands still, or the bows of all
target planes, which are plates of one make.

Forward selection adds one effect after the other. It cannot begin with one of these if the poses scatter along the effects' common direction, as
they do if each is measured at another moment: the lag of one joint alone then contradicts the others more than it explains. And a single bow may be
absorbed by the geometry, where three are not. All are therefore tried at once.
"""

from __future__ import annotations

import numpy as np

from scalar.diagnosis.fit.fitted_state import FittedState
from scalar.diagnosis.scoring.candidate_columns import CandidateSet
from scalar.diagnosis.scoring.candidate_set import of_common_causes
from scalar.diagnosis.scoring.merging import merged
from scalar.diagnosis.scoring.ranking import score_of
from scalar.diagnosis.scoring.score_test import Projected
from scalar.diagnosis.selection.backward_elimination import eliminate_backward
from scalar.diagnosis.selection.forward_selection import reconsidered, select_forward
from scalar.diagnosis.selection.joint_selection import clearly_better
from scalar.effects import Effect

# Least improvement of the held-out error where one effect of the group has been found, and the cause with it: the others must not make the
# prediction clearly worse.
LEAST_OF_A_KNOWN_CAUSE = -1.0  # [standard errors]


def with_common_causes(state: FittedState, candidates: CandidateSet) -> FittedState:
    """Return the state with those effects of common causes with which the data are explained clearly better.

    First, those are kept that are significant given the others; if nothing is gained with these, all of a group are tried.

    Args:
        state: The state with the effects that were selected one by one.
        candidates: The candidate set.
    """
    if state.is_rounding or not state.settings.selection.max_effects:  # no effects are to be selected
        return state
    for group in of_common_causes(state.dataset):
        new = [e for e in group if not any(e.same_place(other) for other in state.effects)]
        cause_is_known = len(new) < len(group)
        if not new or not (cause_is_known or _is_significant(state, new, candidates)):
            continue
        least = LEAST_OF_A_KNOWN_CAUSE if cause_is_known else None
        effects = state.effects
        for effect in new:
            effects = merged(effects, effect)
        together = state.refitted(effects)
        for trial in (reconsidered(together, candidates)[0], together):
            if clearly_better(state, trial, candidates, least) is not trial:
                continue
            complete = select_forward(trial, candidates)
            # Effects of one cause may each be dispensable while the others are there, and none of them once the others are gone.
            state = clearly_better(eliminate_backward(complete, candidates), complete, candidates, least)
            break
    return state


def _is_significant(state: FittedState, effects: list[Effect], candidates: CandidateSet) -> bool:
    """Return whether several effects that the state lacks are significant together."""
    background = state.background()
    columns = state.columns_of(effects)
    prior_std = np.concatenate([effect.prior_std for effect in effects])
    projected = Projected.of(background, columns, columns.T @ columns, prior_std)
    gain, dof, observability = (x[0] for x in projected.score(np.arange(columns.shape[1])[None]))
    score = score_of(
        background,
        effects[0],
        float(gain),
        int(dof),
        float(observability),
        candidates.total,
        candidates.total,
    )
    return score.evidence > 0 and score.p_value <= state.settings.selection.alpha_named_effect
