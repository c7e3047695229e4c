"""Drop what the poses held out do not bear out: effects, and of effects with several joints or orders each of these.

An effect that was chosen together with others, or joined others bit by bit, has not been judged alone. Here each part is left out in turn and
everything else is fitted again: the part stays if the poses held out are predicted clearly worse without it, or if the other effects become
implausibly large in its place. The weakest is dropped first.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from scalar.diagnosis.fitted_state import FittedState
from scalar.diagnosis.hold_out import held_out_errors, improvement
from scalar.effects import Effect


def borne_out(state: FittedState) -> FittedState:
    """Return a state without the parts of its effects that the poses held out do not bear out."""
    while state.effects:
        trials = [state.refitted(fewer) for fewer in _with_less(state.effects)]
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


def _with_less(effects: tuple[Effect, ...]) -> Iterator[tuple[Effect, ...]]:
    """Yield the effects without each part: a joint or an order of an effect that has several, else the whole effect."""
    for i, effect in enumerate(effects):
        before, after = effects[:i], effects[i + 1 :]
        parts = effect.parts()
        if len(parts) == 1:
            yield (*before, *after)
            continue
        for mine in parts:
            rest = effect.with_terms([k for k in range(effect.n_terms) if k not in mine])
            yield (*before, rest.taking_over(effect), *after)
