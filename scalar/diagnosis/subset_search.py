"""Search for the set of effects that explains the data best, where one effect alone explains little.

Of several strong effects each explains a small share of the residual, so that with few poses none is significant while the others are missing,
and forward selection ends before it has begun. All of them together leave no more than the noise, which is known from the scatter within the
scans. So sets of effects are grown without asking whether each step is significant: the best few sets of every size are extended by what
explains most beside them (``beam_search``), then each member of the best set is exchanged for what serves better, and the evidence of the whole
set decides. What is found is a proposal: the set is to be fitted, and each of its effects tested given the others.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from scalar.diagnosis.beam_search import Pieces
from scalar.diagnosis.candidate_columns import CandidateSet
from scalar.diagnosis.conditional_scores import columns_of_effects
from scalar.diagnosis.fitted_state import FittedState
from scalar.diagnosis.hold_out import blocks
from scalar.diagnosis.merging import merged
from scalar.diagnosis.score_test import Background, in_prior_units
from scalar.effects import Effect
from scalar.geometry.se3 import Array

MOMENTS = 40  # at which a change is tried at first; with more it finds the same, more slowly


def best_subset(state: FittedState, candidates: CandidateSet) -> tuple[Effect, ...]:
    """Return the effects that explain the data best, all together, in place of those that a state has.

    They are picked from many, and with few poses some of so many imitate what is left of any other. Such ones change with the poses, so the set
    has to have more evidence with a piece than without it in each of most parts of the poses (after stability selection: Meinshausen and
    Buehlmann, Journal of the Royal Statistical Society B 72, 2010).

    Args:
        state: Fitted; everything is linear about its optimum.
        candidates: What is tried.
    """
    N = state.dataset.n_poses
    everywhere = np.arange(N)
    step = max(N // MOMENTS, 1)
    moments: Collection[int] = range(0, N, step)
    rows = _Rows.of(state, candidates)
    laid = rows.laid_out(moments)
    chosen = laid.pieces(everywhere).best()
    if step > 1:
        coarse = [i for p in chosen for i in laid.begins[p]]
        moments = {j for i in coarse for j in range(i - step, i + step + 1)}
        laid = rows.laid_out(moments)
        chosen = laid.pieces(everywhere).best()
    laid = laid.only(chosen)
    whole = tuple(range(len(chosen)))
    sets = [whole, *(tuple(q for q in whole if q != p) for p in whole)]
    fold = blocks(state.dataset.q, state.settings.hold_out)[1]
    needed = np.zeros(len(chosen))
    for f in np.unique(fold):
        complete, *fewer = laid.pieces(everywhere[fold != f]).subsets(sets)
        needed += [less.evidence < complete.evidence for less in fewer]
    effects: tuple[Effect, ...] = ()
    for effect, times in zip(laid.effects, needed, strict=True):
        if times >= state.settings.subset_search.stable * len(np.unique(fold)):
            effects = merged(effects, effect)
    return effects


@dataclass(frozen=True, eq=False)
class _Rows:
    """The rows of a state without its effects, whitened within scans, and the columns of all candidates.

    Attributes:
        state: Fitted. candidates: What is tried.
        residual: ``(N m + priors,)``. jacobian: By the free geometry.
        columns: ``(N m, e)``.
    """

    state: FittedState
    candidates: CandidateSet
    residual: Array
    jacobian: Array
    columns: Array

    @classmethod
    def of(cls, state: FittedState, candidates: CandidateSet) -> _Rows:
        """Return the rows of a state."""
        residual, jacobian = state.linearised()
        mine, _ = columns_of_effects(state, range(len(state.effects)))
        without = residual - jacobian[:, mine] @ state.model.vector[state.free][mine]
        columns = state.columns_within_scans(candidates.effects, candidates.bases)
        return cls(state, candidates, without, jacobian[:, ~mine], columns)

    def laid_out(self, moments: Collection[int]) -> _LaidOut:
        """Return the pieces with their columns; changes begin at some of the poses ``moments``."""
        state, candidates = self.state, self.candidates
        ends = np.cumsum([len(effect.coefficients) for effect in candidates.effects])
        own = np.split(np.arange(self.columns.shape[1]), ends[:-1])
        n = len(candidates.elements)
        effects, columns, family = list(candidates.elements), own[:n], list(range(n))
        begins: list[tuple[int, ...]] = [()] * n
        parts, sizes, width = [self.columns], [candidates.sizes], self.columns.shape[1]
        for k, where in enumerate(own[n:]):
            for i, effect, moved in _moments(state, candidates.changes[k], self.columns[:, where], moments):
                effects.append(effect)
                begins.append((i,))
                columns.append(width + np.arange(len(where)))
                family.append(n + k)
                parts.append(moved)
                sizes.append(effect.prior_std)
                width += len(where)
        E, prior_std = np.concatenate(parts, axis=1), np.concatenate(sizes)
        return _LaidOut(self, effects, begins, columns, np.array(family), E, prior_std)


@dataclass(frozen=True, eq=False)
class _LaidOut:
    """Pieces with the rows of their columns, at all poses.

    Attributes:
        rows: Of the state.
        effects: Of each piece.
        begins: Of each piece: the pose with which a change begins, empty where it is none.
        columns: Of each piece ``(w,)``, indices.
        family: Of each piece.
        E: ``(N m, e)``.
        prior_std: ``(e,)``.
    """

    rows: _Rows
    effects: Sequence[Effect]
    begins: Sequence[Sequence[int]]
    columns: Sequence[Array]
    family: Array
    E: Array
    prior_std: Array

    def only(self, chosen: Sequence[int]) -> _LaidOut:
        """Return some of the pieces, with their columns alone."""
        taken = np.concatenate([np.zeros(0, dtype=int), *(self.columns[p] for p in chosen)])
        ends = np.cumsum([len(self.columns[p]) for p in chosen])
        columns = np.split(np.arange(len(taken)), ends[:-1]) if chosen else []
        effects, begins = [self.effects[p] for p in chosen], [self.begins[p] for p in chosen]
        family = self.family[list(chosen)]
        return _LaidOut(self.rows, effects, begins, columns, family, self.E[:, taken], self.prior_std[taken])

    def pieces(self, poses: Array) -> Pieces:
        """Return what sets are made of, by some of the poses."""
        state, settings = self.rows.state, self.rows.state.settings.score_test
        rows, used = state.rows_of(poses)
        m = state.residuals.measurement.rows_per_pose
        residual, jacobian = self.rows.residual[used], self.rows.jacobian[used]
        background = Background.of(residual, jacobian, len(poses), m, settings)
        E = self.E[rows]
        squares = np.sum(E * E, axis=0)
        E = E - background.Q @ (background.Q.T @ E)
        seen = np.sum(E * E, axis=0) > settings.unobservable_share * squares
        E = E * np.where(seen, in_prior_units(background, squares, self.prior_std), 0.0)
        gram, projection = E.T @ E, E.T @ background.residual.ravel()
        return Pieces(self.columns, self.family, gram, projection, background.squared, background.freedom,
                      max(self.rows.candidates.total, 1), settings.least_remainder)  # fmt: skip


def _moments(
    state: FittedState, change: tuple[Effect, Array], acting: Array, moments: Collection[int]
) -> Iterator[tuple[int, Effect, Array]]:
    """Yield a change at several moments: the pose with which it begins, the effect, and its columns ``(N m, w)``.

    Args:
        state: Fitted.
        change: The effect as it acts all the time, and the poses that it touches.
        acting: ``(N m, w)``, its columns where it acts all the time.
        moments: Poses; it begins with the first one that it touches from there on.
    """
    effect, touched = change
    index, margin = np.flatnonzero(touched), state.settings.selection.change_margin
    possible = index[margin : len(index) - margin + 1]
    after = np.searchsorted(possible, np.array(sorted(moments), dtype=int))
    order, time = state.residuals.poses.order, state.residuals.poses.columns.get("time")
    pose = np.repeat(np.arange(state.dataset.n_poses), state.residuals.measurement.rows_per_pose)
    for i in possible[np.unique(after[after < len(possible)])]:
        at = effect.beginning(float(order[i]), None if time is None else float(time[i]))
        yield int(i), at, np.where((pose >= i)[:, None], acting, 0.0)
