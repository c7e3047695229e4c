"""Whether two scans were given to one pose: both would be taken for one profile, with two surfaces in it.

A pose may have several profiles if all poses have equally many, as where a scanner repeats each profile. A pose with more of them than the
others has a copy, or the scan of another pose whose number is wrong. Of files that each hold one profile, no two belong to one pose.
"""

import numpy as np

from scalar.errors import Fault
from scalar.geometry.se3 import Array
from scalar.ingest.imported_table import ImportedTable
from scalar.ingest.mapping import Block
from scalar.ingest.raw_table import FILE_NUMBER, ROW, RawTable

SCAN = "_scan"
"""The column of a table that is being read which says to which profile a point belongs; it is taken out before the table is written."""


def number_scans(raw: RawTable, block: Block, first: int) -> Array | None:
    """Return the number of the scan of each row of a file ``(N,)``, counted from `first`; None if the file does not show which rows are one scan."""
    if block.row_profiles is not None or block.column_profiles is not None:
        return first + np.asarray(raw.cells[raw.find(ROW)], dtype=float)
    return np.full(len(raw.lines), float(first)) if _of_files(block) else None


def report_merged(points: ImportedTable, block: Block, faults: list[Fault]) -> None:
    """Add a fault for each pose with more scans than the others, and take the column of scans out of the table."""
    scans = points.columns.pop(SCAN, None)
    pose = points.columns.get("pose")
    if scans is None or pose is None or not points.n_rows:
        return
    _, first = np.unique(np.stack([pose, scans]), axis=1, return_index=True)
    first = np.sort(first)
    poses, times = np.unique(pose[first], return_counts=True)
    usual = 1 if _of_files(block) else int(np.median(times))
    beyond = np.zeros(points.n_rows, dtype=bool)
    places: dict[float, list[str]] = {}
    lines = points.line_numbers()
    for number in poses[times > usual]:
        own = first[pose[first] == number]
        beyond[own[-1]] = True
        places[float(number)] = [
            str(points.files[i]) if _of_files(block) else f"{points.files[i]} row {lines[i]}" for i in own
        ]

    def message(i: int) -> str:
        own = places[float(pose[i])]
        what = f"pose {pose[i]:.15g} has {len(own)} scans ({', '.join(own)})"
        others = "" if usual == 1 else f", and most poses have {usual}"
        return f"{what}{others}: a copy, or a wrong number? Leave out the one that does not belong there"

    points.report(faults, "pose", beyond, message)


def _of_files(block: Block) -> bool:
    """Return whether each file is one scan: its name says to which pose its points belong, and it has a row for each point."""
    by_name = "pose" in block.columns and block.columns["pose"].reference == FILE_NUMBER
    return by_name and block.row_profiles is None and block.column_profiles is None
