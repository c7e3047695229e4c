"""Backward elimination: remove effects, or single joints or orders of an effect, without which held-out poses are predicted as well.

An effect that was selected together with others has not yet been tested alone. Here each part is left out in turn, and the model is refitted
without it. A part is kept if held-out poses are predicted clearly worse without it, or if the other effects take implausibly large
coefficients to replace it. The part whose removal costs least is removed first.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from scalar.diagnosis.fitted_state import FittedState
from scalar.diagnosis.hold_out import held_out_errors, improvement
from scalar.effects import Effect


def eliminate_backward(state: FittedState) -> FittedState:
    """Return the state refitted without those parts of its effects that do not clearly improve the prediction of held-out poses."""
    while state.effects:
        trials = [state.refitted(fewer) for fewer in _without_one_part(state.effects)]
        complete = held_out_errors(state, state.whitening)
        gains = [
            improvement(held_out_errors(trial, state.whitening), complete) if trial.is_plausible else np.inf
            for trial in trials
        ]
        weakest = int(np.argmin(gains))
        if gains[weakest] >= state.settings.selection.least_improvement:
            break
        state = trials[weakest]
    return state


def _without_one_part(effects: tuple[Effect, ...]) -> Iterator[tuple[Effect, ...]]:
    """Yield the effects with one part left out, for each part: a joint or an order of an effect that has several, else the whole effect."""
    for i, effect in enumerate(effects):
        before, after = effects[:i], effects[i + 1 :]
        parts = effect.parts()
        if len(parts) == 1:
            yield (*before, *after)
            continue
        for mine in parts:
            rest = effect.with_terms([k for k in range(effect.n_terms) if k not in mine])
            yield (*before, rest.taking_over(effect), *after)
