"""Datasets: everything that calibration and diagnosis read, from a folder of format ``scalar-dataset/1`` or 2, or from arrays.

Poses are in acquisition order. The points of one pose are consecutive, in the order of the file. A reader that finds faults reports all of them.
"""

# pyright: reportMissingTypeStubs=false, reportUnknownMemberType=false
# pandas is not annotated throughout.

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import ArrayLike

from scalar.data.arrays import content_of_arrays, references_of_arrays
from scalar.data.covariates import covariate_names
from scalar.data.dataset_writer import write_dataset
from scalar.data.declared import PlaneGuess, Sensor, declared_parts, description, unit_plane
from scalar.data.folder import Content, examine_folder, read_folder
from scalar.data.formats import FEW_PLANES, IMPORTED
from scalar.data.moves import joint_angles, rows_with_moves, with_commanded_joints
from scalar.data.point_tables import group_points, point_table
from scalar.data.poses import Poses, session_codes
from scalar.data.references import References
from scalar.data.sensor_formats import sensor_formats
from scalar.errors import Fault
from scalar.geometry.robot import Robot

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, eq=False)
class Dataset:
    """Poses of a robot, and what its sensor measured at each of them.

    Attributes:
        name: Name of the dataset.
        source: Free text, may be empty.
        robot: The nominal robot.
        sensor: The nominal sensor.
        planes: The initial guesses of the planes; empty for a tracker.
        poses: One row for each pose in acquisition order (by the column `order` if there is one, else as in the
            file); columns as in poses.csv: `pose` int64, `plane` and `session` text, all others float64.
        points: ``(P, k)`` [m], the measured points; the columns depend on the sensor kind: x and z in the sensor
            frame, or x, y and z in a tracker's frame; ``(0, 2)`` for a sensor without a table of points.
        starts: ``(N + 1,)`` int64; the points of pose row i are ``points[starts[i]:starts[i + 1]]``.
        point_columns: The optional columns of the table of points by name, ``(P,)`` float64 each; ``target`` holds
            indices into `targets`.
        targets: The names of the targets on the flange, in the order of the file; empty if the table names none.
        references: Points fixed to the base that were measured as well, or None.
        imported: What an import knew: the ``mapping``; ``joints``, how it converted joints, which the controller then counts otherwise; and ``order``
            if nothing stated the order of the poses. Empty without an import.
        few_planes: Whether there are said to be no more planes, so that what these do not show is left to the data sheet.
    """

    name: str
    source: str
    robot: Robot
    sensor: Sensor
    planes: tuple[PlaneGuess, ...]
    poses: pd.DataFrame
    points: np.ndarray
    starts: np.ndarray
    point_columns: Mapping[str, np.ndarray] = field(default_factory=dict[str, np.ndarray])
    targets: tuple[str, ...] = ()
    references: References | None = None
    imported: Mapping[str, str] = field(default_factory=dict[str, str])
    few_planes: bool = False

    @classmethod
    def from_arrays(
        cls,
        *,
        robot: Robot,
        sensor: Sensor,
        q: ArrayLike,
        points: ArrayLike | Sequence[ArrayLike] | None = None,
        planes: Sequence[PlaneGuess] = (),
        plane: Sequence[str] | None = None,
        columns: Mapping[str, ArrayLike] | None = None,
        point_columns: Mapping[str, Any] | None = None,
        nests: Mapping[str, ArrayLike] | None = None,
        pose_ids: ArrayLike | None = None,
        name: str = "arrays",
        source: str = "",
        few_planes: bool = False,
    ) -> Dataset:
        """Return a dataset of arrays, checked as strictly as a folder is.

        Args:
            robot: the nominal robot.
            sensor: the nominal sensor; its kind says what `points`, `planes` and `plane` have to be.
            q: ``(N, n)`` [rad; m for a prismatic joint], joint angles as the encoders read them, one row for each pose.
            points: line-laser: N arrays ``(M_i, 2)``, or one ``(N, M, 2)`` [m], x and z in the sensor frame; tracker:
                ``(N, 3)`` [m], in the tracker's frame; probe: None.
            planes: the initial guesses of the planes; none for a tracker.
            plane: ``(N,)``, the name of the plane that each pose measures; None for a tracker.
            columns: the optional columns of poses.csv by name, ``(N,)`` each: ``order``, ``time`` [s], ``temperature``
                [deg C], ``session``, ``approach`` as ``(N, n)`` of -1 and 1, and any covariate.
            point_columns: the optional columns of the points by name, ``(P,)`` each, in the order of the points: ``target``
                (names; a pose may then have several points, ``(K, 3)``), ``noise`` [m], ``rx``, ``ry``, ``rz`` [rad], ``rotation_noise`` [rad].
            nests: places of points fixed to the base at every pose, ``(N, 3)`` [m] by name; NaN where one was not measured.
            pose_ids: ``(N,)`` integers, which results use to name a pose; 1 to N if None.
            name: name of the dataset.
            source: free text.
            few_planes: whether there are no more planes than these, so that one or two are accepted, and parallel ones.

        Raises:
            InvalidInput: with all the faults found, each with its array, its row (counted from 1) and its column.

        Example:
            A tracker measures two poses of an arm of one joint, whose flange is 0.5 m from the joint's axis:

            >>> import numpy as np
            >>> from scalar import Dataset, Robot, Sensor
            >>> joint = {"a": 0.0, "alpha": 0.0, "d": 0.3, "theta": 0.0}
            >>> flange = {"translation": [0.5, 0.0, 0.0], "rotation_vector": [0.0, 0.0, 0.0]}
            >>> robot = Robot.from_mapping({"name": "arm", "joints": [joint], "flange": flange})
            >>> dataset = Dataset.from_arrays(
            ...     robot=robot,
            ...     sensor=Sensor("tracker", np.eye(4), noise=1e-4),
            ...     q=[[0.0], [1.5]],
            ...     points=[[0.5, 0.0, 0.3], [0.0354, 0.4987, 0.3]],
            ... )
            >>> dataset.n_poses, dataset.points.shape
            (2, (2, 3))
        """
        mapping = description(name, source, robot, sensor, planes, few_planes=few_planes)
        content = content_of_arrays(mapping, q, points, plane, pose_ids, columns or {}, point_columns or {})
        # The transforms are taken from the arguments: as rotation vectors in dataset.yaml they would lose their last digit.
        references = references_of_arrays(nests or {}, content.poses.n_rows, sensor.kind)
        declared = {"robot": robot, "sensor": sensor, "planes": tuple(map(unit_plane, planes))}
        return replace(_build(content), **declared, references=references)

    def write(self, path: str | os.PathLike[str], *, table_format: str = "csv", force: bool = False) -> None:
        """Write the dataset as a folder, which appears whole or not at all.

        Args:
            path: the folder; a dataset there is replaced if SCALAR wrote it and nobody changed it since.
            table_format: ``csv`` or ``parquet``, for all tables but poses.csv.
            force: whether a dataset there is replaced in any case.

        Raises:
            InvalidInput: the folder cannot be written, or holds something else.
        """
        import pandas as pd

        tables: dict[str, pd.DataFrame] = {}
        layout = sensor_formats()[self.sensor.kind].table
        if layout is not None:
            row_pose_ids = np.repeat(self.pose_ids, np.diff(self.starts))
            tables[layout.stem] = point_table(
                layout, row_pose_ids, self.points, self.point_columns, self.targets
            )
        layout = sensor_formats()[self.sensor.kind].references
        if layout is not None and self.references is not None:
            tables[layout.stem] = pd.DataFrame(self.references.columns(layout, self.pose_ids))
        about = self.name, self.source, self.robot, self.sensor, self.planes, self.imported
        mapping = description(*about, self.few_planes)
        write_dataset(
            path, mapping=mapping, poses=self.poses, table_format=table_format, force=force, **tables
        )

    @property
    def n_poses(self) -> int:
        """Return the number of poses, N."""
        return len(self.poses)

    @cached_property
    def q(self) -> np.ndarray:
        """Return the joint angles as the encoders read them, ``(N, n)`` [rad; m for a prismatic joint]."""
        return joint_angles(self.poses, self.robot.n_joints)

    @cached_property
    def known_poses(self) -> Poses:
        """Return what is recorded of each pose, with the move that led to it."""
        return Poses.from_frame(self.poses, self.robot.slides, order_is_row=True, q=self.q)

    @cached_property
    def pose_ids(self) -> np.ndarray:
        """Return the ids of the poses, ``(N,)`` int64."""
        return cast(Any, self.poses)["pose"].to_numpy(dtype=np.int64)

    @cached_property
    def pose_of_point(self) -> np.ndarray:
        """Return the row of the pose of each point, ``(P,)`` int64."""
        return np.repeat(np.arange(self.n_poses), np.diff(self.starts))

    @cached_property
    def plane_index(self) -> np.ndarray:
        """Return which of `planes` each pose looks at, ``(N,)`` int64; -1 where there are no planes."""
        if not self.planes:
            return np.full(self.n_poses, -1, dtype=np.int64)
        index = {plane.name: i for i, plane in enumerate(self.planes)}
        return np.array([index[name] for name in cast(Any, self.poses["plane"]).tolist()], dtype=np.int64)

    @cached_property
    def session(self) -> np.ndarray | None:
        """Return the session of each pose, ``(N,)`` int64 codes in order of first appearance, or None."""
        if "session" not in self.poses.columns:
            return None
        return session_codes(cast(Any, self.poses["session"]))

    @property
    def covariates(self) -> tuple[str, ...]:
        """Return the names of the numeric columns of poses.csv to which the format gives no meaning of its own, in their order."""
        return covariate_names(list(self.poses.columns), self.robot.n_joints)

    def commanded(self) -> Dataset:
        """Return the dataset with the commanded joint positions, ``qc1..qcn``, in place of those logged.

        Raises:
            InvalidInput: poses.csv has no such columns.
        """
        return replace(self, poses=with_commanded_joints(self.poses, self.robot.n_joints))

    def subset(self, rows: np.ndarray) -> Dataset:
        """Return the dataset of some of the poses, still in acquisition order; they keep the moves that led to them.

        Args:
            rows: ``(N,)`` bool, or integer row numbers; they are sorted, and one given twice appears twice.
        """
        rows = np.asarray(rows)
        rows = np.flatnonzero(rows) if rows.dtype == bool else np.sort(rows.astype(np.int64))
        counts = np.diff(self.starts)[rows]
        starts = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
        offsets = cast(Any, self.starts[rows] - starts[:-1])
        taken = np.arange(int(starts[-1])) + np.repeat(offsets, counts)
        return replace(
            self,
            poses=rows_with_moves(self.poses, rows, self.known_poses.columns, self.robot.n_joints),
            points=self.points[taken],
            starts=starts,
            point_columns={name: values[taken] for name, values in self.point_columns.items()},
            references=None if self.references is None else self.references.subset(rows, self.n_poses),
        )


