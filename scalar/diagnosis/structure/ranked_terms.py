"""Rank the flexible terms: those that would explain most given the effects of a state, or in the place of some of them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from scalar.diagnosis.fit.background import Background
from scalar.diagnosis.fit.fitted_state import FittedState
from scalar.diagnosis.scoring.candidate_columns import CandidateColumns, CandidateSet
from scalar.diagnosis.scoring.candidate_set import flexible
from scalar.diagnosis.scoring.ranking import Scored, rank, refined
from scalar.effects import Effect

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset

COLUMNS_AT_ONCE = 512  # of flexible terms that are computed together


def flexible_candidate_sets(dataset: Dataset) -> list[CandidateSet]:
    """Return all flexible terms of a dataset as candidate sets that are small enough for the memory (``in_parts``)."""
    return in_parts(flexible(dataset))


def in_parts(pool: Sequence[Effect]) -> list[CandidateSet]:
    """Return the candidate sets of consecutive parts of a pool of terms.

    The columns of all terms at once would take too much memory, and no products of columns of different terms are needed.
    """
    parts: list[list[Effect]] = [[]]
    width = 0
    for candidate in pool:
        width += len(candidate.coefficients)
        if width > COLUMNS_AT_ONCE:
            parts.append([])
            width = len(candidate.coefficients)
        parts[-1].append(candidate)
    return [CandidateSet.of(part, elsewhere=len(pool) - len(part)) for part in parts]


def rank_terms(
    state: FittedState, backgrounds: Sequence[Background], pools: Sequence[CandidateSet]
) -> list[list[Scored]]:
    """Return for each background the few flexible terms of all pools with the most evidence, best first."""
    most = state.settings.flexible_terms.most_terms_tried
    found: list[list[Scored]] = [[] for _ in backgrounds]
    for pool in pools:
        columns = CandidateColumns.of(state, pool)
        for entries, background in zip(found, backgrounds, strict=True):
            entries += rank(state, background, columns, most)
    return [sorted(entries, key=lambda entry: -entry.evidence)[:most] for entries in found]


def ranked_once(
    state: FittedState, backgrounds: Sequence[Background], pools: Sequence[CandidateSet]
) -> list[list[Scored]]:
    """Return what ``rank_terms`` does for pools that live as long as the state, each background ranked only once."""
    keys = {background: ("flexible terms", background, *pools) for background in backgrounds}
    missing = [background for background, key in keys.items() if key not in state.results]
    if missing:
        ranked = rank_terms(state, missing, pools)
        state.results.update(
            (keys[background], entries) for background, entries in zip(missing, ranked, strict=True)
        )
    return [state.results[keys[background]] for background in backgrounds]


def imitating(state: FittedState, background: Background, named: Effect) -> list[Scored]:
    """Return the few flexible terms with the most evidence that may imitate a named effect (``Effect.imitators``), best first; they may be none."""

    def ranked() -> list[Scored]:
        return rank_terms(state, [background], in_parts(named.imitators(state.dataset)))[0]

    return state.once(("imitating", background, named), ranked)


def refined_once(state: FittedState, background: Background, entry: Scored) -> Scored:
    """Return what ``refined`` does for an entry of a ranking that is kept by the state."""
    return state.once(("refined", background, entry), lambda: refined(state, background, entry))
