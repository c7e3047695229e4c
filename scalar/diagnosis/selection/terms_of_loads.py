"""Replace a part of another effect by a further term of a compliance where both explain the same: the load is known to act, the other cause is not.

About a horizontal axis the torque of a link's weight is a sinusoid of the joint's own angle, and so is the first order of an eccentric gear. A search
over whole sets of effects may therefore choose this order where the compliance of the joint lacks a term. If the compliance of that joint is in the
model, the weight acts on it in any case, and the order is no second fault.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from scalar.diagnosis.fit.fitted_state import FittedState
from scalar.diagnosis.scoring.candidate_columns import CandidateSet
from scalar.diagnosis.scoring.conditional_scores import columns_of_effects, parts_of, without_columns
from scalar.diagnosis.scoring.evidence_of_states import evidence_of
from scalar.effects import Effect
from scalar.geometry.se3 import Array

SAME = 0.05  # share of a part that the term leaves unexplained: none where the joint's axis is horizontal, 0.02 where it leans by a degree


def with_terms_of_loads(state: FittedState, candidates: CandidateSet) -> FittedState:
    """Return the state in which parts of other effects have become the terms of a load's effect that explain the same; if there are none, the state.

    Args:
        state: The state with the effects that were selected.
        candidates: The candidate set.
    """
    return _at_least(state, candidates, evidence_of(state, candidates) - state.settings.selection.swap_margin)


def _at_least(state: FittedState, candidates: CandidateSet, least: float) -> FittedState:
    """Return what ``with_terms_of_loads`` does; no exchange may lower the log evidence to ``least`` [nats] or below."""
    for loaded in state.effects:
        for complete, columns in _with_a_missing_term(state, loaded, candidates):
            for others in _without_a_part_like(state, loaded, columns):
                trial = state.refitted([complete if effect is loaded else effect for effect in others])
                if trial.is_plausible and evidence_of(trial, candidates) > least:
                    return _at_least(trial, candidates, least)
    return state


def _with_a_missing_term(
    state: FittedState, loaded: Effect, candidates: CandidateSet
) -> Iterator[tuple[Effect, Array]]:
    """Yield the effect of a load with each term that it lacks at the joints where it acts, and the columns ``(N m, w)`` of that term."""
    if not loaded.load:
        return
    for element in candidates.elements:
        complete = loaded.merged_with(element)
        if complete is not None and complete.n_terms > loaded.n_terms and complete.target == loaded.target:
            yield complete, state.columns_of([element], candidates.bases)


def _without_a_part_like(state: FittedState, loaded: Effect, columns: Array) -> Iterator[tuple[Effect, ...]]:
    """Yield the effects of a state without each part of those of no load that columns ``(N m, w)`` explain as well, given all other effects."""
    background = state.background()
    for i, effect in enumerate(state.effects):
        if effect.load or effect.same_place(loaded):
            continue
        parts = effect.parts()
        local = (
            [columns_of_effects(state, [i])[0]] if len(parts) == 1 else [own for own, _ in parts_of(state, i)]
        )
        if len(local) != len(parts):  # some of its coefficients are fixed, because they are unobservable
            continue
        for terms, own in zip(parts, local, strict=True):
            if np.count_nonzero(own) != columns.shape[1]:
                continue
            released = without_columns(background, state, own).released
            if released is None or not released.any():
                continue
            # What the columns have besides the rest of the model.
            given = columns - background.Q @ (background.Q.T @ columns) + released @ (released.T @ columns)
            basis = np.linalg.qr(given)[0]
            if np.linalg.norm(released - basis @ (basis.T @ released)) > SAME * np.linalg.norm(released):
                continue
            kept = [k for k in range(effect.n_terms) if k not in terms]
            rest = (effect.with_terms(kept).with_coefficients_of(effect),) if kept else ()
            yield (*state.effects[:i], *rest, *state.effects[i + 1 :])
