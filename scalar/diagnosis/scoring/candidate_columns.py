"""The columns of all candidates at a fitted model, computed once and scored again for every background.

Several candidates share columns (an order of a joint is a candidate itself and a part of the joint's whole spectrum); each column is kept once.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass, field
from functools import cached_property
from math import log
from typing import TYPE_CHECKING

import numpy as np

from scalar.diagnosis.fit.background import Background
from scalar.diagnosis.fit.column_products import Rows
from scalar.diagnosis.fit.effect_columns import Bases
from scalar.diagnosis.fit.fitted_state import FittedState
from scalar.diagnosis.scoring.candidate_set import candidates, changes, elements
from scalar.diagnosis.scoring.change_scores import ChangeColumns, ChangeScores
from scalar.diagnosis.scoring.score_test import Projected, observable_share, shrunk_gain
from scalar.effects import Effect
from scalar.geometry.se3 import Array

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset

_MOST_KEPT = 32_000_000  # bytes of all columns that a state keeps; others, as of thousands of poses, are computed anew each time


@dataclass(frozen=True, eq=False)
class CandidateSet:
    """All candidates of a dataset, made of elements (effects of one term); candidates with a common term share its element.

    Attributes:
        tried: The candidates, changes excepted, each with the indices of its columns.
        elements: The effects whose columns these are.
        changes: For every kind of change the effect as if it acted all the time, and ``(N,)`` bool, the poses that it touches. Their columns follow
            those of the elements.
        bases: The bases of effects at the poses (``effect_columns``), computed when they are first used.
        elsewhere: Number of further candidates of the same kind that are in other sets.
    """

    tried: list[tuple[Effect, Array]]
    elements: list[Effect]
    changes: list[tuple[Effect, Array]]
    bases: Bases = field(default_factory=Bases)
    elsewhere: int = 0

    @classmethod
    def of(
        cls, pool: Sequence[Effect], changes: Sequence[tuple[Effect, Array]] = (), elsewhere: int = 0
    ) -> CandidateSet:
        """Return the candidate set of some candidates and kinds of change; for ``elsewhere`` see the class."""
        columns: list[Effect] = []
        where: dict[str, Array] = {}
        tried, width = [], 0
        if all(candidate.n_terms == 1 for candidate in pool):  # none is a part of another
            ends = np.cumsum([0, *(len(candidate.coefficients) for candidate in pool)]).tolist()
            tried = [(each, np.arange(*ends[k : k + 2])) for k, each in enumerate(pool)]
            return cls(tried, list(pool), list(changes), elsewhere=elsewhere)
        for candidate in pool:
            indices = []
            for element in elements(candidate):
                key = f"{type(element).__name__} {element.to_mapping()}"
                if key not in where:
                    where[key] = width + np.arange(len(element.coefficients))
                    width += len(element.coefficients)
                    columns.append(element)
                indices.append(where[key])
            tried.append((candidate, np.concatenate(indices)))
        return cls(tried, columns, list(changes), elsewhere=elsewhere)

    @cached_property
    def effects(self) -> list[Effect]:
        """Return the elements and the kinds of change, in the order of their columns."""
        return [*self.elements, *(effect for effect, _ in self.changes)]

    @cached_property
    def prior_std(self) -> Array:
        """Return the prior standard deviation of every coefficient ``(e,)``, infinite if it has no prior."""
        return np.concatenate([np.zeros(0), *(effect.prior_std for effect in self.effects)])

    @cached_property
    def by_width(self) -> dict[int, list[tuple[Effect, Array]]]:
        """Return the candidates and the indices of their columns, by the number of columns."""
        result: dict[int, list[tuple[Effect, Array]]] = {}
        for candidate, where in self.tried:
            result.setdefault(len(where), []).append((candidate, where))
        return result

    @cached_property
    def families(self) -> dict[int, Array]:
        """Return for each candidate of ``by_width`` the logarithm of the number of candidates of its kind ``(T,)``."""
        return {
            width: np.array([log(self.of_kind(candidate)) for candidate, _ in own])
            for width, own in self.by_width.items()
        }

    def of_kind(self, effect: Effect) -> int:
        """Return the number of candidates of the kind of an effect, those in other sets included; zero if there is none here."""
        here = self._of_kind[effect.name]
        return here + self.elsewhere if here else 0

    @cached_property
    def _of_kind(self) -> Counter[str]:
        return Counter(candidate.name for candidate, _ in self.tried)

    @cached_property
    def of_several_terms(self) -> dict[int, list[int]]:
        """Return the indices in ``by_width`` of the candidates that consist of several terms."""
        return {
            width: [k for k, (candidate, _) in enumerate(own) if candidate.n_terms > 1]
            for width, own in self.by_width.items()
        }

    @cached_property
    def groups(self) -> dict[int, Array]:
        """Return the indices ``(T, w)`` of the columns of the T candidates of each width w, in the order of ``by_width``."""
        return {width: np.array([where for _, where in own]) for width, own in self.by_width.items()}

    @cached_property
    def total(self) -> int:
        """Return the number of all candidates, a change counted once for each pose that it touches."""
        return len(self.tried) + self.elsewhere + sum(int(touched.sum()) for _, touched in self.changes)


def named_candidates(dataset: Dataset) -> CandidateSet:
    """Return the candidate set of all named effects and changes of a dataset."""
    return CandidateSet.of(candidates(dataset), changes(dataset))


@dataclass(frozen=True, eq=False)
class Conditional:
    """The T candidates with w columns each, conditional on a background.

    Attributes:
        variance: Variance of the residual.
        grams: ``(T, w, w)``, ``E'^T E'`` of each candidate, in the units of ``Projected``.
        projections: ``(T, w)``, ``E'^T r`` in the same units.
        share: ``(T, w)``, ``|E'|^2 / |E|^2`` of each column.
    """

    variance: float
    grams: Array
    projections: Array
    share: Array

    def score(self) -> tuple[Array, Array, Array]:
        """Return gain, degrees of freedom and observability of each candidate, ``(T,)`` each."""
        gain, dof = shrunk_gain(self.grams, self.projections)
        return self.variance * gain, dof, np.sqrt(self.share.max(axis=1, initial=0.0))

    def of(self, k: int) -> Projected:
        """Return the columns of candidate k alone."""
        return Projected(self.variance, self.grams[k], self.projections[k], self.share[k])


class CandidateColumns:
    """The whitened columns of a candidate set at a state's model, and the products from which scores follow without another pass over the rows.

    Products are computed only of columns of the same candidate.

    Attributes:
        candidates: The candidate set.
        change_margin: Least number of poses before and after the beginning of a change.
        full: The background of the state with all its effects, or of a model that stands for it (``given``).
        products: The e columns of the elements.
        of_changes: ``(N m, c)``, the columns of the changes.
    """

    def __init__(self, state: FittedState, candidates: CandidateSet) -> None:
        """Compute the columns of a candidate set at a fitted state."""
        self.candidates = candidates
        self.change_margin = state.settings.selection.change_margin
        groups = candidates.groups.values()
        self.products = state.products_of(candidates.elements, groups, candidates.bases)
        self.of_changes = state.columns_of([effect for effect, _ in candidates.changes], candidates.bases)
        self._own_grams: dict[int, Array] = {}  # of the columns as they are, whatever the background
        self._condition_on(state.background())

    def given(self, full: Background) -> CandidateColumns:
        """Return the same columns for another model at the state's optimum, whose background then stands for the state's own.

        Args:
            full: The background of the model, which may have other columns than the state.
        """
        found = copy(self)
        found._condition_on(full)
        return found

    def _condition_on(self, full: Background) -> None:
        """Take a background with all effects, and the products with it from which others follow."""
        self.full = full
        along = self.products.with_rows(full.as_rows())
        self._along, self._projection = along[:, :-1], along[:, -1]
        self._given_all = self.products.squared_lengths - np.einsum("ef,ef->e", self._along, self._along)
        self._change_columns: dict[int, ChangeColumns] = {}
        self._grams: dict[int, Array] = {}

    @classmethod
    def of(cls, state: FittedState, candidates: CandidateSet) -> CandidateColumns:
        """Return the columns of a candidate set at a state's model; they are computed once for a state unless they are too large to be kept."""
        known = state.candidate_columns.get(id(candidates))
        if known is None:
            known = cls(state, candidates)
            kept = sum(columns.nbytes for columns in state.candidate_columns.values())
            if kept + known.nbytes <= _MOST_KEPT:
                state.candidate_columns[id(candidates)] = known  # holds the set, so no other has its id
        return known

    @property
    def nbytes(self) -> int:
        """Return the size of the columns in memory [bytes]."""
        return self.products.nbytes + self.of_changes.nbytes

    def conditional(self, background: Background) -> dict[int, Conditional]:
        """Return the candidates by their number of columns, conditional on the state's background, or on that without some of its effects."""
        squared_lengths = self.products.squared_lengths
        projection, released = self._with_background(background)
        given = self._given_all
        if released is not None:
            given = given + np.einsum("ef,ef->e", released, released)
        prior_std = self.candidates.prior_std[: len(squared_lengths)]
        share, scale = observable_share(background, given, squared_lengths, prior_std)
        projection = projection * scale / background.variance
        found = {}
        for width, groups in self.candidates.groups.items():
            grams = self._grams_given_all(width)
            if released is not None:
                left = released[groups]
                grams = grams + left @ np.swapaxes(left, 1, 2)
            units = scale[groups]
            grams = grams * (units[:, :, None] * units[:, None, :]) / background.variance
            found[width] = Conditional(background.variance, grams, projection[groups], share[groups])
        return found

    def _with_background(self, background: Background) -> tuple[Array, Array | None]:
        """Return the products of the columns with the residual of a background ``(e,)``, and with the directions that it released ``(e, w)``.

        Products with the state's own background, or with one that follows from it, need no further pass over the rows.
        """
        if background is self.full:
            return self._projection, None
        if background.left_out is None or background.left_out.whole is not self.full:
            released = background.released
            residual = background.residual.reshape(-1, 1)
            rows = residual if released is None else np.column_stack([residual, released])
            along = self.products.with_rows(Rows(rows))
            return along[:, 0], None if released is None else along[:, 1:]
        released = self._along @ background.left_out.freed
        return self._projection + released @ background.left_out.gained, released

    def _grams_given_all(self, width: int) -> Array:
        """Return ``E'^T E'`` ``(T, w, w)`` of the candidates with w columns, conditional on the background of the state with all its effects."""
        if width not in self._grams:
            groups = self.candidates.groups[width]
            if width not in self._own_grams:
                self._own_grams[width] = self.products.grams(groups)
            along = self._along[groups]
            self._grams[width] = self._own_grams[width] - along @ np.swapaxes(along, 1, 2)
        return self._grams[width]

    def changes(self, background: Background) -> list[tuple[Effect, ChangeScores]]:
        """Return every kind of change with its scores for all poses at which it may begin."""
        N, m = background.residual.shape
        found = []
        at = 0
        for i, (effect, touched) in enumerate(self.candidates.changes):
            k = len(effect.coefficients)
            E = self.of_changes[:, at : at + k].reshape(N, m, k)
            at += k
            if i not in self._change_columns:
                self._change_columns[i] = ChangeColumns.of(
                    self.full, E, np.flatnonzero(touched), self.change_margin
                )
            found.append((effect, self._change_columns[i].score(background, E, effect.prior_std)))
        return found
