"""Beam search for the set of elements with the most evidence; it uses only the inner products of their columns, not the rows themselves.

The best few sets of each size are extended by the elements that explain most given the set. All sets of one size are computed in one array
operation. The elements of one *family* are the same change at different poses; any other element is a family of its own. Coefficients are in units
of their prior standard deviations and rows in units of the noise, so a prior adds the identity to the normal equations. An eigenvalue of the inner
products above 1 then means that the data determine that direction better than its prior does.
"""

from __future__ import annotations

from bisect import bisect
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from scipy import linalg

from scalar.diagnosis.scoring.score_test import shrunk_gain
from scalar.geometry.se3 import Array
from scalar.kernels.gains import best_extensions, extension_gains, set_gains

# The extent of the search: larger numbers give the same sets, more slowly.
WIDTH = 24  # sets of each size that are extended
BRANCHES = 8  # elements with which each of these sets is extended, at most one of each family
MOST_ELEMENTS = 14  # elements of a set at most: five effects with two or three elements each


class Subset(NamedTuple):
    """A set of elements.

    Attributes:
        elements: Their indices, ascending.
        sum_of_squares: Squared residual of the fit with these elements, the penalty of the coefficients' priors included [noise variances].
        evidence: Log evidence of the set [nats].
    """

    elements: tuple[int, ...]
    sum_of_squares: float
    evidence: float


