"""Rank all candidates by their score on a residual, and refine the nonlinear parameters of the best ones."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from math import comb, log
from typing import Any

import numpy as np

from scalar.diagnosis.fit.background import Background
from scalar.diagnosis.fit.fitted_state import FittedState
from scalar.diagnosis.scoring.candidate_columns import CandidateColumns, CandidateSet
from scalar.diagnosis.scoring.score_test import evidence, p_value, remainder
from scalar.effects import Effect

# Step sizes with which nonlinear parameters are varied one after the other (``Effect.variations``).
REFINEMENTS = (1.0, 0.5, 0.25)
_LEAST_P_VALUE = 1e-300  # smaller p-values are not computed and count as this one


@dataclass(frozen=True)
class Scored:
    """A candidate with its score.

    Attributes:
        effect: The candidate; one of several terms has only those terms that raise its evidence.
        gain: Drop of the squared whitened residual.
        dof: Number of observable directions.
        evidence: Log evidence [nats] (``score_test.evidence``).
        p_value: p-value of the gain, corrected for the number of all candidates.
        observability: ``|E'| / |E|``, the largest of its columns; 1 for a change.
        other_parts: The other parts of an effect if it stands in place of the strongest part alone; None if it stands in place of the whole.
    """

    effect: Effect
    gain: float
    dof: int
    evidence: float
    p_value: float
    observability: float
    other_parts: Effect | None = None


def rank(
    state: FittedState,
    background: Background,
    columns: CandidateColumns,
    most: int | None = None,
    least: float = -np.inf,
) -> list[Scored]:
    """Return every candidate and change with its score, the one with the most evidence first; at most ``most`` of them.

    A change is listed once, with the pose at which its gain is largest as its beginning.

    Args:
        state: The fitted state.
        background: The background of the state, or of the state without some of its effects.
        columns: The candidates' columns at the state.
        most: Number of candidates that are returned; None for all.
        least: Least log evidence of those that are returned [nats].
    """
    candidates = columns.candidates
    conditional = columns.conditional(background)
    table = _ScoreTable()
    for width, members in candidates.by_width.items():
        gain, dof, observability = conditional[width].score()
        effects, numbers = [candidate for candidate, _ in members], np.empty((len(members), 5))
        for column, of_each in enumerate(
            (gain, dof, observability, candidates.families[width], candidates.total)
        ):
            numbers[:, column] = of_each
        kept = np.ones(len(members), dtype=bool)
        rest, degrees_of_freedom = remainder(background, gain, dof)
        log_n = np.log(background.degrees_of_freedom)
        for k in candidates.of_several_terms[width]:
            candidate, projected = effects[k], conditional[width].of(k)
            n_terms, of_term = candidate.n_terms, width // candidate.n_terms
            # Each term is penalised for its columns and for the number of terms tried, as it would be alone.
            penalty = log_n + 2 * np.log(n_terms) / of_term
            chosen = projected.forward(of_term, float(penalty * rest[k] / degrees_of_freedom[k]))
            if not chosen:
                kept[k] = False
                continue
            numbers[k, :2] = projected.gain_of(chosen, of_term)
            choices = comb(n_terms, len(chosen))
            effects[k] = candidate.with_terms(chosen)
            numbers[k, 3] += log(choices)
            numbers[k, 4] = float(candidates.total * choices)
        table.add([effect for effect, keep in zip(effects, kept, strict=True) if keep], numbers[kept])
    _add_changes(table, state, background, columns)
    return table.scored(background, most, least)


def _add_changes(
    table: _ScoreTable, state: FittedState, background: Background, columns: CandidateColumns
) -> None:
    """Add every kind of change to a table, with the beginning at which its gain is largest."""
    order = state.residuals.poses.order
    time = state.residuals.poses.columns.get("time")
    for effect, found in columns.changes(background):
        if not len(found.gain):
            continue
        best = int(np.argmax(found.gain))
        i = int(found.first[best])
        at = effect.beginning(float(order[i]), None if time is None else float(time[i]))
        total = float(columns.candidates.total)
        table.add([at], [[found.gain[best], found.dof[best], 1.0, log(len(found.gain)), total]])


@dataclass
class _ScoreTable:
    """Candidates with their gains; the evidence of all, and the p-values of the best, are computed at once.

    Attributes:
        effects: The candidates.
        numbers: Arrays as ``add`` takes them, which together have a row for each candidate.
    """

    effects: list[Effect] = field(default_factory=list)
    numbers: list[Any] = field(default_factory=list)

    def add(self, effects: Sequence[Effect], numbers: Any) -> None:
        """Add T candidates.

        Args:
            effects: The candidates.
            numbers: ``(T, 5)``: gain, degrees of freedom, observability, logarithm of the number of candidates of its kind, and number of all
                candidates. Each choice of terms counts as a candidate, so the last number may exceed any integer type; it is a float.
        """
        self.effects += effects
        self.numbers.append(numbers)

    def scored(self, background: Background, most: int | None = None, least: float = -np.inf) -> list[Scored]:
        """Return the candidates with their scores, the one with the most evidence first: at most ``most``, with ``least`` log evidence or more."""
        gain, dof, observability, log_family, total = np.concatenate([np.zeros((0, 5)), *self.numbers]).T
        nats = evidence(background, gain, dof, log_family)
        best = np.argsort(-nats, kind="stable")[:most]
        best = best[nats[best] >= least]
        gain, dof, nats, observability, total = (x[best] for x in (gain, dof, nats, observability, total))
        p = np.minimum(1.0, np.maximum(p_value(background, gain, dof), _LEAST_P_VALUE) * total)
        numbers = zip(
            gain.tolist(), dof.astype(int).tolist(), nats.tolist(), p.tolist(), observability.tolist(),
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
        background: The background of the model without the effect.
        effect: The effect.
        gain: Drop of the squared whitened residual.
        dof: Number of observable directions.
        observability: ``|E'| / |E|``.
        family: Number of candidates of its kind.
        total: Number of all candidates.
    """
    table = _ScoreTable()
    table.add([effect], [[gain, dof, observability, log(max(family, 1)), float(total)]])
    return table.scored(background)[0]


