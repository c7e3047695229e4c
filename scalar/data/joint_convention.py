"""How a controller counts the joints: its signs, its zeros, and joints that it shows relative to another, as joint 3 against the horizontal.

The joints of the dataset follow from those of the controller by ``q = M c + o``. Each row of ``M`` has its joint's sign in the columns of the
controller's joints that are added. ``M`` can be inverted, so that angles of either side become those of the other.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from scalar.data.located_table import Table
from scalar.geometry.se3 import Array


@dataclass(frozen=True, eq=False)
class JointConvention:
    """The convention of a controller.

    Attributes:
        matrix: ``(n, n)``, ``M``; without unit.
        offset: ``(n,)``, ``o`` [rad; m of a joint that slides].
        signs: ``{column: 1 or -1}`` of the directions of approach and torques that count the other way in the dataset.
        in_words: How the joints that differ follow from those of the controller, as in ``q3 = J3 + J2``; empty if none differ.
        file: The name of the file that states it.
    """

    matrix: Array
    offset: Array
    signs: Mapping[str, float]
    in_words: str
    file: str

    def to_dataset(self, controller: Array) -> Array:
        """Return the joints ``(N, n)`` [rad, m] of the dataset, given those of the controller."""
        return controller @ self.matrix.T + self.offset

    def to_controller(self, dataset: Array) -> Array:
        """Return the joints ``(N, n)`` [rad, m] of the controller, given those of the dataset."""
        return np.linalg.solve(self.matrix, (dataset - self.offset).T).T

    def limits_at(self, dataset: Array, limits: Array) -> Array:
        """Return the limits of the controller's joints at poses, ``(N, n, 2)`` [rad, m]: what each may show while the others stay where they are.

        Where a joint is shown relative to another, as joint 3 against the horizontal, its limits move with that one.

        Args:
            dataset: ``(N, n)`` [rad, m], joints of the dataset.
            limits: ``(n, 2)`` [rad, m], the limits of these.
        """
        # -1 where the column of a joint counts the other way than the joint, else 1.
        own = np.diag(self.matrix)
        left = own[:, None] * (limits - dataset[:, :, None])
        return np.sort(self.to_controller(dataset)[:, :, None] + left, axis=2)

    def table_to_dataset(self, table: Table) -> None:
        """Convert a table in SI, in place: its columns ``q1..qn`` if it has all of them, directions of approach and torques.

        A joint that follows from a cell with a fault counts as reported.
        """
        joints = [f"q{i + 1}" for i in range(len(self.offset))]
        if all(name in table.columns for name in joints):
            faulty = np.stack(
                [table.bad.get(name, np.zeros(table.n_rows, dtype=bool)) for name in joints], axis=1
            )
            spoilt = faulty @ (self.matrix != 0.0).T
            q = self.to_dataset(np.stack([table.columns[name] for name in joints], axis=1))
            table.columns |= {name: q[:, i] for i, name in enumerate(joints)}
            table.bad |= {name: spoilt[:, i] for i, name in enumerate(joints) if spoilt[:, i].any()}
        for name in self.signs.keys() & table.columns.keys():
            table.columns[name] = self.signs[name] * table.columns[name]
