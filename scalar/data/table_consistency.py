"""Check the tables of a dataset, each by itself and against the others.

Every check adds the faults it finds to a list and goes on, so that a user repairs a folder in one round. A
check that makes no sense because of an earlier fault is skipped, so that one mistake is not reported as ten.
`scalar.data.unit_suspicions` checks whether the numbers have the right units, and the estimator whether they determine a model.
"""

import re
from collections.abc import Sequence

import numpy as np

from scalar.data.description import DESCRIPTION, NO_MORE_PLANES, Description
from scalar.data.formats import COMMANDED, DATASET_FORMAT, PAYLOAD, TORQUE
from scalar.data.located_table import DIRECTIONS, Layout, Table, did_you_mean, shorten
from scalar.data.pose_numbers import report_shifted
from scalar.data.sensor_formats import MeasuredTable, sensor_formats
from scalar.data.unique_numbers import check_unique
from scalar.errors import Fault

_NAME = re.compile(r"[A-Za-z0-9_-]+")
_JOINT_COLUMN = re.compile(r"(q|approach|qc|tau)([0-9]+)")


def poses_layout(description: Description) -> Layout:
    """Return which columns poses.csv has to have and may have by this description."""
    n = description.n_joints
    joints = tuple(f"q{i + 1}" for i in range(n))
    plane = ("plane",) if _on_planes(description) else ()

    def refuse(name: str) -> str | None:
        match = _JOINT_COLUMN.fullmatch(name)
        if not match or not n or (match[1] in (COMMANDED, TORQUE) and not version_2):
            return None
        return f"the robot has joints 1 to {n}; remove the column, or complete robot.joints in {DESCRIPTION}"

    version_2 = description.is_version_2
    stems = ("approach", COMMANDED, TORQUE) if version_2 else ("approach",)
    by_joint = tuple(f"{stem}{i + 1}" for stem in stems for i in range(n))
    return Layout(
        required=("pose", *plane, *joints),
        optional=("order", "time", "temperature", "session", *by_joint, *(() if plane else ("plane",))),
        text=frozenset({"plane", "session"}),
        extras=True,
        refuse=refuse,
    )


def check_poses(
    poses: Table,
    description: Description,
    faults: list[Fault],
    unique: tuple[str, ...] = ("pose", "order"),
    all_joints: bool = True,
) -> None:
    """Add the faults in the cells of poses.csv, units aside.

    Args:
        poses: The table.
        description: Of the dataset.
        faults: To which faults are added.
        unique: Columns in which no value may stand twice.
        all_joints: Whether columns that there are for each joint, such as ``approach1..n``, have to be there for all joints or for none.
    """
    if poses.whole and poses.n_rows == 0:
        faults.append(Fault(poses.file, "there is no pose; write one row for each pose"))
    for name in unique:
        check_unique(poses, name, faults)
    approach = [f"approach{i + 1}" for i in range(description.n_joints)]
    present = [name for name in approach if name in poses.columns]
    for name in present:
        values = poses.columns[name]
        wrong = ~np.isin(values, (-1.0, 1.0))
        poses.report(
            faults,
            name,
            wrong,
            lambda i, v=values: f"neither -1 nor 1 ({v[i]:g}); {DIRECTIONS}",
        )
    version_2 = description.is_version_2
    stems = ("approach", COMMANDED, TORQUE) if version_2 else ("approach",)
    for stem in stems if all_joints else ():
        names = [f"{stem}{i + 1}" for i in range(description.n_joints)]
        for name in names if any(name in poses.columns for name in names) else ():
            if name not in poses.columns:
                message = f"the column is missing; the {stem} columns come for all joints or for none"
                faults.append(Fault(poses.file, message, 1, name))
    if version_2 and PAYLOAD[0] in poses.columns:
        mass = poses.columns[PAYLOAD[0]]
        poses.report(faults, PAYLOAD[0], mass < 0, lambda i: f"a mass of {mass[i]:g} kg; write 0 or more")
    if _on_planes(description) and description.plane_names:
        _check_plane_names(poses, description, faults)


def _on_planes(description: Description) -> bool:
    return description.sensor_format is not None and description.sensor_format.on_planes


def _several_items(layout: MeasuredTable) -> str:
    """Return the end of the message about a pose with several rows: how a column could name what each of them measures."""
    if layout.item is None:
        return ""
    return f", or name in a column '{layout.item}' which of several each row measures ({DATASET_FORMAT})"


def is_name(text: str) -> bool:
    """Return whether a text may name an item, and so be a part of a parameter's name."""
    return _NAME.fullmatch(text) is not None


def not_a_name(text: str) -> str:
    """Return the message about a text that may not name an item."""
    return f"not a name ({shorten(text)}); write letters, digits, _ or - only"


def check_items(points: Table, item: str, faults: list[Fault]) -> None:
    """Add a fault for each row that repeats an item at the same pose, and for each name of an item that cannot be part of a parameter's name."""
    if "pose" not in points.columns or item not in points.columns:
        return
    ids, names = points.columns["pose"], points.columns[item].astype(str)
    unfit = np.array([not is_name(name) and bool(name) for name in names], dtype=bool)
    points.report_labels(
        faults,
        item,
        unfit,
        lambda i: not_a_name(str(names[i])),
    )
    lines = points.line_numbers()
    first: dict[tuple[float, str], int] = {}
    repeated = np.zeros(points.n_rows, dtype=bool)
    for i, key in enumerate(zip(ids.tolist(), names.tolist(), strict=True)):
        repeated[i] = first.setdefault(key, i) != i and not np.isnan(key[0])

    def message(i: int) -> str:
        earlier = first[float(ids[i]), str(names[i])]
        file = points.file_of(earlier)
        where = f"row {lines[earlier]}" if file == points.file_of(i) else f"{file}, row {lines[earlier]}"
        return f"{item} {names[i]} of pose {ids[i]:.15g} stands already in {where}; correct or remove one"

    points.report(faults, item, repeated, message)


