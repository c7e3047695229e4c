"""Beam search for the set of elements with the most evidence; it uses only the inner products of their columns, not the rows themselves.

The best few sets of each size are extended by the elements that explain most given the set. All sets of one size are computed at once. The
elements of one *family* are the same change at different poses; any other element is a family of its own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy import linalg

from scalar.diagnosis.score_test import shrunk_gain
from scalar.geometry.se3 import Array

# The extent of the search: larger numbers give the same sets, more slowly.
WIDTH = 24  # sets of each size that are extended
BRANCHES = 8  # elements with which each of these sets is extended, at most one of each family
MOST_ELEMENTS = 14  # in a set: five effects with two or three elements each


@dataclass(frozen=True)
class Subset:
    """A set of elements.

    Attributes:
        elements: Their indices, ascending.
        squared: Squared residual of the fit with these elements, the penalty of the coefficients' priors included [noise variances].
        evidence: Log evidence of the set [nats].
    """

    elements: tuple[int, ...]
    squared: float
    evidence: float


@dataclass(frozen=True, eq=False)
class SearchElements:
    """The elements from which sets are built, and the products of their columns, in units of the prior standard deviations and the noise.

    An element is an element of the candidate set, or a change that begins at a certain pose.

    Attributes:
        columns: The indices ``(w,)`` of the columns of each element.
        family: The family of each element; only the best element of a family extends a set.
        gram: ``(e, e)``, inner products of all columns conditional on the state's model.
        projection: ``(e,)``, inner products of the columns with the state's residual.
        squared: Squared residual of the state [noise variances].
        freedom: Degrees of freedom of that residual.
        n_candidates: Number of candidates.
        least_variance: Least variance of the residual that any set is assumed to leave [noise variances].
    """

    columns: Sequence[Array]
    family: Array
    gram: Array
    projection: Array
    squared: float
    freedom: int
    n_candidates: int
    least_variance: float

    def best(self) -> tuple[int, ...]:
        """Return the elements of the set with the most evidence."""
        beam = self.subsets([()])
        best = beam[0]
        for _ in range(MOST_ELEMENTS):
            extended = {more: None for found in self.extensions(beam, BRANCHES) for more in found}
            if not extended:
                break
            beam = sorted(self.subsets(list(extended)), key=lambda s: -s.evidence)[:WIDTH]
            best = max(best, beam[0], key=lambda s: s.evidence)
        return self.exchanged(best).elements

    def exchanged(self, subset: Subset) -> Subset:
        """Return the set improved until neither leaving out nor exchanging one of its elements gives more evidence."""
        while True:  # each exchange adds evidence
            fewer = self.subsets(
                [tuple(p for p in subset.elements if p != element) for element in subset.elements]
            )
            others = self.subsets([more for found in self.extensions(fewer, BRANCHES) for more in found])
            best = max([subset, *fewer, *others], key=lambda s: s.evidence)
            if best is subset:
                return subset
            subset = best

    def subsets(self, several: Sequence[tuple[int, ...]]) -> list[Subset]:
        """Return each set with its squared residual and evidence; sets with the same number of columns are computed at once."""
        where = [self._where(elements) for elements in several]
        found: dict[int, Subset] = {}
        for width in {len(columns) for columns in where}:
            members = [k for k, columns in enumerate(where) if len(columns) == width]
            columns = np.array([where[k] for k in members])
            values, vectors = np.linalg.eigh(self.gram[columns[:, :, None], columns[:, None, :]])
            along = np.einsum("tei,te->ti", vectors, self.projection[columns])
            gains = np.sum(along**2 / (1.0 + np.maximum(values, 0.0)), axis=1)
            squared = self.squared - gains
            evidence = self._log_evidence(squared, np.sum(values > 1.0, axis=1))
            for k, rest, nats in zip(members, squared.tolist(), evidence.tolist(), strict=True):
                cost_of_choice = len(several[k]) * float(np.log(self.n_candidates))
                found[k] = Subset(several[k], rest, nats - cost_of_choice)
        return [found[k] for k in range(len(several))]

    def extensions(self, subsets: Sequence[Subset], most: int) -> list[list[tuple[int, ...]]]:
        """Return for each set the sets with one more element that have the most evidence, at most one for each family, best first."""
        if not subsets:
            return []
        given = [self._given(subset) for subset in subsets]
        squared = np.array([subset.squared for subset in subsets])[:, None]
        evidence = np.full((len(subsets), len(self.columns)), -np.inf)
        for k, (members, _) in enumerate(self._by_width):
            grams, projections = (
                np.concatenate([one[k] for one in some]) for some in zip(*given, strict=True)
            )
            gains, dofs = (x.reshape(len(subsets), -1) for x in shrunk_gain(grams, projections))
            evidence[:, members] = np.where(gains > 0.0, self._log_evidence(squared - gains, dofs), -np.inf)
        return [
            self._first_of_families(own, subset.elements, most)
            for own, subset in zip(evidence, subsets, strict=True)
        ]

    def _given(self, subset: Subset) -> tuple[list[Array], list[Array]]:
        """Return the inner products ``(T, w, w)`` and projections ``(T, w)`` of the T elements of each width w, conditional on a set."""
        where = self._where(subset.elements)
        factor = linalg.cholesky(self.gram[np.ix_(where, where)] + np.eye(len(where)), lower=True)
        rows = np.column_stack([self.gram[where], self.projection[where]])
        across = linalg.solve_triangular(factor, rows, lower=True)
        shared, projection = across[:, :-1], self.projection - across[:, :-1].T @ across[:, -1]
        grams, projections = [], []
        for (_, places), own in zip(self._by_width, self._blocks, strict=True):
            B = shared[:, places]
            grams.append(own - np.einsum("atw,atv->twv", B, B))
            projections.append(projection[places])
        return grams, projections

    def _first_of_families(
        self, evidence: Array, elements: tuple[int, ...], most: int
    ) -> list[tuple[int, ...]]:
        """Return the sets with one further element of the most evidence ``(T,)``, at most one for each family, best first."""
        evidence[list(elements)] = -np.inf
        found: dict[int, tuple[int, ...]] = {}
        for k in np.argsort(-evidence, kind="stable"):
            if evidence[k] == -np.inf or len(found) == most:
                break
            found.setdefault(int(self.family[k]), tuple(sorted((*elements, int(k)))))
        return list(found.values())

    @cached_property
    def _by_width(self) -> list[tuple[list[int], Array]]:
        """Return the indices of the T elements of each width, and the indices of their columns ``(T, w)``."""
        widths = sorted({len(where) for where in self.columns})
        members = [[k for k, where in enumerate(self.columns) if len(where) == width] for width in widths]
        return [(some, np.array([self.columns[k] for k in some])) for some in members]

    @cached_property
    def _blocks(self) -> list[Array]:
        """Return the inner products ``(T, w, w)`` of the columns of the elements of each width."""
        return [self.gram[places[:, :, None], places[:, None, :]] for _, places in self._by_width]

    def _where(self, elements: tuple[int, ...]) -> Array:
        return np.concatenate([np.zeros(0, dtype=int), *(self.columns[p] for p in elements)])

    def _log_evidence(self, squared: Any, dof: Any) -> Any:
        """Return the log evidence [nats] by the Bayesian information criterion, not yet reduced for the number of candidates."""
        n = self.freedom
        return -0.5 * n * np.log(np.maximum(squared / n, self.least_variance)) - 0.5 * dof * np.log(n)
