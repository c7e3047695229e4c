"""Sets of pieces with much evidence, by a beam search over products of their columns: no pass over the rows.

The best few sets of every size are extended by the pieces that explain most beside them; the sets of a size are worked out together.
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

# How far the search goes: with larger numbers it finds the same, more slowly.
WIDTH = 24  # sets of each size that are extended
BRANCHES = 8  # pieces by which each of them is extended, one of a family
MOST_PIECES = 14  # of a set: five effects with two or three pieces each


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
        columns: Of each piece ``(w,)``, indices.
        family: Of each piece; of a family only the best member extends a set.
        gram: ``(e, e)``, of all columns given the state.
        projection: ``(e,)``, of its residual onto them.
        squared: Of its residual [noise variances].
        freedom: Its degrees of freedom.
        tried: How many candidates there are.
        least: Of the noise's variance, what any set is taken to leave.
    """

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
        beam = self.subsets([()])
        best = beam[0]
        for _ in range(MOST_PIECES):
            extended = {more: None for found in self.extensions(beam, BRANCHES) for more in found}
            if not extended:
                break
            beam = sorted(self.subsets(list(extended)), key=lambda s: -s.evidence)[:WIDTH]
            best = max(best, beam[0], key=lambda s: s.evidence)
        return self.exchanged(best).pieces

    def exchanged(self, subset: Subset) -> Subset:
        """Return a set that is not the better for leaving out one of its pieces, nor for exchanging one."""
        while True:  # each exchange adds evidence
            fewer = self.subsets([tuple(p for p in subset.pieces if p != piece) for piece in subset.pieces])
            others = self.subsets([more for found in self.extensions(fewer, BRANCHES) for more in found])
            best = max([subset, *fewer, *others], key=lambda s: s.evidence)
            if best is subset:
                return subset
            subset = best

    def subsets(self, several: Sequence[tuple[int, ...]]) -> list[Subset]:
        """Return sets with their evidence; those with the same number of columns at once."""
        where = [self._where(pieces) for pieces in several]
        found: dict[int, Subset] = {}
        for width in {len(columns) for columns in where}:
            members = [k for k, columns in enumerate(where) if len(columns) == width]
            columns = np.array([where[k] for k in members])
            values, vectors = np.linalg.eigh(self.gram[columns[:, :, None], columns[:, None, :]])
            along = np.einsum("tei,te->ti", vectors, self.projection[columns])
            gains = np.sum(along**2 / (1.0 + np.maximum(values, 0.0)), axis=1)
            squared = self.squared - gains
            worth = self._worth(squared, np.sum(values > 1.0, axis=1))
            for k, rest, nats in zip(members, squared.tolist(), worth.tolist(), strict=True):
                choice = len(several[k]) * float(np.log(self.tried))
                found[k] = Subset(several[k], rest, nats - choice)
        return [found[k] for k in range(len(several))]

    def extensions(self, subsets: Sequence[Subset], most: int) -> list[list[tuple[int, ...]]]:
        """Return for each set those with one more piece that explain most, one for each family, best first."""
        if not subsets:
            return []
        given = [self._given(subset) for subset in subsets]
        squared = np.array([subset.squared for subset in subsets])[:, None]
        worth = np.full((len(subsets), len(self.columns)), -np.inf)
        for k, (members, _) in enumerate(self._by_width):
            grams, projections = (
                np.concatenate([one[k] for one in some]) for some in zip(*given, strict=True)
            )
            gains, dofs = (x.reshape(len(subsets), -1) for x in shrunk_gain(grams, projections))
            worth[:, members] = np.where(gains > 0.0, self._worth(squared - gains, dofs), -np.inf)
        return [
            self._first_of_families(own, subset.pieces, most)
            for own, subset in zip(worth, subsets, strict=True)
        ]

    def _given(self, subset: Subset) -> tuple[list[Array], list[Array]]:
        """Return grams ``(T, w, w)`` and projections ``(T, w)`` of all pieces given a set, for each number of columns w."""
        where = self._where(subset.pieces)
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

    def _first_of_families(self, worth: Array, pieces: tuple[int, ...], most: int) -> list[tuple[int, ...]]:
        """Return a set with the best further pieces ``(T,)``, one of a family."""
        worth[list(pieces)] = -np.inf
        found: dict[int, tuple[int, ...]] = {}
        for k in np.argsort(-worth, kind="stable"):
            if worth[k] == -np.inf or len(found) == most:
                break
            found.setdefault(int(self.family[k]), tuple(sorted((*pieces, int(k)))))
        return list(found.values())

    @cached_property
    def _by_width(self) -> list[tuple[list[int], Array]]:
        """Return the pieces by their number of columns, with these ``(T, w)``."""
        widths = sorted({len(where) for where in self.columns})
        members = [[k for k, where in enumerate(self.columns) if len(where) == width] for width in widths]
        return [(some, np.array([self.columns[k] for k in some])) for some in members]

    @cached_property
    def _blocks(self) -> list[Array]:
        """Return the grams ``(T, w, w)`` of the pieces, by the number of columns."""
        return [self.gram[places[:, :, None], places[:, None, :]] for _, places in self._by_width]

    def _where(self, pieces: tuple[int, ...]) -> Array:
        return np.concatenate([np.zeros(0, dtype=int), *(self.columns[p] for p in pieces)])

    def _worth(self, squared: Any, dof: Any) -> Any:
        """Return fit less complexity [nats]: the log evidence but for how many were tried."""
        n = self.freedom
        return -0.5 * n * np.log(np.maximum(squared / n, self.least)) - 0.5 * dof * np.log(n)
