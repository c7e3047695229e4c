"""Check that the columns that a mapping names are those that the robot and the sensor need."""

import re
from collections.abc import Mapping
from typing import Any

from scalar.data.description import Description
from scalar.data.formats import COMMANDED, PAYLOAD, TORQUE
from scalar.data.located_table import did_you_mean, shorten
from scalar.data.sensor_formats import sensor_formats
from scalar.ingest.mapping import TARGET, TEXT_COLUMNS, Block, Column, MappingFile, quantity_of
from scalar.ingest.orientation import check_orientation


def check_columns(given: Description, mapping: MappingFile) -> None:
    """Add columns that are missing, misspelt, or belong to another robot or sensor to ``given.faults``."""
    n = mapping.description.n_joints
    joints = [f"q{i + 1}" for i in range(n)]
    by_joint = [f"{stem}{i + 1}" for stem in ("approach", COMMANDED, TORQUE) for i in range(n)]
    plane = _plane(mapping)
    measured = [*mapping.point_columns, *mapping.further_points, *mapping.foreign_points]
    optional = ["pose", "order", "time", "temperature", "session", *by_joint, *PAYLOAD]
    known = [*joints, *plane, *([] if mapping.points else measured), *optional]
    set_by_file = (
        set.intersection(*({*rule.text} for rule in mapping.poses.files)) if mapping.poses.files else set()
    )
    required = [*joints, *(name for name in plane if name not in set_by_file)]
    required += _check_points(given, mapping, measured)
    if mapping.several_points and mapping.poses.first_of_each is None:
        given.fault(
            ("poses", "first_of_each"),
            "missing; add it: the column that says to which pose a row belongs, since each row is a point",
        )
    _check_block(given, "poses", required, known, mapping)
    for key, block in (("poses", mapping.poses), ("points", mapping.points)):
        if block is not None:
            check_orientation(given, key)
            _check_repeated(given, key, block.columns, [*joints, *by_joint[n:], *measured])
    if mapping.nests is not None:
        _check_nests(given, mapping, mapping.description.kind)
    _check_files(given, mapping)
    _check_covariates(given, mapping, {*known, *TEXT_COLUMNS, *measured, "x", "y", "z"})


def _plane(mapping: MappingFile) -> list[str]:
    """Return the column of planes if the sensor measures such, else none."""
    format = mapping.description.sensor_format
    return ["plane"] if format is None or format.on_planes else []


def _check_points(given: Description, mapping: MappingFile, measured: list[str]) -> list[str]:
    """Add the faults of the block ``points`` to ``given.faults``, and return the columns that ``poses`` needs with it or without it.

    Args:
        given: The mapping file.
        mapping: Its content.
        measured: The columns that the sensor's table may have.
    """
    sensor, points = mapping.description.kind, mapping.points
    if points is None:
        return list(mapping.point_columns)
    if not mapping.point_columns:
        kinds = sorted(kind for kind, format in sensor_formats().items() if format.table is not None)
        given.fault(
            ("points",), f"a {sensor} has no points of its own, only {', '.join(kinds)} have; remove this key"
        )
        return []
    if points.targets:
        _check_targets(given, mapping, sensor)
    else:
        own = [] if points.nearest_time is not None else ["pose"]
        _check_block(given, "points", [*own, *mapping.point_columns], ["pose", *measured], mapping)
    if points.nearest_time is not None:
        _check_times(given, points, mapping)
    if not mapping.poses.files:
        given.fault(
            ("poses", "files"),
            "missing; add it: with points in files of their own, each block names its files",
        )
    return [] if points.nearest_time is not None else ["pose"]


def _check_files(given: Description, mapping: MappingFile) -> None:
    """Add what is stated for a whole file of poses and for its rows as well, or does not fit the sensor, to ``given.faults``."""
    for i, rule in enumerate(mapping.poses.files):
        both = [name for name in (*rule.text, *rule.covariates) if name in mapping.poses.columns]
        for name in both:
            given.fault(("poses", "files", i), f"{name} comes from a column as well; keep one of the two")
        if rule.first_pose is not None and "pose" in mapping.poses.columns:
            given.fault(
                ("poses", "files", i, "first_pose"), "ids come from a column as well; keep one of the two"
            )
        if "plane" in rule.text and not _plane(mapping):
            message = f"a {mapping.description.kind} has no planes; remove this key"
            given.fault(("poses", "files", i, "plane"), message)


def _check_covariates(given: Description, mapping: MappingFile, of_format: set[str]) -> None:
    """Add covariates of poses whose names are those of columns of the format (``of_format``), or cannot name a column, to ``given.faults``."""
    covariates = [(("poses", "covariates", name), name) for name in given.get("poses", "covariates") or {}]
    for i, rule in enumerate(mapping.poses.files):
        covariates += [(("poses", "files", i, "covariates", name), name) for name in rule.covariates]
    for path, name in covariates:
        if name in of_format or re.fullmatch(r"(q|approach|qc|tau)[0-9]+", name):
            given.fault(
                path, "not a covariate but a column of the format; put it under columns, or rename it"
            )
        elif name != name.strip() or not name or re.search(r"[\",\n\r]", name):
            given.fault(path, f"not a name for a column ({shorten(name)}); use letters, digits and _")


