"""Whether two files of a table are copies: the same file lies in a folder twice, as ``poses (1).csv`` beside ``poses.csv``.

Measurements scatter, so two files with the same ones are copies. Joint angles alone do not show it, because a program may run twice: files that
hold no more than them are copies if they have the same poses as well.
"""

from __future__ import annotations

import hashlib
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from scalar.errors import Fault
from scalar.geometry.se3 import Array
from scalar.ingest.imported_table import ImportedTable
from scalar.ingest.mapping import Block, FileRule
from scalar.ingest.merged_scans import SCAN
from scalar.ingest.raw_table import FILE_NUMBER

_LEAST_NUMBERS = 6  # chosen: so many measured numbers are never the same twice; one or two may be, as of a nest measured anew
_PAIRS_SHOWN = 3


@dataclass(frozen=True, eq=False)
class FileRead:
    """A file of a table, as it was read.

    Attributes:
        rule: What the mapping says of it.
        rows: Its rows in SI.
        poses: The numbers of its poses.
    """

    rule: FileRule
    rows: ImportedTable
    poses: Array

    @property
    def name(self) -> str:
        """Return its name, with the folders that distinguish it."""
        return self.rows.file


def digest_of(path: Path) -> bytes:
    """Return what files with the same bytes have in common; for one that cannot be read, what it has in common with no other."""
    if not path.is_file():
        return str(path).encode()
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").digest()


def report_copies(
    files: Sequence[FileRead], block: Block, measured: Collection[str], faults: list[Fault]
) -> None:
    """Add a fault for each file that has the same rows as another one; a single fault if there are many.

    Args:
        files: All files of the block, as they were read.
        block: The block of the mapping.
        measured: The columns that the sensor measures.
        faults: Where they are added.
    """
    first: dict[bytes, FileRead] = {}
    pairs: list[tuple[str, str]] = []
    for file in files:
        if (key := _content(file, block, measured)) is None:
            continue
        if (other := first.setdefault(key, file)) is not file:
            # The name of a copy is that of the file with something added.
            original, copy = sorted((other, file), key=lambda one: len(one.name))
            first[key] = original
            pairs.append((original.name, copy.name))
    remedy = "so that each would count twice; leave one of them out"
    if not set(measured) & set(block.column_names):
        remedy += ", or, if the program ran twice, write add_to_pose: 1000 for one of them, where poses and points are mapped"
    if len(pairs) <= _PAIRS_SHOWN:
        faults += [Fault(copy, f"has the same rows as {original}, {remedy}") for original, copy in pairs]
        return
    shown = ", ".join(f"{copy} as {original}" for original, copy in pairs[:_PAIRS_SHOWN])
    message = f"one of {len(pairs)} files that have the same rows as others ({shown}, ...), {remedy}"
    faults.append(Fault(pairs[0][1], message))


def _content(file: FileRead, block: Block, measured: Collection[str]) -> bytes | None:
    """Return what two files have in common if they are copies; None for a file that may have the same rows as another one."""
    columns, rule = file.rows.columns, file.rule
    by_name = "pose" in block.columns and block.columns["pose"].reference == FILE_NUMBER
    ignored = {SCAN, *rule.text, *rule.covariates, *(["pose"] if by_name else [])}
    content = hashlib.sha256(repr(file.rows.midnight).encode())
    for name in sorted(columns.keys() - ignored):
        content.update(name.encode())
        content.update(_bytes(columns[name]))
    here = [name for name in measured if name in columns]
    if here:
        numbers = sum(int(np.isfinite(columns[name]).sum()) for name in here)
        return content.digest() if numbers >= _LEAST_NUMBERS else None
    if by_name:
        return None
    if "pose" in block.columns:
        content.update(_bytes(file.poses))
    elif "time" not in block.columns:  # a probe, whose measurements are its joint angles
        content.update(repr((rule.text, rule.covariates)).encode())
    return content.digest()


def _bytes(values: Array) -> bytes:
    """Return the content of a column."""
    return "\0".join(map(str, values)).encode() if values.dtype == object else values.tobytes()