def refined(state: FittedState, background: Background, entry: Scored) -> Scored:
    """Return a scored effect with its nonlinear parameters fitted by a search around the values of the candidate, in ever smaller steps."""
    for scale in REFINEMENTS:
        for _ in range(state.settings.selection.refinement_rounds):
            finer = _best_variation(state, background, entry, scale)
            if finer is entry:
                break
            entry = finer
    return entry


def _best_variation(state: FittedState, background: Background, entry: Scored, scale: float) -> Scored:
    """Return the best of an effect's variations with steps of the size ``scale``; the entry itself if none gains ``least_refinement`` [nats]."""
    pool = CandidateSet.of(entry.effect.variations(scale))
    if len(pool.tried) == 1:
        return entry
    best = rank(state, background, CandidateColumns(state, pool), 1)[0]
    # The penalty for the number of candidates is that of the coarse search; only the fit improves.
    before, after = (max(background.sum_of_squares - e.gain, 1e-300) for e in (entry, best))
    gained = float(0.5 * background.degrees_of_freedom * np.log(before / after))
    if gained < state.settings.selection.least_refinement:
        return entry
    return replace(
        entry,
        effect=best.effect.at_a_pose(state.dataset, state.residuals.poses),
        gain=best.gain,
        evidence=entry.evidence + gained,
    )


def candidate_entries(ranking: Sequence[Scored], sum_of_squares: float) -> list[dict[str, Any]]:
    """Return the leading candidates as ``diagnosis.json`` lists them, best first, each title once.

    A gear error is a candidate order by order and with several orders at once, and both may select the same orders. Unobservable candidates have
    no score and are left out.

    Args:
        ranking: The candidates on the residual without effects, best first.
        sum_of_squares: Of that residual, whitened.
    """
    best: dict[str, Scored] = {}
    for entry in ranking:
        if entry.dof:
            best.setdefault(entry.effect.title, entry)
    return [
        {
            "name": entry.effect.name,
            "target": entry.effect.target,
            "title": title,
            "evidence_nats": entry.evidence,
            "share_of_residual": min(entry.gain / sum_of_squares, 1.0),
            "p_value": entry.p_value,
        }
        for title, entry in best.items()
    ]