def read_dataset(path: str | os.PathLike[str]) -> Dataset:
    """Return the dataset in the folder `path`.

    Raises:
        InvalidInput: with all the faults found, each with its file, row and column.

    Example:
        >>> from scalar import read_dataset
        >>> dataset = read_dataset("my-cell")
        >>> dataset.sensor.kind, dataset.q.shape
        ('tracker', (60, 6))
    """
    return _build(read_folder(Path(path)))


def validate_dataset(path: str | os.PathLike[str]) -> list[Fault]:
    """Return every fault of the dataset in the folder `path`; none if it can be read."""
    faults: list[Fault] = []
    examine_folder(Path(path), faults)
    return faults


def _build(content: Content) -> Dataset:
    """Return the dataset with the content of a folder, or of arrays, that has been checked."""
    import pandas as pd

    mapping = content.mapping
    frame = pd.DataFrame(content.poses.columns)
    frame["pose"] = frame["pose"].astype(np.int64)
    if "order" in frame.columns:
        frame = frame.sort_values("order", kind="stable").reset_index(drop=True)
    robot, sensor, planes = declared_parts(mapping)
    format = sensor_formats()[sensor.kind]
    ids = cast(Any, frame)["pose"].to_numpy(dtype=np.int64)
    xyz, starts, further, targets = group_points(ids, format, content.points)
    table, layout = content.references, format.references
    references = None if table is None or layout is None else References.of_table(table, layout, ids)
    return Dataset(
        name=mapping["name"],
        source=mapping.get("source") or "",
        imported=mapping.get(IMPORTED, {}),
        few_planes=mapping.get(FEW_PLANES, False),
        robot=robot,
        sensor=sensor,
        planes=planes,
        poses=frame,
        points=xyz,
        starts=starts,
        point_columns=further,
        targets=targets,
        references=references,
    )
