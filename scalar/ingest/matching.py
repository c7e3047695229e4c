"""Which points belong to which pose, where tables do not have the same numbers: by time, or with poses and points left over."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from scalar.errors import Fault
from scalar.geometry.se3 import Array
from scalar.ingest.clocks import better_correction
from scalar.ingest.imported_table import MEASURED_AT, ImportedTable, select_rows
from scalar.ingest.left_out import LeftOut, left_out_rows

_BOTH = "write dates with times in both files, or times of day or seconds in both"


@dataclass(frozen=True)
class NearestTime:
    """How points are given to the poses that are nearest in time.

    Attributes:
        column: The file's column of times.
        within: The longest time between a pose and its points [s].
        add: What is added to the times of the points, where their clock differs from that of the poses [s].
    """

    column: str | int
    within: float
    add: float = 0.0

    @classmethod
    def of(cls, content: Mapping[str, Any] | None) -> NearestTime | None:
        """Return what the key ``nearest_time`` of a mapping says, or None without it."""
        return None if content is None else cls(**content)


def give_to_nearest(
    points: ImportedTable,
    poses: ImportedTable,
    rule: NearestTime,
    faults: list[Fault],
    left_out: list[LeftOut],
) -> ImportedTable:
    """Return the points with the number of the pose that is nearest in time; those without a pose are left out and noted.

    A fault is added if no point has a pose, if a point lies so near two poses in time that nothing says to which it belongs, or if another
    correction of the clock lets all points come with one delay after a pose.
    """
    time = points.columns.pop(MEASURED_AT) + rule.add
    if (poses.midnight is None) != (points.midnight is None):
        faults.append(Fault(points.file, f"one table states the date and the other does not; {_BOTH}"))
        return points
    time = time + ((points.midnight or 0.0) - (poses.midnight or 0.0))
    by_time = np.argsort(poses.columns["time"], kind="stable")
    clock, numbers = poses.columns["time"][by_time], poses.columns["pose"][by_time]
    # A scanner has some hundred thousand points: each is compared with its neighbours in time alone.
    later = np.clip(np.searchsorted(clock, time), 1, max(len(clock) - 1, 1))
    earlier, later = later - 1, np.minimum(later, len(clock) - 1)
    nearest = np.where(time - clock[earlier] <= clock[later] - time, earlier, later)
    count = np.searchsorted(clock, time + rule.within, "right") - np.searchsorted(clock, time - rule.within)
    label = points.labels.get(MEASURED_AT, "time")
    points = replace(points, labels={**points.labels, "pose": label})
    points.columns["pose"] = numbers[nearest]
    if not count.any():
        least = float(np.min(np.abs(time - clock[nearest])))
        far = (
            f"no row lies within {rule.within:g} s of a pose; the shortest time between the two tables is {least:.6g} s: do their clocks stand in "
            "the same time zone? Correct them by points.nearest_time.add, or write a longer points.nearest_time.within"
        )
        faults.append(Fault(points.file, far, column=label))
        return points

    def message(i: int) -> str:
        two = " and ".join(f"{numbers[k]:.15g}" for k in np.sort(np.argsort(np.abs(time[i] - clock))[:2]))
        return (
            f"lies within {rule.within:g} s of two poses, {two}; write a shorter points.nearest_time.within"
        )

    points.report(faults, "pose", count > 1, message)
    _report_other_clock(points, time, clock, rule, label, faults)
    none = count == 0
    left_out[:0] = left_out_rows(points, none, f"not within {rule.within:g} s of a pose (nearest_time)")
    return select_rows(points, ~none)


def _report_other_clock(
    points: ImportedTable,
    time: Array,
    clock: Array,
    rule: NearestTime,
    label: str,
    faults: list[Fault],
) -> None:
    """Add a fault for each file whose points come with one delay after a pose if its clock is corrected, and now do not."""
    target = points.columns.get("target", np.zeros(points.n_rows)).astype(str)
    for file in dict.fromkeys(points.files):
        rows = np.flatnonzero(points.files == file)
        if (better := better_correction(time[rows], clock, target[rows])) is None:
            continue
        shift, now, then = better
        text = (
            "its points are probably given to other poses than those at which they were measured: the delay between a pose and its points scatters "
            f"by {now:.2g} s, and by {then:.2g} s if points.nearest_time.add is {rule.add + shift:.6g}. Look at the clocks, and correct this one"
        )
        faults.append(Fault(str(file), text, column=label))


def keep_matched(
    poses: ImportedTable, points: ImportedTable, left_out: list[LeftOut]
) -> tuple[ImportedTable, ImportedTable]:
    """Return the poses that have points, and the points whose pose is known; the others are noted."""
    measured = np.asarray(np.isin(poses.columns["pose"], points.columns["pose"]))
    known = np.asarray(np.isin(points.columns["pose"], poses.columns["pose"]))
    if not measured.any():  # the check of both tables says what is wrong
        return poses, points
    without_points = left_out_rows(poses, ~measured, "poses without points (matched_only)")
    without_pose = left_out_rows(points, ~known, "points without a pose (matched_only)")
    left_out[:0] = [*without_points, *without_pose]  # they matter most
    return select_rows(poses, measured), select_rows(points, known)
