"""Backward elimination: remove effects, or single joints or orders of an effect, without which held-out poses are predicted equally well.

An effect that was selected together with others has not yet been tested by itself. A *part* is one joint or one order of an effect that has several,
else the whole effect. Here each part is left out in turn, and the model is refitted without it. A part is kept if held-out poses are predicted
clearly worse without it (by ``settings.selection.least_improvement`` standard errors), or if the other effects need implausibly large coefficients to
replace it. The part whose removal costs least is removed first, until all remaining parts are kept.
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
        trials = [state.refitted(effects) for effects in _without_one_part(state.effects)]
        complete = held_out_errors(state, state.whitening)
        # The improvement by each part [standard errors]; infinite if the model without it is implausible, so that the part is kept.
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
    """Yield for each part of the effects all effects without that part; those that remain keep their coefficients."""
    for i, effect in enumerate(effects):
        before, after = effects[:i], effects[i + 1 :]
        parts = effect.parts()
        if len(parts) == 1:
            yield (*before, *after)
            continue
        for left_out in parts:
            remaining = effect.with_terms([k for k in range(effect.n_terms) if k not in left_out])
            yield (*before, remaining.with_coefficients_of(effect), *after)
