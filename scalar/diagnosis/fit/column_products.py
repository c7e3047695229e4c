"""The columns of candidates at a fitted model, and their inner products, without forming the columns of effects on one joint.

The column of an error of one joint is ``b_n d_n`` at pose n: the error there times the derivative ``d_n (m,)`` of the pose's rows by the joint. With
the length l_n and the direction u_n of d_n, the inner products of columns of one joint are those of ``l_n b_n``, N numbers instead of N m, and the
inner product of a column with rows r_n is that of ``l_n b_n`` with ``u_n . r_n``.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from scalar.geometry.se3 import Array

_MOST_NUMBERS = 2_000_000  # numbers of columns that are copied at once for their products: 16 MB


class Rows:
    """Rows ``(N m, f)`` with which columns are multiplied, and their components along directions.

    Attributes:
        values: The rows.
        keep: Whether components are computed once for each array of directions and kept.
    """

    def __init__(self, values: Array, *, keep: bool = False) -> None:
        """Begin without any components."""
        self.values, self.keep = values, keep
        self._along: dict[int, tuple[Array, Array]] = {}

    def along(self, directions: Array) -> Array:
        """Return the components ``(N, f)`` along directions ``(N, m)``, one for each pose."""
        if id(directions) in self._along:
            return self._along[id(directions)][1]
        N, m = directions.shape
        found = (directions[:, None, :] @ self.values.reshape(N, m, -1))[:, 0]
        if self.keep:
            self._along[id(directions)] = directions, found  # held, so that no others have their id
        return found


@dataclass(frozen=True, eq=False)
class ColumnBlock:
    """Columns of one joint, or any others.

    Attributes:
        at: ``(k,)``, indices of the columns.
        rows: ``(k, N)``, the numbers ``l_n b_n`` of each column; of the others ``(k, N m)``, the columns themselves.
        directions: ``(N, m)``, u_n; None for the others.
    """

    at: Array
    rows: Array
    directions: Array | None

    def products_with(self, rows: Rows) -> Array:
        """Return the inner products ``(k, f)`` with rows ``(N m, f)``."""
        return self.rows @ (rows.values if self.directions is None else rows.along(self.directions))


class ColumnProducts:
    """Columns in blocks, and their inner products with one another and with any rows.

    Attributes:
        blocks: Each column is in one of them.
        squared_lengths: ``(e,)``, of the columns.
    """

    def __init__(self, blocks: Sequence[ColumnBlock]) -> None:
        """Take the blocks of e columns."""
        self.blocks = blocks
        e = sum(len(block.at) for block in blocks)
        self.squared_lengths = np.zeros(e)
        self._block, self._place = np.zeros((2, e), dtype=int)
        for k, block in enumerate(blocks):
            self.squared_lengths[block.at] = np.einsum("kn,kn->k", block.rows, block.rows)
            self._block[block.at], self._place[block.at] = k, np.arange(len(block.at))

    @property
    def nbytes(self) -> int:
        """Return the size of the columns in memory [bytes]."""
        return sum(block.rows.nbytes for block in self.blocks)

    def with_rows(self, rows: Rows) -> Array:
        """Return the inner products ``(e, f)`` of the columns with rows ``(N m, f)``."""
        found = np.zeros((len(self.squared_lengths), rows.values.shape[1]))
        for block in self.blocks:
            found[block.at] = block.products_with(rows)
        return found

    def grams(self, groups: Array) -> Array:
        """Return the inner products ``(T, w, w)`` within T groups of w columns with the indices ``groups`` ``(T, w)``, each group of one block."""
        T, width = groups.shape
        if width == 1:
            return self.squared_lengths[groups][:, :, None]
        found = np.zeros((T, width, width))
        for k, block in enumerate(self.blocks):
            mine = np.flatnonzero(self._block[groups[:, 0]] == k)
            if not len(mine):
                continue
            at_once = max(_MOST_NUMBERS // (width * block.rows.shape[1]), 1)
            for part in np.split(mine, range(at_once, len(mine), at_once)):
                own = _gathered(block.rows, self._place[groups[part]])
                found[part] = own @ np.swapaxes(own, 1, 2)
        return found


def _gathered(rows: Array, places: Array) -> Array:
    """Return the rows ``(T, w, N)`` at the places ``(T, w)`` of rows ``(k, N)``; where they follow one another, as they do mostly, without a copy."""
    first = places[0, 0]
    if np.array_equal(places.ravel(), np.arange(first, first + places.size)):
        return rows[first : first + places.size].reshape(*places.shape, -1)
    return rows[places]


def one_joint_each(joints: Array, groups: Iterable[Array]) -> Array:
    """Return the joint ``(e,)`` of each column that is in groups of columns of that joint alone, and -1 for any other column.

    Args:
        joints: ``(e,)``, the joint of each column; -1 for one that is of no joint, or of several.
        groups: Arrays ``(T, w)`` of the indices of the columns of T groups.
    """
    joints, all_groups = joints.copy(), list(groups)
    while True:
        mixed = [of_width[np.ptp(joints[of_width], axis=1) > 0].ravel() for of_width in all_groups]
        others = np.concatenate([np.zeros(0, dtype=int), *mixed])
        if not len(others):
            return joints
        joints[others] = -1
