"""Search for the set of effects that explains the data best, where one effect alone explains little.

If several strong effects are present, each of them explains only a small share of the residual. With few poses, none is then significant while
the others are missing from the model, and forward selection stops at its first step. All of them together, however, leave only the noise, whose size
is known from the scatter within the scans.

This search therefore does not ask whether each step is significant; the log evidence of the whole set decides. An *element* is the smallest part of a
set: an effect of the candidate set that cannot be divided further (one order of one joint, for example), or a change that begins at a certain pose.
The best few sets of each size are extended by the elements that explain most given the set (``beam_search``). Each element of the best set is then
exchanged if another element gives more evidence. Elements of the same effect are merged in the result. The result is a proposal: the caller has to
fit the set, and to test each of its effects given the others.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from scalar.diagnosis.fit.background import Background
from scalar.diagnosis.fit.fitted_state import FittedState
from scalar.diagnosis.held_out.hold_out import blocks_of
from scalar.diagnosis.scoring.candidate_columns import CandidateSet
from scalar.diagnosis.scoring.change_scores import beginnings
from scalar.diagnosis.scoring.conditional_scores import columns_of_effects
from scalar.diagnosis.scoring.merging import merged
from scalar.diagnosis.scoring.onset_products import OnsetColumns
from scalar.diagnosis.scoring.score_test import in_prior_units
from scalar.diagnosis.selection.beam_search import SearchElements
from scalar.effects import Effect
from scalar.geometry.se3 import Array

FIRST_MOMENTS = 40  # poses at which a change may begin in the first, coarse search; a larger number gives the same result more slowly


def best_subset(state: FittedState, candidates: CandidateSet) -> tuple[Effect, ...]:
    """Return the set of effects that explains the data best; it need not contain the effects of the state.

    With few poses, some of the many candidates explain chance patterns of the residual. Which candidates do so changes with the poses.
    An element of the best set is therefore kept only if it adds evidence to the set in most of the subsets of the poses that leave out one fold
    (after stability selection: Meinshausen and Bühlmann, Journal of the Royal Statistical Society B 72, 2010).

    Args:
        state: The fitted state. The model is linearised at its optimum.
        candidates: The candidate set.

    Returns:
        The effects, elements of the same effect merged; they are not fitted yet. Empty if no element is stable.
    """
    N = state.dataset.n_poses
    all_poses = np.arange(N)
    step = max(N // FIRST_MOMENTS, 1)
    moments: Collection[int] = range(0, N, step)
    rows = _Rows.of(state, candidates)
    elements = rows.element_rows(moments)
    chosen = elements.of_all_poses().best()
    if step > 1:
        # In a second, fine search changes may begin at every pose near those that the coarse search found.
        coarse = [i for p in chosen if (i := elements.onsets[p]) is not None]
        moments = {j for i in coarse for j in range(i - step, i + step + 1)}
        elements = rows.element_rows(moments)
        chosen = elements.of_all_poses().best()
    elements = elements.only(chosen)
    complete_set = tuple(range(len(chosen)))
    sets = [complete_set, *(tuple(q for q in complete_set if q != p) for p in complete_set)]
    fold = blocks_of(state)[1]
    # For each element of the set, the number of subsets of the poses, each without one fold, in which it adds evidence to the set.
    n_needed = np.zeros(len(chosen))
    for f in np.unique(fold):
        complete, *each_left_out = elements.of_poses(all_poses[fold != f]).subsets(sets)
        n_needed += [fewer.evidence < complete.evidence for fewer in each_left_out]
    effects: tuple[Effect, ...] = ()
    for effect, count in zip(elements.effects, n_needed, strict=True):
        if count >= state.settings.subset_search.stable_share * len(np.unique(fold)):
            effects = merged(effects, effect)
    return effects


@dataclass(frozen=True, eq=False)
class _Rows:
    """The linearised rows of a state without its effects, and the columns of all candidates; all are whitened for the noise within scans.

    Attributes:
        state: The fitted state of N poses with m rows each.
        candidates: The candidate set.
        residual: ``(N m + priors,)``, extrapolated linearly to effects of zero.
        jacobian: ``(N m + priors, F)``, derivatives of the rows by the free parameters of robot, sensor and target.
        columns: ``(N m, S)``, derivatives of the rows by the coefficients of ``candidates.effects``, in their order.
    """

    state: FittedState
    candidates: CandidateSet
    residual: Array
    jacobian: Array
    columns: Array

    def background(self, poses: Array) -> Background:
        """Return the background of the rows of the poses with the indices ``poses``, and of the rows of priors."""
        used, m = self.state.rows_of(poses)[1], self.state.residuals.measurement.rows_per_pose
        settings = self.state.settings.score_test
        return Background.of(self.residual[used], self.jacobian[used], len(poses), m, settings)

    @cached_property
    def of_all_poses(self) -> Background:
        """Return the background of all poses."""
        return self.background(np.arange(self.state.dataset.n_poses))

    @cached_property
    def on_background(self) -> OnsetColumns:
        """Return the background's Q, its residual, and the columns of the candidates: all of which products are needed."""
        background = self.of_all_poses
        given = np.vstack([background.Q.T, background.residual.reshape(1, -1), self.columns.T]).T
        return OnsetColumns(given, self.state.residuals.measurement.rows_per_pose)

    @classmethod
    def of(cls, state: FittedState, candidates: CandidateSet) -> _Rows:
        """Return the rows of a state without its effects, and the columns of the candidates at its optimum."""
        residual, jacobian = state.linearised()
        of_effects, _ = columns_of_effects(state, range(len(state.effects)))
        without = residual - jacobian[:, of_effects] @ state.model.vector[state.free][of_effects]
        columns = state.columns_within_scans(candidates.effects, candidates.bases)
        return cls(state, candidates, without, jacobian[:, ~of_effects], columns)

    def element_rows(self, moments: Collection[int]) -> _ElementRows:
        """Return the elements of the candidate set, and each kind of change once for each of the poses ``moments`` at which it may begin."""
        state, candidates = self.state, self.candidates
        ends = np.cumsum([len(effect.coefficients) for effect in candidates.effects])
        columns_of_each = np.split(np.arange(self.columns.shape[1]), ends[:-1])
        n = len(candidates.elements)
        effects, sources, family = list(candidates.elements), columns_of_each[:n], list(range(n))
        onsets: list[int | None] = [None] * n
        for k, where in enumerate(columns_of_each[n:]):
            for i, effect in _changes_at(state, candidates.changes[k], len(where), moments):
                effects.append(effect)
                onsets.append(i)
                sources.append(where)
                family.append(n + k)
        return _ElementRows(self, effects, onsets, sources, np.array(family))