def check_optional_columns(points: Table, layout: MeasuredTable, faults: list[Fault]) -> None:
    """Add a fault for each missing column of a group that is given as a whole or not at all, and for each noise that is not positive."""
    for group in layout.together:
        there = [name for name in group if name in points.columns]
        for name in group if there else ():
            if name not in there:
                message = f"the column is missing; {', '.join(group)} come together or not at all"
                faults.append(Fault(points.file, message, 1, name))
    for name in layout.noises:
        if name in points.columns:
            values = points.columns[name]
            unit = layout.optional[name]
            points.report(
                faults,
                name,
                values <= 0,
                lambda i, v=values, u=unit: (
                    f"a noise of {v[i]:g} {u}; write one standard deviation, greater than 0"
                ),
            )


def _check_plane_names(poses: Table, description: Description, faults: list[Fault]) -> None:
    if "plane" not in poses.columns:
        return
    names = description.plane_names
    found = poses.columns["plane"]
    unknown = ~np.isin(found.astype(str), names)

    def message(i: int) -> str:
        hint = did_you_mean(str(found[i]), names)
        return f"unknown plane {shorten(found[i])}; {hint}{DESCRIPTION} names {', '.join(names)}{poses.translated}"

    poses.report_labels(faults, "plane", unknown, message)
    present = set(found)
    used = [name for name in names if name in present]
    least = description.least_planes
    if poses.good("plane") and poses.whole and poses.n_rows and len(set(names)) >= least > len(used):
        unused = ", ".join(name for name in names if name not in used)
        text = f"poses of {len(used)} {'plane' if len(used) == 1 else 'planes'} only, none of {unused}; measure poses of at least three planes"
        text += NO_MORE_PLANES if used else ""
        faults.append(Fault(poses.file, text, column="plane"))


def points_layout(table: MeasuredTable, description: Description) -> Layout:
    """Return which columns the table of the measurements has to have and may have by this description."""
    further = table.further if description.is_version_2 else ()
    text = frozenset() if table.item is None else frozenset({table.item})
    return Layout(table.columns, further, text & frozenset(further))


def check_points(points: Table, poses: Table | None, layout: MeasuredTable, faults: list[Fault]) -> None:
    """Add a fault for each point of an unknown pose, each pose without a point, and each pose with several if only one is allowed.

    Args:
        points: The table of measured points.
        poses: The table of poses; None if it could not be read, and then poses and points are not compared.
        layout: What the table of points holds for this kind of sensor.
        faults: The list to which the faults are added.
    """
    if points.whole and points.n_rows == 0:
        faults.append(Fault(points.file, "there is no point; write one row for each point"))
        return
    if layout.item is not None and layout.item in points.columns:
        check_items(points, layout.item, faults)
    elif not layout.several_rows:
        check_unique(points, "pose", faults, _several_items(layout))
    check_optional_columns(points, layout, faults)
    if poses is None or "pose" not in poses.columns or "pose" not in points.columns:
        return
    known, ids = poses.columns["pose"], points.columns["pose"]
    if poses.whole and points.whole and report_shifted(points, poses, faults):
        return
    if poses.whole and not np.isnan(known).any():
        strange = ~np.isin(ids, known) & ~np.isnan(ids)

        def strange_message(i: int) -> str:
            count = int(np.count_nonzero(ids == ids[i]))
            rows = f"{count} row" + ("s" if count > 1 else "")
            return f"unknown pose {ids[i]:.15g} ({rows}); remove them, or add the pose to {poses.file}"

        points.report_ids(
            faults,
            "pose",
            strange,
            strange_message,
            lambda count, named: (
                f"{count} unknown poses, {named}; remove them, or add the poses to {poses.file}"
            ),
        )
    if points.whole and not np.isnan(ids).any():
        missing = ~np.isin(known, ids) & ~np.isnan(known)

        def missing_message(i: int) -> str:
            return f"pose {known[i]:.15g} has no {layout.row} in {points.file}; add it there, or remove this pose"

        poses.report_ids(
            faults,
            "pose",
            missing,
            missing_message,
            lambda count, named: (
                f"{count} poses have no {layout.row} in {points.file}: {named}; add them there, or remove these poses"
            ),
        )


def unknown_data_files(kind: str, names: Sequence[str], *, version_2: bool = True) -> list[Fault]:
    """Return a fault for every data file that a sensor of this kind does not have, in version 2 of the format or in version 1."""
    files = {
        name: {
            file
            for table in (format.table, format.references if version_2 else None)
            if table is not None
            for file in table.files
        }
        for name, format in sensor_formats().items()
    }
    own = files.get(kind, set[str]())
    owners = {
        file: " or ".join(k for k, theirs in files.items() if file in theirs)
        for theirs in files.values()
        for file in theirs
        if file not in own
    }
    return [
        Fault(
            name,
            f"a {kind} has no such file; remove it, or set sensor.kind: {owners[name]} in {DESCRIPTION}",
        )
        for name in names
        if name in owners
    ]
