"""Joints whose angles in the dataset differ from those that the controller shows: what a user has to know before a program is corrected."""

from __future__ import annotations

import re

from scalar.ingest.mapping import OF_JOINT, Column, MappingFile


def formulas(mapping: MappingFile) -> list[str]:
    """Return how each joint that the mapping converts by more than its unit follows from the columns of the file, as in ``q3 = J3 + J2``."""
    joints = {
        name: column for name, column in mapping.poses.columns.items() if re.fullmatch("q[1-9][0-9]*", name)
    }
    return [
        f"{name} = {_formula(column)}"
        for name, column in joints.items()
        if column.second is not None or column.sign != 1.0 or column.offset
    ]


def converted_joints(mapping: MappingFile, file: str) -> str | None:
    """Return a sentence about the joints that the mapping, a file of this name, converts by more than their unit; or None if there are none."""
    if not (converted := formulas(mapping)):
        return None
    return (
        f"the joint angles of the dataset are not those that the controller shows: {', '.join(converted)}. Give --mapping {file} to 'scalar plan', "
        "'scalar correct' and 'scalar predict', and they read and write the angles of the controller; without it, those of the dataset"
    )


def unconverted_signs(mapping: MappingFile) -> str | None:
    """Return a sentence about directions of approach and torques that keep the sign of the file, while that of their joint is turned; or None."""
    columns = mapping.poses.columns
    kept = [
        name
        for name, column in columns.items()
        if OF_JOINT.fullmatch(name) and not column.sign_stated and _turned(columns.get(f"q{_number(name)}"))
    ]
    if not kept:
        return None
    return (
        f"{' and '.join(kept)} keep{'s' if len(kept) == 1 else ''} the sign of the file, although the sign of the joint is turned: if the controller "
        "counts them as it counts the joint, write sign: -1 for them too, else sign: 1; play with the wrong direction is not found, or wrongly"
    )


def _turned(joint: Column | None) -> bool:
    return joint is not None and joint.sign == -1.0


def _number(name: str) -> str:
    return re.sub(r"\D", "", name)


def _formula(column: Column) -> str:
    """Return how a joint follows from the columns of the file, in the unit of the file."""
    value = f"{column.reference}"
    if column.second is not None:
        reference, sign = column.second
        value += f" {'+' if sign > 0 else '-'} {reference}"
    if column.sign == -1.0:
        value = f"-{value}" if column.second is None else f"-({value})"
    if not column.offset:
        return value
    return f"{value} {'+' if column.offset > 0 else '-'} {abs(column.offset):.12g} {column.unit}".rstrip()
