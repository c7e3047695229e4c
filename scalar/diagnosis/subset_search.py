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

import numpy as np

from scalar.diagnosis.background import Background
from scalar.diagnosis.beam_search import SearchElements
from scalar.diagnosis.candidate_columns import CandidateSet
from scalar.diagnosis.change_scores import beginnings
from scalar.diagnosis.conditional_scores import columns_of_effects
from scalar.diagnosis.fitted_state import FittedState
from scalar.diagnosis.hold_out import blocks_of
from scalar.diagnosis.merging import merged
from scalar.diagnosis.score_test import in_prior_units
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
    chosen = elements.of_poses(all_poses).best()
    if step > 1:
        # In a second, fine search changes may begin at every pose near those that the coarse search found.
        coarse = [i for p in chosen for i in elements.onsets[p]]
        moments = {j for i in coarse for j in range(i - step, i + step + 1)}
        elements = rows.element_rows(moments)
        chosen = elements.of_poses(all_poses).best()
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
        columns: ``(N m, e)``, derivatives of the rows by the coefficients of ``candidates.effects``, in their order.
    """

    state: FittedState
    candidates: CandidateSet
    residual: Array
    jacobian: Array
    columns: Array

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
        effects, columns, family = list(candidates.elements), columns_of_each[:n], list(range(n))
        onsets: list[tuple[int, ...]] = [()] * n
        column_blocks, width = [self.columns], self.columns.shape[1]
        for k, where in enumerate(columns_of_each[n:]):
            for i, effect, after_onset in _changes_at(
                state, candidates.changes[k], self.columns[:, where], moments
            ):
                effects.append(effect)
                onsets.append((i,))
                columns.append(width + np.arange(len(where)))
                family.append(n + k)
                column_blocks.append(after_onset)
                width += len(where)
        E = np.concatenate(column_blocks, axis=1)
        of_each = [*candidates.effects, *effects[n:]]
        prior_std, plausible_std = (
            np.concatenate([np.zeros(0), *(getattr(effect, name) for effect in of_each)])
            for name in ("prior_std", "plausible_std")
        )
        return _ElementRows(self, effects, onsets, columns, np.array(family), E, prior_std, plausible_std)


@dataclass(frozen=True, eq=False)
class _ElementRows:
    """Elements, and their columns in the rows of all poses.

    Attributes:
        rows: The linearised rows of the state without its effects.
        effects: The effect of each element.
        onsets: For each element the index of the pose with which its change begins; empty if it is not a change.
        columns: The indices ``(w,)`` of the columns of each element.
        family: ``(n,)``, the family of each of the n elements: changes of one kind at different poses have the same one (``beam_search``).
        E: ``(N m, e)``, all e columns, whitened for the noise within scans.
        prior_std: ``(e,)``, prior standard deviations of the columns' coefficients, in the units of the coefficients.
        plausible_std: ``(e,)``, those by whose multiples they are judged implausible.
    """

    rows: _Rows
    effects: Sequence[Effect]
    onsets: Sequence[Sequence[int]]
    columns: Sequence[Array]
    family: Array
    E: Array
    prior_std: Array
    plausible_std: Array

    def only(self, chosen: Sequence[int]) -> _ElementRows:
        """Return the elements with the indices ``chosen``, in that order, without the columns of the others."""
        kept_columns = np.concatenate([np.zeros(0, dtype=int), *(self.columns[p] for p in chosen)])
        ends = np.cumsum([len(self.columns[p]) for p in chosen])
        columns = np.split(np.arange(len(kept_columns)), ends[:-1]) if chosen else []
        effects, onsets = [self.effects[p] for p in chosen], [self.onsets[p] for p in chosen]
        family = self.family[list(chosen)]
        E, prior_std, plausible_std = (
            values[..., kept_columns] for values in (self.E, self.prior_std, self.plausible_std)
        )
        return _ElementRows(self.rows, effects, onsets, columns, family, E, prior_std, plausible_std)

    def of_poses(self, poses: Array) -> SearchElements:
        """Return what the search needs of the elements, computed from the rows of the poses with the indices ``poses`` and of the priors."""
        state, settings = self.rows.state, self.rows.state.settings.score_test
        rows, used = state.rows_of(poses)
        m = state.residuals.measurement.rows_per_pose
        residual, jacobian = self.rows.residual[used], self.rows.jacobian[used]
        background = Background.of(residual, jacobian, len(poses), m, settings)
        E = self.E[rows]
        squares = np.sum(E * E, axis=0)
        E = E - background.Q @ (background.Q.T @ E)
        observable = np.sum(E * E, axis=0) > settings.unobservable_share * squares
        E = E * np.where(observable, in_prior_units(background, squares, self.prior_std), 0.0)
        gram, projection = E.T @ E, E.T @ background.residual.ravel()
        most = state.settings.selection.plausible_coefficient
        in_prior_std = np.divide(
            self.plausible_std,
            self.prior_std,
            where=np.isfinite(self.prior_std),
            out=np.full(len(squares), np.inf),
        )
        return SearchElements(self.columns, self.family, gram, projection, background.sum_of_squares, background.degrees_of_freedom,
                      max(self.rows.candidates.total, 1), settings.least_remainder, most * in_prior_std)  # fmt: skip


def _changes_at(
    state: FittedState, change: tuple[Effect, Array], acting: Array, moments: Collection[int]
) -> Iterator[tuple[int, Effect, Array]]:
    """Yield one kind of change for each pose with which it may begin: the index of that pose, the effect, and its columns ``(N m, w)``.

    Args:
        state: The fitted state.
        change: The effect as if it acted from the first pose on, and ``(N,)`` bool, the poses that it touches at all (those of one target plane, for
            example).
        acting: ``(N m, w)``, its columns if it acts from the first pose on.
        moments: Indices of poses. For each of them the change begins with the first pose, at or after it, with which it may begin
            (``change_scores.beginnings``).
    """
    effect, touched = change
    index = np.flatnonzero(touched)
    possible = index[beginnings(len(index), acting.shape[1], state.settings.selection.change_margin)]
    after = np.searchsorted(possible, np.array(sorted(moments), dtype=int))
    order, time = state.residuals.poses.order, state.residuals.poses.columns.get("time")
    pose = np.repeat(np.arange(state.dataset.n_poses), state.residuals.measurement.rows_per_pose)
    for i in possible[np.unique(after[after < len(possible)])]:
        begun = effect.beginning(float(order[i]), None if time is None else float(time[i]))
        yield int(i), begun, np.where((pose >= i)[:, None], acting, 0.0)