@dataclass(frozen=True, eq=False)
class SearchElements:
    """The elements from which sets are built, and the inner products of their columns, in units of the prior standard deviations and of the noise.

    An element is an element of the candidate set, or a change that begins at a certain pose.

    Attributes:
        columns: The indices ``(w,)`` of the columns of each element.
        family: ``(n,)``, the family of each of the n elements, in ascending order; only the best element of a family extends a set.
        gram: ``(e, e)``, inner products of all e columns, conditional on the model without effects.
        projection: ``(e,)``, inner products of the columns with the residual of that model.
        sum_of_squares: Sum of squares of that residual [noise variances].
        degrees_of_freedom: Degrees of freedom of that residual.
        n_candidates: Number of candidates among which each element is chosen; its logarithm is subtracted from the evidence for each element.
        least_variance: Least variance of the residual that any set is assumed to leave [noise variances].
        largest: ``(e,)``, largest plausible coefficient of each column [prior standard deviations], infinite for those without a prior.
        excluded: Indices of elements that no set may have.
    """

    columns: Sequence[Array]
    family: Array
    gram: Array
    projection: Array
    sum_of_squares: float
    degrees_of_freedom: float
    n_candidates: int
    least_variance: float
    largest: Array
    excluded: frozenset[int] = frozenset()

    def best(self) -> tuple[int, ...]:
        """Return the indices of the elements of the plausible set with the most evidence, ascending; empty if no element adds evidence.

        A set is plausible if all its coefficients are. Large effects that are missing may be imitated by an implausibly large coefficient: a range
        scale of -1 shrinks all scans to a point, and leaves no residual whatever its cause. Elements with such coefficients are therefore excluded,
        and the search is repeated.
        """
        search = self
        while True:
            found = search._best_of_all()
            implausible = search._implausible(found)
            if not implausible:
                return found
            search = replace(search, excluded=search.excluded | implausible)

    def _implausible(self, elements: tuple[int, ...]) -> frozenset[int]:
        """Return those elements of a set that have an implausibly large coefficient."""
        where = self._where(elements)
        gram = self.gram[np.ix_(where, where)] + np.eye(len(where))
        coefficients = (
            dict(
                zip(
                    where.tolist(),
                    linalg.solve(gram, self.projection[where], assume_a="pos").tolist(),
                    strict=True,
                )
            )
            if len(where)
            else {}
        )
        return frozenset(
            p for p in elements if any(abs(coefficients[k]) > self.largest[k] for k in self.columns[p])
        )

    def _best_of_all(self) -> tuple[int, ...]:
        """Return the indices of the elements of the set with the most evidence, ascending, whether plausible or not."""
        beam = self.subsets([()])
        best = beam[0]
        for _ in range(MOST_ELEMENTS):
            # A dict keeps each set once, in a fixed order.
            extended = {larger: None for of_one in self.extensions(beam, BRANCHES) for larger in of_one}
            if not extended:
                break
            beam = sorted(self.subsets(list(extended)), key=lambda s: -s.evidence)[:WIDTH]
            best = max(best, beam[0], key=lambda s: s.evidence)
        return self.exchanged(best).elements

    def exchanged(self, subset: Subset) -> Subset:
        """Return the set improved until neither leaving out nor exchanging one of its elements gives more evidence."""
        while True:  # it ends, because each step adds evidence and the number of sets is finite
            fewer = self.subsets(
                [tuple(p for p in subset.elements if p != element) for element in subset.elements]
            )
            exchanges = self.subsets(
                [same_size for of_one in self.extensions(fewer, BRANCHES) for same_size in of_one]
            )
            best = max([subset, *fewer, *exchanges], key=lambda s: s.evidence)
            if best is subset:
                return subset
            subset = best

    def subsets(self, sets: Sequence[tuple[int, ...]]) -> list[Subset]:
        """Return each set with its squared residual and evidence, in the order given; sets with the same number of columns are computed together."""
        places, cost_of_choice = self._places, float(np.log(self.n_candidates))
        by_width: dict[int, list[tuple[int, list[int]]]] = {}
        for k, elements in enumerate(sets):
            columns = [c for p in elements for c in places[p]]
            by_width.setdefault(len(columns), []).append((k, columns))
        found: dict[int, Subset] = {}
        for width, same_width in by_width.items():
            where = np.array([columns for _, columns in same_width], dtype=int).reshape(
                len(same_width), width
            )
            gains, dofs = self._gains(where)
            sum_of_squares = self.sum_of_squares - gains
            evidence = self._log_evidence(sum_of_squares, dofs)
            for (k, _), remaining, nats in zip(
                same_width, sum_of_squares.tolist(), evidence.tolist(), strict=True
            ):
                found[k] = Subset(sets[k], remaining, nats - len(sets[k]) * cost_of_choice)
        return [found[k] for k in range(len(sets))]

    def extensions(self, subsets: Sequence[Subset], most: int) -> list[list[tuple[int, ...]]]:
        """Return for each set the sets with one more element that have the most evidence, best first.

        Args:
            subsets: The sets to extend.
            most: Largest number of extensions of each set, at most one for each family.
        """
        if not subsets:
            return []
        gains, dofs = self._gains_given(subsets)
        for of_set, subset in zip(gains, subsets, strict=True):
            of_set[[*subset.elements, *self.excluded]] = 0.0
        best = self._best_of_families(subsets, gains, dofs, most)
        return [
            [_with(subset.elements, k) for k in of_set] for of_set, subset in zip(best, subsets, strict=True)
        ]

    def _gains(self, columns: Array) -> tuple[Array, Array]:
        """Return the gains ``(T,)`` of T sets of columns with these indices ``(T, s)``, and the numbers of eigenvalues above 1 ``(T,)``."""
        compiled = set_gains(self.gram, self.projection, columns)
        if compiled is not None:
            return compiled
        values, vectors = np.linalg.eigh(self.gram[columns[:, :, None], columns[:, None, :]])
        along = np.einsum("tei,te->ti", vectors, self.projection[columns])
        return np.sum(along**2 / (1.0 + np.maximum(values, 0.0)), axis=1), np.sum(values > 1.0, axis=1)

    def _gains_given(self, subsets: Sequence[Subset]) -> tuple[Array, Array]:
        """Return gains and degrees of freedom of all n elements conditional on each of T sets, ``(T, n)`` each."""
        if self._ranges is not None:
            paths = _sharing_beginnings([subset.elements for subset in subsets])
            where = [self._where(path) for path in sorted(paths)]
            compiled = extension_gains(self.gram, self.projection, where, *self._ranges)
            if compiled is not None:
                back = np.argsort(sorted(range(len(paths)), key=paths.__getitem__))
                return compiled[0][back], compiled[1][back]
        given = [self._given(subset) for subset in subsets]
        gains, dofs = (np.zeros((len(subsets), len(self.columns))) for _ in range(2))
        for k, (members, _) in enumerate(self._by_width):
            grams, projections = (
                np.concatenate([of_set[k] for of_set in of_all_sets])
                for of_all_sets in zip(*given, strict=True)
            )
            gains[:, members], dofs[:, members] = (
                x.reshape(len(subsets), -1) for x in shrunk_gain(grams, projections)
            )
        return gains, dofs

    def _given(self, subset: Subset) -> tuple[list[Array], list[Array]]:
        """Return the inner products ``(T, w, w)`` and projections ``(T, w)`` of the T elements of each width w, conditional on a set."""
        where = self._where(subset.elements)
        # Elimination of the set's columns by the Cholesky factor of their gram plus the identity, which is that of their priors.
        factor = linalg.cholesky(self.gram[np.ix_(where, where)] + np.eye(len(where)), lower=True)
        rows = np.column_stack([self.gram[where], self.projection[where]])
        solved = linalg.solve_triangular(factor, rows, lower=True)
        shared, projection = solved[:, :-1], self.projection - solved[:, :-1].T @ solved[:, -1]
        grams, projections = [], []
        for (_, places), unconditional in zip(self._by_width, self._grams, strict=True):
            B = shared[:, places]
            grams.append(unconditional - np.einsum("atw,atv->twv", B, B))
            projections.append(projection[places])
        return grams, projections

    def _best_of_families(
        self, subsets: Sequence[Subset], gains: Array, dofs: Array, most: int
    ) -> list[list[int]]:
        """Return for each of T sets the elements that give most evidence with it, best first: the best of each family, at most ``most``.

        Gains conditional on each set ``(T, n)`` have degrees of freedom ``dofs`` ``(T, n)``; elements that no set may have gain nothing.
        """
        begins, n = self._families, self.degrees_of_freedom
        most = min(most, len(begins) - 1)
        sum_of_squares = np.array([subset.sum_of_squares for subset in subsets])
        compiled = best_extensions(
            gains, dofs, sum_of_squares, n * self.least_variance, float(np.log(n)) / n, begins, most
        )
        if compiled is not None:
            return compiled
        evidence = np.where(gains > 0.0, self._log_evidence(sum_of_squares[:, None] - gains, dofs), -np.inf)
        of_family = np.maximum.reduceat(evidence, begins[:-1], axis=1)
        leading = np.argsort(-of_family, axis=1, kind="stable")[:, :most]
        found = []
        for families, every, of_elements in zip(leading.tolist(), of_family, evidence, strict=True):
            in_order = [f for f in families if every[f] > -np.inf]
            found.append(
                [begins[f] + int(np.argmax(of_elements[begins[f] : begins[f + 1]])) for f in in_order]
            )
        return found

    @cached_property
    def _families(self) -> list[int]:
        """Return the first element of each family, and the number of all elements."""
        begins = np.flatnonzero(np.diff(self.family, prepend=self.family[0] - 1))
        return [*begins.tolist(), len(self.family)]

    @cached_property
    def _ranges(self) -> tuple[Array, Array] | None:
        """Return the first column and the number of columns of each element, ``(n,)`` each; None unless each one's columns follow one another."""
        first, width = (np.array([of(where) for where in self.columns], dtype=np.int64) for of in (min, len))
        in_order = all(
            np.array_equal(where, np.arange(where[0], where[0] + len(where))) for where in self.columns
        )
        return (first, width) if in_order else None

    @cached_property
    def _by_width(self) -> list[tuple[list[int], Array]]:
        """Return the indices of the T elements of each width, and the indices of their columns ``(T, w)``."""
        widths = sorted({len(where) for where in self.columns})
        members = [[k for k, where in enumerate(self.columns) if len(where) == width] for width in widths]
        return [(same_width, np.array([self.columns[k] for k in same_width])) for same_width in members]

    @cached_property
    def _grams(self) -> list[Array]:
        """Return the inner products ``(T, w, w)`` of the columns of the elements of each width."""
        return [self.gram[places[:, :, None], places[:, None, :]] for _, places in self._by_width]

    def _where(self, elements: tuple[int, ...]) -> Array:
        """Return the indices of the columns of some elements."""
        return np.array([k for p in elements for k in self._places[p]], dtype=int)

    @cached_property
    def _places(self) -> list[list[int]]:
        """Return the indices of the columns of each element as plain numbers, of which those of a set are gathered in a fifth of the time."""
        return [where.tolist() for where in self.columns]

    def _log_evidence(self, sum_of_squares: Any, dof: Any) -> Any:
        """Return the log evidence [nats] by the Bayesian information criterion, without the penalty for the number of candidates.

        Args:
            sum_of_squares: Sum of squares of residuals [noise variances], any shape.
            dof: Numbers of directions that the data determine better than the priors, of the same shape.
        """
        n = self.degrees_of_freedom
        return -0.5 * n * np.log(np.maximum(sum_of_squares / n, self.least_variance)) - 0.5 * dof * np.log(n)


def _with(elements: tuple[int, ...], k: int) -> tuple[int, ...]:
    """Return ascending elements with one more."""
    return (*elements[: (at := bisect(elements, k))], k, *elements[at:])


def _sharing_beginnings(sets: Sequence[tuple[int, ...]]) -> list[tuple[int, ...]]:
    """Return each set with those of its elements first that are in most of the sets, so that many sets begin with the same elements."""
    n_sets = Counter(p for elements in sets for p in elements)
    return [tuple(sorted(elements, key=lambda p: (-n_sets[p], p))) for elements in sets]
