"""Rank all candidates by their score on a residual, and refine the nonlinear parameters of the best ones."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace
from math import comb

import numpy as np

from scalar.diagnosis.candidate_columns import CandidateColumns, CandidateSet
from scalar.diagnosis.fitted_state import FittedState
from scalar.diagnosis.score_test import Background, evidence, p_value, remainder
from scalar.effects import Effect

REFINEMENTS = (1.0, 0.5, 0.25)  # of the steps of a first look
_LEAST_P_VALUE = 1e-300  # below it the distribution's tail is no longer computed


@dataclass(frozen=True)
class Scored:
    """A candidate with its score.

    Attributes:
        effect: With the terms that raise its evidence.
        gain: Drop of the squared whitened residual.
        dof: Number of observable directions.
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
    families = Counter(candidate.name for candidate, _ in tried)
    scored = []
    for members in columns.candidates.by_width.values():
        groups = np.array([where for _, where in members])
        gain, dof, observability = projected.score(groups)
        for k, (candidate, where) in enumerate(members):
            effect, own_gain, own_dof = candidate, float(gain[k]), int(dof[k])
            chosen: list[int] = []
            if candidate.n_terms > 1:
                rest, freedom = remainder(background, own_gain, own_dof)
                terms = where.reshape(candidate.n_terms, -1)
                # Each term is penalised for its columns and for the number of terms tried, as it would be alone.
                price = np.log(background.freedom) + 2 * np.log(candidate.n_terms) / terms.shape[1]
                chosen = projected.forward(terms, worth=price * rest / freedom)
                if not chosen:
                    continue
                own = projected.score(terms[sorted(chosen)].reshape(1, -1))
                effect, own_gain, own_dof = candidate.with_terms(chosen), float(own[0][0]), int(own[1][0])
            choices = comb(candidate.n_terms, len(chosen)) if candidate.n_terms > 1 else 1
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
        at = effect.beginning(float(order[i]), None if time is None else float(time[i]))
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
    """Return a scored effect with its nonlinear parameters fitted by a search around the coarse candidate."""
    for scale in REFINEMENTS:
        for _ in range(state.settings.selection.refinement_rounds):
            finer = _look(state, background, entry, scale)
            if finer is entry:
                break
            entry = finer
    return entry


def _look(state: FittedState, background: Background, entry: Scored, scale: float) -> Scored:
    """Return the best of an effect's variations, or the entry itself."""
    pool = CandidateSet.of(entry.effect.variations(scale))
    if len(pool.tried) == 1:
        return entry
    best = rank(state, background, CandidateColumns(state, pool))[0]
    # The penalty for the number of candidates is that of the coarse search; only the fit improves.
    was, now = (max(background.squared - e.gain, 1e-300) for e in (entry, best))
    gained = float(0.5 * background.freedom * np.log(was / now))
    if gained < state.settings.selection.least_refinement:
        return entry
    return replace(
        entry,
        effect=best.effect.at_a_pose(state.dataset, state.residuals.poses),
        gain=best.gain,
        evidence=entry.evidence + gained,
    )
