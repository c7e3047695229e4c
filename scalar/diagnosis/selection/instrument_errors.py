"""Compare the named effects of an arm with errors of the instrument that measured it.

An instrument that distorts the space in which it measures shifts the measured positions as smoothly with the pose as a compliance does. Where several
named effects stand for the distortion, each of them may explain more than the distortion would in its place. Whole models are therefore compared: one
with named effects alone, and one with an error of the instrument and the named effects that are found given it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from scalar.diagnosis.fit.fitted_state import FittedState
from scalar.diagnosis.held_out.hold_out import held_out_errors, improvement
from scalar.diagnosis.scoring.candidate_columns import CandidateColumns, CandidateSet
from scalar.diagnosis.scoring.evidence_of_states import evidence_of
from scalar.diagnosis.scoring.merging import merged
from scalar.diagnosis.scoring.ranking import rank
from scalar.diagnosis.selection.forward_selection import select_forward
from scalar.diagnosis.selection.terms_of_loads import with_terms_of_loads
from scalar.effects import Effect
from scalar.effects.flexible.proposals import errors_of_instrument


def with_error_of_instrument(
    before: FittedState, named: FittedState, candidates: CandidateSet
) -> FittedState | None:
    """Return the state with an error of the instrument and named effects that has the most log evidence; None if no such error explains anything.

    The error that explains most without the named effects is tried in their place, and the one that explains most given them is added to them: the
    best of those that an instrument may have, and a larger one if it explains more. No named effects are selected together with a larger one. It
    replaces no names (``leads``), but names that it does without are not sure.

    Args:
        before: The state without effects.
        named: The state with named effects alone.
        candidates: The candidate set of named effects.
    """
    pool = CandidateSet.of(errors_of_instrument(named.dataset))
    if not pool.tried or named.is_rounding:
        return None
    found: list[FittedState] = []
    for state in (before, named) if named.effects else (before,):
        for with_error in _with_best(state, pool):
            plausible = with_error.is_plausible
            found.append(
                with_terms_of_loads(select_forward(with_error, candidates), candidates)
                if plausible
                else with_error
            )
    found = [state for state in found if errors_of_instrument_in(state)]
    return max(found, key=lambda state: evidence_of(state, candidates), default=None)


def _with_best(state: FittedState, pool: CandidateSet) -> list[FittedState]:
    """Return the states with the plausible error of the instrument that explains most, and with a larger one if that explains more."""
    found: list[FittedState] = []
    for entry in rank(state, state.background(), CandidateColumns.of(state, pool)):
        if entry.evidence <= 0:
            break
        trial = state.refitted(merged(state.effects, entry.effect))
        if trial.is_plausible:
            return [*found, trial]
        found = found or [trial]
    return found


def leads(rival: FittedState, named: FittedState, candidates: CandidateSet) -> bool:
    """Return whether a plausible state with an error of the instrument explains clearly more than one without, and held-out poses no worse."""
    if not rival.is_plausible:
        return False
    more = evidence_of(rival, candidates) - evidence_of(named, candidates)
    if more <= named.settings.flexible_terms.replacement_margin:
        return False
    worse = improvement(held_out_errors(rival, named.whitening), held_out_errors(named, named.whitening))
    return worse < named.settings.selection.least_improvement


def errors_of_instrument_in(state: FittedState) -> list[Effect]:
    """Return the errors of the instrument without a name that a state contains."""
    return [effect for effect in state.effects if effect.flexible and effect.of_instrument]


def leads_of_instrument(
    state: FittedState, rival: FittedState | None, candidates: CandidateSet
) -> Sequence[float]:
    """Return for each effect the log evidence [nats] by which a model with an error of the instrument and without the effect leads; -inf without one.

    Args:
        state: The state with all effects.
        rival: The best one with an error of the instrument, or None.
        candidates: The candidate set of named effects.
    """
    if rival is None or errors_of_instrument_in(state):
        return [-np.inf] * len(state.effects)
    lead = evidence_of(rival, candidates) - evidence_of(state, candidates)
    return [
        -np.inf if any(effect.same_place(other) for other in rival.effects) else lead
        for effect in state.effects
    ]