def _check_times(given: Description, points: Block, mapping: MappingFile) -> None:
    """Add what the block ``points`` lacks to be given to poses by time, to ``given.faults``."""
    if "time" not in mapping.poses.columns:
        given.fault(
            ("poses", "columns", "time"),
            "missing; add it, as {column: name in the file}: points.nearest_time compares it",
        )
    if "pose" in points.columns:
        given.fault(
            ("points", "nearest_time"),
            "points.columns.pose says already to which pose a point belongs; keep one of the two",
        )


def _check_targets(given: Description, mapping: MappingFile, sensor: str | None) -> None:
    """Add the faults of the block ``points``, whose rows measure several targets, to ``given.faults``."""
    if mapping.table is None or mapping.table.item != TARGET:
        given.fault(("points", "targets"), f"a {sensor} has no targets, only a tracker has; remove this key")
        return
    own = [
        name
        for name in (*mapping.point_columns, *mapping.further_points, *mapping.foreign_points)
        if name != TARGET
    ]
    common = given.get("points", "columns")
    timed = mapping.points is not None and mapping.points.nearest_time is not None
    _check_block(given, "points", [] if timed else ["pose"], ["pose", *own], mapping)
    for target, columns in given.get("points", "targets").items():
        place = ("points", "targets", target)
        _check_names(given, place, columns, own)
        for name in (name for name in columns if name in common):
            given.fault((*place, name), "stands under points.columns as well; keep one of the two")
        _check_present(given, place, {**common, **columns}, list(mapping.point_columns), mapping)


def _check_nests(given: Description, mapping: MappingFile, sensor: str | None) -> None:
    """Add the faults of the block ``nests``, points fixed to the base, to ``given.faults``."""
    table = mapping.references
    if table is None:
        given.fault(("nests",), f"a {sensor} has no nests, only a tracker has; remove this key")
        return
    item = str(table.item)
    if "pose" not in mapping.poses.columns:
        given.fault(
            ("poses", "columns", "pose"), "missing; add it: nests name the poses at which they were measured"
        )
    if not mapping.poses.files:
        given.fault(
            ("poses", "files"),
            "missing; add it: with nests in files of their own, each block names its files",
        )
    columns = ["pose", item, *table.units]
    _check_block(given, "nests", columns, [*columns, *table.optional], mapping)


def _check_block(
    given: Description, key: str, required: list[str], known: list[str], mapping: MappingFile
) -> None:
    """Add the unknown and the missing columns of the block ``key`` to ``given.faults``."""
    columns = given.get(key, "columns")
    _check_names(
        given,
        (key, "columns"),
        columns,
        known,
        "" if key != "poses" else "; a column of your own goes under covariates",
    )
    _check_present(given, (key, "columns"), columns, required, mapping)


def _check_names(
    given: Description, place: tuple[str, ...], columns: Mapping[str, Any], known: list[str], extra: str = ""
) -> None:
    """Add the columns at a place of the mapping file that are not known there to ``given.faults``; ``extra`` ends the message."""
    for name in columns:
        if name not in known:
            hint = did_you_mean(name, [k for k in known if k not in columns])
            message = f"unknown column; {hint}the columns here are {', '.join(known)}{extra}"
            given.fault((*place, name), message)


def _check_repeated(given: Description, key: str, columns: Mapping[str, Column], numbers: list[str]) -> None:
    """Add the columns that come from the same column of the file as an earlier one to ``given.faults``.

    Args:
        given: The mapping file.
        key: Key of the block in the mapping file.
        columns: Its columns by their names in the dataset.
        numbers: The columns that are compared: joint angles, measured and commanded, torques, and what the sensor measures. Others may have one
            column in common, such as the id of a pose and its order.
    """
    first: dict[Any, str] = {}
    for name in (name for name in columns if name in numbers):
        column = columns[name]
        other = first.setdefault((column.reference, column.second), name)
        if other != name:
            message = f"comes from the same column of the file as {other} ({shorten(column.reference)}); correct one of the two"
            if {name[0], other[0]} == {"q"}:
                message += "; if the two joints follow one encoder, as those of a parallelogram do, give the file a second column with its values"
            given.fault((key, "columns", name), message)


def _check_present(
    given: Description,
    place: tuple[str, ...],
    columns: Mapping[str, Any],
    required: list[str],
    mapping: MappingFile,
) -> None:
    """Add the required columns that a place of the mapping file lacks to ``given.faults``."""
    for name in required:
        if name not in columns:
            unit = {"length": "m", "angle": "rad"}.get(
                quantity_of(name, mapping.table, mapping.description) or ""
            )
            message = "missing; add it, as {column: name in the file" + (f", unit: {unit}}}" if unit else "}")
            given.fault((*place, name), message)
