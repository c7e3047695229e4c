"""A scanner's mark for "no value" that was left in a table of points, and a tracker's origin in place of a measurement."""

import numpy as np

from scalar.data.located_table import Table
from scalar.data.sensor_formats import MeasuredTable
from scalar.errors import Fault

LEAST_MARKED_SCANS = 3  # with a number that may stand for "no value"; in fewer, it may be a coincidence
DISTINCT = 0.2  # least share of distinct numbers in a column of which one may be such a mark
_SHOWN = 6  # rows that a message lists
_AT_A_SOCKET = 3  # rows for each place in the mean; where a target was not seen in some rows, nearly all others are places of their own
FAR_MARK = 0.1  # least distance of such a number from all others of its column, as a share of their range

_A_MARK = (
    "a scanner's mark for 'no value'? Leave these points out (of an import by text.missing, with the number as the file writes it, and drop_without "
    "in the mapping)"
)


def mark_beyond(values: np.ndarray, unit: str, bound: float) -> str:
    """Return the message about a number that alone, and several times, is beyond the bound of a scanner's column; empty if there is none.

    Args:
        values: ``(N,)``, the column; most of its numbers are within the bound if one stands for "no value".
        unit: Of the column.
        bound: The largest size of a measured number.
    """
    beyond = values[np.abs(values) > bound]
    if not 1 < len(beyond) < len(values) - len(beyond) or np.any(beyond != beyond[0]):
        return ""
    return f"suspect: {beyond[0]:g} {unit} stands in {len(beyond)} of {len(values)} points, too far away to be measured: {_A_MARK}"


def suspect_marks(points: Table, layout: MeasuredTable, faults: list[Fault]) -> None:
    """Add a fault for each column of scans with a number that stands for "no value".

    Scanners write such a mark, 0 or -99.9999 for example, for points that they did not see. All such points of a scan lie on one line, so that a fit
    cannot distinguish them from a second surface.
    """
    pose = points.columns["pose"]
    for name, unit in layout.units.items():
        named = any(fault.column == name and fault.message.endswith(_A_MARK) for fault in faults)
        if unit != "m" or name not in points.columns or named:
            continue
        values = np.nan_to_num(points.columns[name], nan=0.0, posinf=0.0, neginf=0.0)
        for extreme in dict.fromkeys((float(values.min()), float(values.max()))):
            marked = values == extreme
            if _is_mark(extreme, values[~marked], pose[marked], pose[~marked]):
                message = (
                    f"suspect: {extreme:g} {unit} stands in {marked.sum()} points of {len(np.unique(pose[marked]))} scans, far from all others: "
                    f"{_A_MARK}"
                )
                row = int(points.line_numbers()[np.argmax(marked)])
                faults.append(Fault(points.file, message, row, name))


def suspect_origins(points: Table, layout: MeasuredTable, faults: list[Fault]) -> None:
    """Add a fault if coordinates are all exactly 0: the origin of the instrument, where no target can be, which it writes when it did not see one.

    In the first row alone, they are taken for the place from which all others count. They are a place among others where a ball returns to few places
    that are stated exactly, as to the sockets of a plate.
    """
    lengths = [name for name, unit in layout.units.items() if unit == "m" and name in points.columns]
    if len(lengths) < len(layout.units):
        return
    zero = np.all([points.columns[name] == 0.0 for name in lengths], axis=0)
    places = np.unique(np.column_stack([points.columns[name] for name in lengths]), axis=0)
    if zero[1:].any() and not zero.all() and len(places) * _AT_A_SOCKET > len(zero):
        lines = [int(line) for line in points.line_numbers()[zero]]
        shown = ", ".join(map(str, lines[:_SHOWN])) + (", ..." if len(lines) > _SHOWN else "")
        message = (
            f"suspect: {', '.join(lengths)} are all exactly 0 in {len(lines)} of {len(zero)} rows ({shown}), which is the origin of the instrument: "
            f"was the target not seen there? Leave these rows out (of an import by drop_zeros: [{', '.join(lengths)}] in the mapping). If the target "
            "did stand there, because positions count from it, add the same length to one coordinate of all rows (in an import by offset: 100 of its "
            "column in the mapping)"
        )
        faults.append(Fault(points.file, message, lines[0], lengths[0]))


def _is_mark(number: float, others: np.ndarray, pose: np.ndarray, pose_of_others: np.ndarray) -> bool:
    """Return whether a number stands for "no value": it is far from all others, and occurs in several scans, which hold more other numbers.

    Args:
        number: The least or the largest number of a column.
        others: ``(M,)``, the numbers of the column that differ from it.
        pose: The poses at which the number stands, once for each time.
        pose_of_others: ``(M,)``, the poses of the others.
    """
    scans = np.unique(pose)
    if len(scans) < LEAST_MARKED_SCANS or not len(others):
        return False
    in_these = pose_of_others[np.isin(pose_of_others, scans)]
    if len(pose) >= len(in_these) or len(np.unique(in_these)) < len(scans):
        return False
    if np.min(np.abs(others - number)) <= FAR_MARK * np.ptp(others):
        return False
    # Where all numbers repeat, the rays are at the same places in every scan.
    return len(np.unique(others)) >= DISTINCT * len(others)
