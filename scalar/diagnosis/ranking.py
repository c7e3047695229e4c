"""Rank all candidates by their score on a residual, and refine the nonlinear parameters of the best ones."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from math import comb, log
from typing import Any

import numpy as np

from scalar.diagnosis.candidate_columns import CandidateColumns, CandidateSet
from scalar.diagnosis.fitted_state import FittedState
from scalar.diagnosis.score_test import Background, evidence, p_value, remainder
from scalar.effects import Effect

REFINEMENTS = (
    1.0,
    0.5,
    0.25,
)  # sizes of the steps in which nonlinear parameters are varied, as in ``Effect.variations``
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


def rank(
    state: FittedState, background: Background, columns: CandidateColumns, most: int | None = None
) -> list[Scored]:
    """Return every candidate and change with its score, best first; only so many of them if ``most`` is given."""
    candidates = columns.candidates
    conditional = columns.conditional(background)
    tally = _Tally()
    for width, members in candidates.by_width.items():
        gain, dof, observability = conditional[width].score()
        families = candidates.families[width]
        effects = [candidate for candidate, _ in members]
        numbers = np.column_stack(
            [gain, dof, observability, families, np.full(len(members), candidates.total)]
        )
        kept = np.ones(len(members), dtype=bool)
        for k in candidates.of_several_terms[width]:
            candidate = effects[k]
            rest, degrees_of_freedom = remainder(background, gain[k], dof[k])
            projected, terms = conditional[width].of(k), np.arange(width).reshape(candidate.n_terms, -1)
            # Each term is penalised for its columns and for the number of terms tried, as it would be alone.
            price = np.log(background.degrees_of_freedom) + 2 * np.log(candidate.n_terms) / terms.shape[1]
            chosen = projected.forward(terms, least_drop=float(price * rest / degrees_of_freedom))
            if not chosen:
                kept[k] = False
                continue
            own = projected.score(terms[sorted(chosen)].reshape(1, -1))
            choices = comb(candidate.n_terms, len(chosen))
            effects[k] = candidate.with_terms(chosen)
            numbers[k, :2] = own[0][0], own[1][0]
            numbers[k, 3] += log(choices)
            numbers[k, 4] = float(candidates.total * choices)
        tally.add([effect for effect, keep in zip(effects, kept, strict=True) if keep], numbers[kept])
    _tally_changes(tally, state, background, columns)
    return tally.scored(background, most)


def _tally_changes(
    tally: _Tally, state: FittedState, background: Background, columns: CandidateColumns
) -> None:
    order = state.residuals.poses.order
    time = state.residuals.poses.columns.get("time")
    for effect, found in columns.changes(background):
        if not len(found.gain):
            continue
        best = int(np.argmax(found.gain))
        i = int(found.first[best])
        at = effect.beginning(float(order[i]), None if time is None else float(time[i]))
        total = float(columns.candidates.total)
        tally.add([at], [[found.gain[best], found.dof[best], 1.0, log(len(found.gain)), total]])


@dataclass
class _Tally:
    """Candidates with their gains, whose p-values and evidence are computed all at once."""

    effects: list[Effect] = field(default_factory=list)
    numbers: list[Any] = field(default_factory=list)

    def add(self, effects: Sequence[Effect], numbers: Any) -> None:
        """Add T candidates.

        Args:
            effects: The candidates.
            numbers: ``(T, 5)``: gain, degrees of freedom, observability, logarithm of the number of candidates of its kind that were tried, and
                the number of all that were tried. Choices of terms multiply, so these numbers may exceed any integer type.
        """
        self.effects += effects
        self.numbers.append(numbers)

    def scored(self, background: Background, most: int | None = None) -> list[Scored]:
        """Return the candidates with their scores, or so many of them, the one with the largest evidence first."""
        gain, dof, observability, log_family, total = np.concatenate([np.zeros((0, 5)), *self.numbers]).T
        p = np.minimum(1.0, np.maximum(p_value(background, gain, dof), _LEAST_P_VALUE) * total)
        nats = evidence(background, gain, dof, log_family)
        best = np.argsort(-nats, kind="stable")[:most]
        numbers = zip(
            gain[best].tolist(), dof[best].astype(int).tolist(), nats[best].tolist(), p[best].tolist(), observability[best].tolist(),
            strict=True,
        )  # fmt: skip
        return [Scored(self.effects[k], *row) for k, row in zip(best.tolist(), numbers, strict=True)]


def score_of(
    background: Background,
    effect: Effect,
    gain: float,
    dof: int,
    observability: float,
    family: int,
    total: int,
) -> Scored:
    """Return an effect with its score.

    Args:
        background: Of the model without it.
        effect: Any.
        gain: Drop of the squared whitened residual.
        dof: Number of observable directions.
        observability: ``|E'| / |E|``.
        family: How many of its kind were tried.
        total: How many were tried in all.
    """
    tally = _Tally()
    tally.add([effect], [[gain, dof, observability, log(max(family, 1)), float(total)]])
    return tally.scored(background)[0]


def refined(state: FittedState, background: Background, entry: Scored) -> Scored:
    """Return a scored effect with its nonlinear parameters fitted by a search around the coarse candidate."""
    for scale in REFINEMENTS:
        for _ in range(state.settings.selection.refinement_rounds):
            finer = _best_variation(state, background, entry, scale)
            if finer is entry:
                break
            entry = finer
    return entry


def _best_variation(state: FittedState, background: Background, entry: Scored, scale: float) -> Scored:
    """Return the best of an effect's variations, or the entry itself."""
    pool = CandidateSet.of(entry.effect.variations(scale))
    if len(pool.tried) == 1:
        return entry
    best = rank(state, background, CandidateColumns(state, pool), 1)[0]
    # The penalty for the number of candidates is that of the coarse search; only the fit improves.
    was, now = (max(background.sum_of_squares - e.gain, 1e-300) for e in (entry, best))
    gained = float(0.5 * background.degrees_of_freedom * np.log(was / now))
    if gained < state.settings.selection.least_refinement:
        return entry
    return replace(
        entry,
        effect=best.effect.at_a_pose(state.dataset, state.residuals.poses),
        gain=best.gain,
        evidence=entry.evidence + gained,
    )
