"""Reference nests: points fixed to the robot's base, measured at the poses as well; they show whether tracker or base moved."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from scalar.data.located_table import Layout, Table
from scalar.data.rigid_references import strange_readings
from scalar.data.sensor_formats import MeasuredTable
from scalar.errors import Fault
from scalar.units import MM

_FEW = 3  # wrong readings of one nest that have a sentence each; more have one together


@dataclass(frozen=True, eq=False)
class References:
    """Measurements of K points that are fixed to the base, in the frame of the measuring device.

    Attributes:
        names: Names of the K points.
        pose: ``(Q,)`` int, the row of the pose at which each measurement was made.
        item: ``(Q,)`` int, index of the measured point in `names`.
        points: ``(Q, 3)`` [m], the measurements.
        noise: ``(Q,)`` [m], standard deviations, or None where they are not stated.
    """

    names: tuple[str, ...]
    pose: np.ndarray
    item: np.ndarray
    points: np.ndarray
    noise: np.ndarray | None = None

    @classmethod
    def of_arrays(cls, nests: Mapping[str, ArrayLike]) -> References:
        """Return the references of arrays ``(N, 3)`` [m] by name; a row that is not finite was not measured."""
        arrays = [np.asarray(values, dtype=float) for values in nests.values()]
        seen = [np.flatnonzero(np.isfinite(values).all(axis=1)) for values in arrays]
        item = np.repeat(np.arange(len(arrays)), [len(rows) for rows in seen])
        points = [values[rows] for values, rows in zip(arrays, seen, strict=True)]
        return cls(tuple(nests), np.concatenate(seen), item, np.concatenate(points))

    @classmethod
    def of_table(cls, table: Table, layout: MeasuredTable, pose_ids: np.ndarray) -> References:
        """Return the references of a table without fault.

        Args:
            table: The table of references.
            layout: Its layout.
            pose_ids: ``(N,)``, ids of the poses in the order of their rows.
        """
        assert layout.item is not None
        labels = [str(name) for name in table.columns[layout.item]]
        names = tuple(dict.fromkeys(labels))
        row = {int(pose): i for i, pose in enumerate(pose_ids)}
        pose = np.array([row[int(pose)] for pose in table.columns["pose"]], dtype=np.int64)
        code = {name: i for i, name in enumerate(names)}
        item = np.array([code[name] for name in labels], dtype=np.int64)
        points = np.column_stack([table.columns[name] for name in layout.units])
        return cls(names, pose, item, points, table.columns.get("noise"))

    def columns(self, layout: MeasuredTable, pose_ids: np.ndarray) -> dict[str, np.ndarray]:
        """Return the columns of the table that ``of_table`` reads."""
        columns = {"pose": pose_ids[self.pose], str(layout.item): np.array(self.names, object)[self.item]}
        columns |= dict(zip(layout.units, self.points.T, strict=True))
        return columns if self.noise is None else {**columns, "noise": self.noise}

    def subset(self, rows: np.ndarray, n_poses: int) -> References:
        """Return the measurements at some of the poses, with the rows of these poses renumbered.

        Args:
            rows: Rows of the poses that are kept, ascending; of a row that is given twice, the measurements are kept once.
            n_poses: Number of all poses.
        """
        new = np.full(n_poses, -1)
        new[rows] = np.arange(len(rows))
        kept = new[self.pose] >= 0
        noise = None if self.noise is None else self.noise[kept]
        return References(self.names, new[self.pose[kept]], self.item[kept], self.points[kept], noise)


def references_layout(table: MeasuredTable) -> Layout:
    """Return the columns of a table of references: each row names its point."""
    item = str(table.item)
    return Layout(("pose", item, *table.units), tuple(table.optional), frozenset({item}))


def check_references(table: Table, layout: MeasuredTable, poses: Table | None, faults: list[Fault]) -> None:
    """Add a fault for each reference of an unknown pose, and for each that contradicts the others; a pose without references is no fault."""
    if poses is None or not poses.whole or "pose" not in poses.columns or "pose" not in table.columns:
        return
    ids = table.columns["pose"]
    strange = ~np.isin(ids, poses.columns["pose"]) & ~np.isnan(ids)
    table.report_ids(
        faults,
        "pose",
        strange,
        lambda i: f"unknown pose {ids[i]:.15g}; remove the row, or add the pose to {poses.file}",
        lambda count, named: (
            f"{count} unknown poses, {named}; remove the rows, or add the poses to {poses.file}"
        ),
    )
    needed = ("pose", str(layout.item), *layout.units)
    if not table.whole or strange.any() or not table.good(*needed):
        return
    if all(np.isfinite(table.columns[name]).all() for name in ("pose", *layout.units)):
        _check_distances(table, layout, poses, faults)


def _check_distances(table: Table, layout: MeasuredTable, poses: Table, faults: list[Fault]) -> None:
    """Add a fault for each reference whose distances to the others are not those of the other poses, session by session."""
    ids, item = table.columns["pose"], str(layout.item)
    session_of = dict(
        zip(poses.columns["pose"], poses.columns.get("session", np.zeros(poses.n_rows)), strict=True)
    )
    session = np.array([str(session_of[pose]) for pose in ids])
    nest = np.unique(table.columns[item].astype(str), return_inverse=True)[1]
    points = np.column_stack([table.columns[name] for name in layout.units])
    off: dict[int, float] = {}
    for one in np.unique(session):
        rows = np.flatnonzero(session == one)
        off |= {int(rows[i]): d for i, d in strange_readings(ids[rows], nest[rows], points[rows]).items()}
    wrong = np.isin(np.arange(len(ids)), list(off))
    first, of_nest = np.arange(len(ids)), {}
    for k in np.unique(nest[wrong]):
        mine = np.flatnonzero(wrong & (nest == k))
        if len(mine) > _FEW:  # one sentence for all
            first[mine], of_nest[int(mine[0])] = mine[0], mine

    def said(i: int) -> str:
        """Return what is wrong with the reading of a row, or with all of its nest."""
        if i not in of_nest:
            return (
                f"{table.columns[item][i]} at pose {ids[i]:.15g} is up to {off[i] / MM:.3g} mm nearer to the other points, or farther from them, "
                "than at other poses, and points on one base keep their distances: remove the row, or correct its name"
            )
        mine = of_nest[i]
        return (
            f"{table.columns[item][i]} is up to {max(off[row] for row in mine) / MM:.3g} mm nearer to the other points, or farther from them, at "
            f"{len(mine)} poses, the first {ids[mine[0]]:.15g} and the last {ids[mine[-1]]:.15g}, than at the others, and points on one base keep "
            "their distances: it was probably knocked; remove these rows, or give it another name in them"
        )

    table.report(faults, item, wrong & (first == np.arange(len(ids))), said)
