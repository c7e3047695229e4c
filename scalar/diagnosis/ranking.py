"""Rank all candidates by their score on a residual, and refine the nonlinear parameters of the best ones."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field, replace
from math import comb, log

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
    candidates = columns.candidates
    families = Counter(candidate.name for candidate, _ in candidates.tried)
    conditional = columns.conditional(background)
    tally = _Tally()
    for width, members in candidates.by_width.items():
        gain, dof, observability = (values.tolist() for values in conditional[width].score())
        for k, (candidate, _) in enumerate(members):
            family = families[candidate.name] + candidates.elsewhere
            if candidate.n_terms <= 1:
                tally.add(candidate, gain[k], dof[k], observability[k], family, candidates.total)
                continue
            rest, freedom = remainder(background, gain[k], dof[k])
            projected, terms = conditional[width].of(k), np.arange(width).reshape(candidate.n_terms, -1)
            # Each term is penalised for its columns and for the number of terms tried, as it would be alone.
            price = np.log(background.freedom) + 2 * np.log(candidate.n_terms) / terms.shape[1]
            chosen = projected.forward(terms, worth=float(price * rest / freedom))
            if not chosen:
                continue
            own = projected.score(terms[sorted(chosen)].reshape(1, -1))
            choices = comb(candidate.n_terms, len(chosen))
            tally.add(
                candidate.with_terms(chosen), own[0][0], own[1][0], observability[k], family * choices,
                candidates.total * choices,
            )  # fmt: skip
    _tally_changes(tally, state, background, columns)
    return sorted(tally.scored(background), key=lambda entry: -entry.evidence)


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
        tally.add(at, found.gain[best], found.dof[best], 1.0, len(found.gain), columns.candidates.total)


@dataclass
class _Tally:
    """Candidates whose p-values and evidence are worked out all at once."""

    effects: list[Effect] = field(default_factory=list)
    numbers: list[tuple[float, int, float, float, float]] = field(default_factory=list)

    def add(
        self, effect: Effect, gain: float, dof: int, observability: float, family: int, total: int
    ) -> None:
        """Add a candidate; how many were tried may be more than a machine's number holds, for the choices of terms multiply."""
        self.effects.append(effect)
        self.numbers.append((gain, dof, observability, log(max(family, 1)), float(total)))

    def scored(self, background: Background) -> list[Scored]:
        """Return the candidates with their scores, in the order in which they were added."""
        gain, dof, observability, log_family, total = np.array(self.numbers, dtype=float).reshape(-1, 5).T
        p = np.minimum(1.0, np.maximum(p_value(background, gain, dof), _LEAST_P_VALUE) * total)
        nats = evidence(background, gain, dof, log_family)
        rows = zip(
            self.effects, gain.tolist(), dof.astype(int).tolist(), nats.tolist(), p.tolist(), observability.tolist(),
            strict=True,
        )  # fmt: skip
        return [Scored(*row) for row in rows]


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
    tally.add(effect, gain, dof, observability, family, total)
    return tally.scored(background)[0]


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
