"""Search for the set of effects that explains the data best, where one effect alone explains little.

Of several strong effects each explains a small share of the residual, so that with few poses none is significant while the others are missing,
and forward selection ends before it has begun. All of them together leave no more than the noise, which is known from the scatter within the
scans. So sets of effects are grown without asking whether each step is significant: the best few sets of every size are extended by what
explains most beside them (a beam search), then each member of the best set is exchanged for what serves better, and the evidence of the whole
set decides. What is found is a proposal: the set is to be fitted, and each of its effects tested given the others.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy import linalg

from scalar.diagnosis.candidate_columns import CandidateSet
from scalar.diagnosis.conditional_scores import columns_of_effects
from scalar.diagnosis.fitted_state import FittedState
from scalar.diagnosis.hold_out import blocks
from scalar.diagnosis.merging import merged
from scalar.diagnosis.score_test import Background, in_prior_units, shrunk_gain
from scalar.effects import Effect
from scalar.geometry.se3 import Array

# How far the search goes: with larger numbers it finds the same, more slowly.
WIDTH = 24  # sets of each size that are extended
BRANCHES = 8  # pieces by which each of them is extended, one of a family
MOST_PIECES = 14  # of a set: five effects with two or three pieces each
MOMENTS = 40  # at which a change is tried at first


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
    pieces = rows.pieces(everywhere, moments)
    chosen = pieces.best()
    if step > 1:
        coarse = [i for p in chosen for i in pieces.begins[p]]
        moments = {j for i in coarse for j in range(i - step, i + step + 1)}
        pieces = rows.pieces(everywhere, moments)
        chosen = pieces.best()
    fold = blocks(state.dataset.q, state.settings.hold_out)[1]
    needed = np.zeros(len(chosen))
    for f in np.unique(fold):
        fewer = rows.pieces(everywhere[fold != f], moments)
        complete = fewer.subset(chosen).evidence
        needed += [fewer.subset(tuple(q for q in chosen if q != p)).evidence < complete for p in chosen]
    effects: tuple[Effect, ...] = ()
    for p, times in zip(chosen, needed, strict=True):
        if times >= state.settings.subset_search.stable * len(np.unique(fold)):
            effects = merged(effects, pieces.effects[p])
    return effects


@dataclass(frozen=True)
class Subset:
    """A set of pieces.

    Attributes:
        pieces: Their indices, ascending.
        squared: Squared residual with them [noise variances], with the penalty of the coefficients' priors.
        evidence: Of the set [nats].
    """

    pieces: tuple[int, ...]
    squared: float
    evidence: float


@dataclass(frozen=True, eq=False)
class Pieces:
    """What sets are made of: an element of the candidate set, or a change at a moment; columns in units of priors and noise.

    Attributes:
        effects: Of each piece.
        begins: Of each piece: the pose with which a change begins, empty where it is none.
        columns: Of each piece ``(w,)``, indices.
        family: Of each piece; of a family only the best member extends a set.
        gram: ``(e, e)``, of all columns given the state.
        projection: ``(e,)``, of its residual onto them.
        squared: Of its residual [noise variances].
        freedom: Its degrees of freedom.
        tried: How many candidates there are.
        least: Of the noise's variance, what any set is taken to leave.
    """

    effects: Sequence[Effect]
    begins: Sequence[Sequence[int]]
    columns: Sequence[Array]
    family: Array
    gram: Array
    projection: Array
    squared: float
    freedom: int
    tried: int
    least: float

    def best(self) -> tuple[int, ...]:
        """Return the pieces of the set with the most evidence."""
        best, beam = self.subset(()), [self.subset(())]
        for _ in range(MOST_PIECES):
            extended = {more: None for subset in beam for more in self.extensions(subset, BRANCHES)}
            if not extended:
                break
            beam = sorted((self.subset(more) for more in extended), key=lambda s: -s.evidence)[:WIDTH]
            best = max(best, beam[0], key=lambda s: s.evidence)
        return self.exchanged(best).pieces

    def exchanged(self, subset: Subset) -> Subset:
        """Return a set that is not the better for leaving out one of its pieces, nor for exchanging one."""
        while True:  # each exchange adds evidence
            fewer = [self.subset(tuple(p for p in subset.pieces if p != piece)) for piece in subset.pieces]
            others = [self.subset(more) for less in fewer for more in self.extensions(less, BRANCHES)]
            best = max([subset, *fewer, *others], key=lambda s: s.evidence)
            if best is subset:
                return subset
            subset = best

    def subset(self, pieces: tuple[int, ...]) -> Subset:
        """Return a set with its evidence."""
        where = self._where(pieces)
        gram, s = self.gram[np.ix_(where, where)], self.projection[where]
        values, vectors = np.linalg.eigh(gram)
        gain = float(np.sum((vectors.T @ s) ** 2 / (1.0 + np.maximum(values, 0.0))))
        squared = self.squared - gain
        choice = len(pieces) * np.log(self.tried)
        return Subset(pieces, squared, float(self._worth(squared, np.sum(values > 1.0)) - choice))

    def extensions(self, subset: Subset, most: int) -> list[tuple[int, ...]]:
        """Return the sets with one more piece that explain most, one for each family, best first."""
        where = self._where(subset.pieces)
        factor = linalg.cholesky(self.gram[np.ix_(where, where)] + np.eye(len(where)), lower=True)
        across = linalg.solve_triangular(
            factor, np.column_stack([self.gram[where], self.projection[where]]), lower=True
        )
        shared, projection = across[:, :-1], self.projection - across[:, :-1].T @ across[:, -1]
        worth = np.full(len(self.columns), -np.inf)
        for members, places in self._by_width:
            B = shared[:, places]
            grams = self._blocks[places.shape[1]] - np.einsum("atw,atv->twv", B, B)
            gains, dofs = shrunk_gain(grams, projection[places])
            worth[members] = np.where(gains > 0.0, self._worth(subset.squared - gains, dofs), -np.inf)
        worth[list(subset.pieces)] = -np.inf
        found: dict[int, tuple[int, ...]] = {}
        for k in np.argsort(-worth, kind="stable"):
            if worth[k] == -np.inf or len(found) == most:
                break
            found.setdefault(int(self.family[k]), tuple(sorted((*subset.pieces, int(k)))))
        return list(found.values())

    @cached_property
    def _by_width(self) -> list[tuple[list[int], Array]]:
        """Return the pieces by their number of columns, with these ``(T, w)``."""
        widths = sorted({len(where) for where in self.columns})
        members = [[k for k, where in enumerate(self.columns) if len(where) == width] for width in widths]
        return [(some, np.array([self.columns[k] for k in some])) for some in members]

    @cached_property
    def _blocks(self) -> dict[int, Array]:
        """Return the gram ``(T, w, w)`` of each piece, by the number of columns."""
        return {w.shape[1]: self.gram[w[:, :, None], w[:, None, :]] for _, w in self._by_width}

    def _where(self, pieces: tuple[int, ...]) -> Array:
        return np.concatenate([np.zeros(0, dtype=int), *(self.columns[p] for p in pieces)])

    def _worth(self, squared: Any, dof: Any) -> Any:
        """Return fit less complexity [nats]: the log evidence but for how many were tried."""
        n = self.freedom
        return -0.5 * n * np.log(np.maximum(squared / n, self.least)) - 0.5 * dof * np.log(n)


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

    def pieces(self, poses: Array, moments: Collection[int]) -> Pieces:
        """Return what sets are made of, by some of the poses; changes begin at some of the poses ``moments``."""
        state, candidates, settings = self.state, self.candidates, self.state.settings.score_test
        rows, used = state.rows_of(poses)
        m = state.residuals.measurement.rows_per_pose
        background = Background.of(self.residual[used], self.jacobian[used], len(poses), m, settings)
        ends = np.cumsum([len(effect.coefficients) for effect in candidates.effects])
        own = np.split(np.arange(self.columns.shape[1]), ends[:-1])
        n = len(candidates.elements)
        effects, columns, family = list(candidates.elements), own[:n], list(range(n))
        begins: list[tuple[int, ...]] = [()] * n
        parts, sizes, width = [self.columns[rows]], [candidates.sizes], self.columns.shape[1]
        for k, where in enumerate(own[n:]):
            for i, effect, moved in _moments(state, candidates.changes[k], self.columns[:, where], moments):
                effects.append(effect)
                begins.append((i,))
                columns.append(width + np.arange(len(where)))
                family.append(n + k)
                parts.append(moved[rows])
                sizes.append(effect.prior_std)
                width += len(where)
        E, prior_std = np.concatenate(parts, axis=1), np.concatenate(sizes)
        squares = np.sum(E * E, axis=0)
        E = E - background.Q @ (background.Q.T @ E)
        seen = np.sum(E * E, axis=0) > settings.unobservable_share * squares
        E = E * np.where(seen, in_prior_units(background, squares, prior_std), 0.0)
        gram, projection = E.T @ E, E.T @ background.residual.ravel()
        return Pieces(effects, begins, columns, np.array(family), gram, projection,
                      background.squared, background.freedom, max(candidates.total, 1), settings.least_remainder)  # fmt: skip


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
