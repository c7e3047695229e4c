"""Backward elimination: remove effects, or single joints or orders of an effect, without which held-out poses are predicted equally well.

An effect that was selected together with others has not yet been tested by itself. A *part* is one joint or one order of an effect that has several,
else the whole effect. Here each part is left out in turn, and the model is refitted without it. A part is kept if held-out poses are predicted
clearly worse without it (by ``settings.selection.least_improvement`` standard errors), if the model without it has far less log evidence (by
``settings.selection.overwhelming_evidence``), or if the other effects need implausibly large coefficients to replace it. The part whose removal costs
least is removed first, until all remaining parts are kept.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from scalar.diagnosis.fit.fitted_state import FittedState
from scalar.diagnosis.held_out.hold_out import held_out_errors, held_out_errors_without, improvement
from scalar.diagnosis.scoring.candidate_columns import CandidateSet
from scalar.diagnosis.scoring.evidence_of_states import evidence_of
from scalar.effects import Effect
from scalar.geometry.se3 import Array

# Largest difference that is expected between the predicted improvement and that of a refit [standard errors]; usually it is below 0.02.
MARGIN = 0.5


def eliminate_backward(state: FittedState, candidates: CandidateSet) -> FittedState:
    """Return the state refitted without those parts of its effects that do not clearly improve the prediction of held-out poses.

    Args:
        state: A fitted state.
        candidates: The candidate set from which its effects were chosen.
    """
    while state.effects:
        smaller = _without_weakest_part(state, candidates)
        if smaller is None:
            break
        state = smaller
    return state


def _without_weakest_part(state: FittedState, candidates: CandidateSet) -> FittedState | None:
    """Return the state refitted without the part that improves held-out errors least; None if every part clearly improves them."""
    complete = held_out_errors(state, state.whitening)
    least = state.settings.selection.least_improvement
    remaining, left_out = zip(*_without_one_part(state.effects), strict=True)
    linear = held_out_errors_without(state, left_out, state.whitening)
    predicted = np.array([improvement(without, complete) for without in linear])
    weakest = None
    for k in np.argsort(predicted, kind="stable"):
        if predicted[k] >= least + MARGIN:
            break
        trial = state.refitted(remaining[k])
        lost = evidence_of(state, candidates) - evidence_of(trial, candidates)
        if not trial.is_plausible or lost > state.settings.selection.overwhelming_evidence:
            continue
        gain = improvement(held_out_errors(trial, state.whitening), complete)
        if gain < least:
            weakest, least = trial, gain
    return weakest


def _without_one_part(effects: tuple[Effect, ...]) -> Iterator[tuple[tuple[Effect, ...], Array]]:
    """Yield for each part of the effects all effects without that part, and the indices of its coefficients among those of all effects.

    The effects that remain keep their coefficients.
    """
    first = 0
    for i, effect in enumerate(effects):
        before, after = effects[:i], effects[i + 1 :]
        parts = effect.parts()
        for left_out in parts:
            if len(parts) == 1:
                kept: tuple[Effect, ...] = ()
            else:
                chosen = effect.with_terms([k for k in range(effect.n_terms) if k not in left_out])
                kept = (chosen.with_coefficients_of(effect),)
            names = {name for one in kept for name in one.term_names}
            dropped = [k for k, name in enumerate(effect.term_names) if name not in names]
            yield (*before, *kept, *after), first + np.array(dropped, dtype=int)
        first += len(effect.coefficients)
