"""Inner products of columns of which many are one column from some pose on: changes of one kind that begin at different poses.

The product of two such columns is a sum over the poses from the later of both beginnings on. These sums are cumulative: with the products of the
poses between successive beginnings, added up from the last pose to the first, those for all beginnings cost hardly more than those for one.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from scalar.geometry.se3 import Array


@dataclass(frozen=True, eq=False)
class OnsetColumns:
    """Columns, each of which is one of S given ones from a pose on and zero before that pose.

    Attributes:
        given: ``(N m, S)``, the given columns of N poses with m rows each.
        rows_per_pose: m.
    """

    given: Array
    rows_per_pose: int

    @cached_property
    def products(self) -> Array:
        """Return the inner products ``(S, S)`` of the given columns over all poses."""
        return self.given.T @ self.given

    def columns(self, source: Array, onset: Array) -> Array:
        """Return the columns ``(N m, e)`` that are those with the indices ``source`` ``(e,)`` from the poses ``onset`` ``(e,)`` on."""
        pose = np.arange(len(self.given)) // self.rows_per_pose
        return np.where(pose[:, None] >= onset, self.given[:, source], 0.0)

    def grams(self, steady: Array, source: Array, onset: Array) -> Array:
        """Return the inner products ``(s + c, s + c)`` of s given columns as they are, followed by c columns that begin at some pose.

        Args:
            steady: ``(s,)``, indices of the former.
            source: ``(c,)``, indices of the given columns that the latter are from their beginning on.
            onset: ``(c,)``, indices of the poses with which they begin.
        """
        s, e = len(steady), len(steady) + len(source)
        gram = np.empty((e, e))
        gram[:s, :s] = self.products.take(steady, axis=0).take(steady, axis=1)
        moving, place = np.unique(source, return_inverse=True)
        onsets, at = np.unique(onset, return_inverse=True)
        # Of each change the products with all given columns from its own beginning on, which decides unless the other column begins later.
        since = self._products_since(onsets, moving)[at, place]
        gram[s:, :s] = since.take(steady, axis=1)
        gram[:s, s:] = gram[s:, :s].T
        both = since.take(source, axis=1)
        gram[s:, s:] = both
        np.copyto(gram[s:, s:], both.T, where=onset[:, None] < onset)
        return gram

    def _products_since(self, onsets: Array, moving: Array) -> Array:
        """Return the inner products ``(T, M, S)`` of the M columns with the indices ``moving`` with all given ones, over the poses from each of the
        T poses ``onsets``, in ascending order, on.
        """
        found = np.zeros((len(onsets) + 1, len(moving), self.given.shape[1]))
        ends = [*onsets.tolist(), len(self.given) // self.rows_per_pose]
        for k in reversed(range(len(onsets))):
            rows = self.given[ends[k] * self.rows_per_pose : ends[k + 1] * self.rows_per_pose]
            np.add(found[k + 1], rows[:, moving].T @ rows, out=found[k])
        return found[:-1]
