"""Every candidate with its score on a residual, best first; what is not linear in the best ones refined by finer looks."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace
from math import comb

import numpy as np

from scalar.diagnosis.candidate_columns import CandidateColumns, CandidateSet
from scalar.diagnosis.candidate_set import CandidateEffect
from scalar.diagnosis.fitted_state import FittedState
from scalar.diagnosis.score_test import Background, evidence, p_value, remainder
from scalar.effects.effect import Effect
from scalar.effects.sensor import SensorSlip
from scalar.effects.surface import PlaneMoved

REFINEMENTS = (1.0, 0.5, 0.25)  # of the steps of a first look
_LEAST_P_VALUE = 1e-300  # below it the distribution's tail is no longer computed


@dataclass(frozen=True)
class Scored:
    """A candidate with its score.

    Attributes:
        effect: With the terms that are worth taking.
        gain: Drop of the squared whitened residual.
        dof: Directions seen.
        evidence: In nats.
        p_value: Corrected for all that were tried.
        observability: ``|E'| / |E|``.
    """

    effect: Effect
    gain: float
    dof: int
    evidence: float
    p_value: float
    observability: float


def rank(state: FittedState, background: Background, columns: CandidateColumns) -> list[Scored]:
    """Return every candidate and change with its score, best first."""
    projected, tried, total = (
        columns.projected(background),
        columns.candidates.tried,
        columns.candidates.total,
    )
    families = Counter(candidate.effect.name for candidate, _ in tried)
    scored = []
    for members in columns.candidates.by_width.values():
        groups = np.array([where for _, where in members])
        gain, dof, observability = projected.score(groups)
        for k, (candidate, where) in enumerate(members):
            effect, own_gain, own_dof = candidate.effect, float(gain[k]), int(dof[k])
            chosen: list[int] = []
            if candidate.terms > 1:
                rest, freedom = remainder(background, own_gain, own_dof)
                terms = where.reshape(candidate.terms, -1)
                # Each term has to pay for its columns and for being one of many, as it would have to alone.
                price = np.log(background.freedom) + 2 * np.log(candidate.terms) / terms.shape[1]
                chosen = projected.forward(terms, worth=price * rest / freedom)
                if not chosen:
                    continue
                own = projected.score(terms[sorted(chosen)].reshape(1, -1))
                effect, own_gain, own_dof = candidate.with_terms(chosen), float(own[0][0]), int(own[1][0])
            choices = comb(candidate.terms, len(chosen)) if candidate.terms > 1 else 1
            family = (families[effect.name] + columns.candidates.elsewhere) * choices
            scored.append(
                score_of(
                    background,
                    effect,
                    own_gain,
                    own_dof,
                    float(observability[k]),
                    family,
                    total * choices,
                )
            )
    scored += _rank_changes(state, background, columns)
    return sorted(scored, key=lambda entry: -entry.evidence)


def _rank_changes(state: FittedState, background: Background, columns: CandidateColumns) -> list[Scored]:
    order = state.residuals.poses.order
    time = state.residuals.poses.columns.get("time")
    scored = []
    for effect, found in columns.changes(background):
        if not len(found.gain):
            continue
        best = int(np.argmax(found.gain))
        i = int(found.first[best])
        moment = {"order": float(order[i]), "time": None if time is None else float(time[i])}
        assert isinstance(effect, (SensorSlip, PlaneMoved))
        at = replace(effect, **moment, coefficients=np.zeros(len(effect.coefficients)))
        gain, dof = float(found.gain[best]), int(found.dof[best])
        scored.append(score_of(background, at, gain, dof, 1.0, len(found.gain), columns.candidates.total))
    return scored


def score_of(
    background: Background,
    effect: Effect,
    gain: float,
    dof: int,
    observability: float,
    family: int,
    total: int,
) -> Scored:
    corrected = min(1.0, max(p_value(background, gain, dof), _LEAST_P_VALUE) * total)
    return Scored(effect, gain, dof, evidence(background, gain, dof, family), corrected, observability)


def refined(state: FittedState, background: Background, entry: Scored) -> Scored:
    """Return a scored effect with what is not linear in it fitted: finer looks about the coarse one."""
    for scale in REFINEMENTS:
        for _ in range(state.settings.selection.refinement_rounds):
            finer = _look(state, background, entry, scale)
            if finer is entry:
                break
            entry = finer
    return entry


def _look(state: FittedState, background: Background, entry: Scored, scale: float) -> Scored:
    """Return the best of an effect's variations, or the entry itself."""
    pool = CandidateSet.of([CandidateEffect(effect) for effect in entry.effect.variations(scale)])
    if len(pool.tried) == 1:
        return entry
    best = rank(state, background, CandidateColumns(state, pool))[0]
    # The price of the search is that of the coarse one; what is gained is fit.
    was, now = (max(background.squared - e.gain, 1e-300) for e in (entry, best))
    gained = float(0.5 * background.freedom * np.log(was / now))
    if gained < state.settings.selection.least_refinement:
        return entry
    return replace(
        entry,
        effect=_at_a_pose(best.effect, state),
        gain=best.gain,
        evidence=entry.evidence + gained,
    )


def _at_a_pose(effect: Effect, state: FittedState) -> Effect:
    """Return a creep that begins at the first pose of its plate after where a finer look found it to begin."""
    if not isinstance(effect, PlaneMoved):
        return effect
    dataset, order = state.dataset, state.residuals.poses.order
    mine = np.flatnonzero(dataset.plane_index == [p.name for p in dataset.planes].index(effect.plane))
    i = mine[min(int(np.searchsorted(order[mine], effect.order)), len(mine) - 1)]
    time = state.residuals.poses.columns.get("time")
    span = effect.order + effect.creep_span - float(order[i])
    if span <= 0:
        return effect
    return replace(
        effect, order=float(order[i]), time=None if time is None else float(time[i]), creep_span=span
    )