@dataclass(frozen=True, eq=False)
class _ElementRows:
    """Elements, and where their columns are among those of the candidates.

    Attributes:
        rows: The linearised rows of the state without its effects.
        effects: The effect of each element.
        onsets: For each element the index of the pose with which its change begins; None if it is not a change.
        sources: The indices ``(w,)`` in ``rows.columns`` of the columns of each element. Those of a change act from its onset on.
        family: ``(n,)``, the family of each of the n elements: changes of one kind at different poses have the same one (``beam_search``).
    """

    rows: _Rows
    effects: Sequence[Effect]
    onsets: Sequence[int | None]
    sources: Sequence[Array]
    family: Array

    def only(self, chosen: Sequence[int]) -> _ElementRows:
        """Return the elements with the indices ``chosen``, in that order."""
        effects, onsets = [self.effects[p] for p in chosen], [self.onsets[p] for p in chosen]
        sources = [self.sources[p] for p in chosen]
        return _ElementRows(self.rows, effects, onsets, sources, self.family[list(chosen)])

    def of_all_poses(self) -> SearchElements:
        """Return what the search needs of the elements, computed from all rows."""
        background = self.rows.of_all_poses
        F = background.Q.shape[1]
        source, onset = self._source_and_onset
        begins = onset > 0  # these come last
        steady = np.r_[np.arange(F + 1), F + 1 + source[~begins]]
        gram = self.rows.on_background.grams(steady, F + 1 + source[begins], onset[begins])
        return self._searched(background, gram[F + 1 :, F + 1 :], gram[:F, F + 1 :], gram[F, F + 1 :])

    def of_poses(self, poses: Array) -> SearchElements:
        """Return the same, computed from the rows of the poses with the indices ``poses`` and of the priors; it is meant for few elements."""
        background, rows = self.rows.background(poses), self.rows.state.rows_of(poses)[0]
        E = self._columns[rows]
        return self._searched(background, E.T @ E, background.Q.T @ E, E.T @ background.residual.ravel())

    @cached_property
    def _source_and_onset(self) -> tuple[Array, Array]:
        """Return for each of the e columns its index in ``rows.columns``, and the index of the pose from which on it acts, ``(e,)`` each."""
        onset = [first or 0 for first in self.onsets]
        none = np.zeros(0, dtype=int)
        source = np.concatenate([none, *self.sources])
        return source, np.repeat(np.array(onset, dtype=int), [len(where) for where in self.sources])

    @cached_property
    def _columns(self) -> Array:
        """Return the columns ``(N m, e)`` of all elements."""
        m = self.rows.state.residuals.measurement.rows_per_pose
        return OnsetColumns(self.rows.columns, m).columns(*self._source_and_onset)

    def _searched(
        self, background: Background, gram: Array, along: Array, projection: Array
    ) -> SearchElements:
        """Return what the search needs of the elements.

        Args:
            background: The residual, and the directions that the model explains.
            gram: ``(e, e)``, inner products of the columns of the elements.
            along: ``(F, e)``, those with the background's Q.
            projection: ``(e,)``, those with its residual.
        """
        state, settings = self.rows.state, self.rows.state.settings.score_test
        widths = [len(where) for where in self.sources]
        prior_std, plausible_std = (
            np.concatenate([np.zeros(0), *(getattr(effect, name) for effect in self.effects)])
            for name in ("prior_std", "plausible_std")
        )
        squares = np.diag(gram)
        given = along.T @ along
        gram = np.subtract(gram, given, out=given)
        observable = np.diag(gram) > settings.unobservable_share * squares
        scale = np.where(observable, in_prior_units(background, squares, prior_std), 0.0)
        gram *= scale[:, None]
        gram *= scale
        most = state.settings.selection.plausible_coefficient
        in_prior_std = np.divide(
            plausible_std, prior_std, where=np.isfinite(prior_std), out=np.full(len(squares), np.inf)
        )
        columns = np.split(np.arange(len(squares)), np.cumsum(widths)[:-1]) if widths else []
        return SearchElements(columns, self.family, gram, projection * scale, background.sum_of_squares, background.degrees_of_freedom,
                              max(self.rows.candidates.total, 1), settings.least_remainder, most * in_prior_std)  # fmt: skip


def _changes_at(
    state: FittedState, change: tuple[Effect, Array], width: int, moments: Collection[int]
) -> Iterator[tuple[int, Effect]]:
    """Yield one kind of change for each pose with which it may begin: the index of that pose, and the effect.

    Args:
        state: The fitted state.
        change: The effect as if it acted from the first pose on, and ``(N,)`` bool, the poses that it touches at all (those of one target plane, for
            example).
        width: Number of its columns.
        moments: Indices of poses. For each of them the change begins with the first pose, at or after it, with which it may begin
            (``change_scores.beginnings``).
    """
    effect, touched = change
    index = np.flatnonzero(touched)
    possible = index[beginnings(len(index), width, state.settings.selection.change_margin)]
    after = np.searchsorted(possible, np.array(sorted(moments), dtype=int))
    order, time = state.residuals.poses.order, state.residuals.poses.columns.get("time")
    for i in possible[np.unique(after[after < len(possible)])]:
        yield int(i), effect.beginning(float(order[i]), None if time is None else float(time[i]))
