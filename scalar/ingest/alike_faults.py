"""The same fault in many files: a scanner that saves each profile in its own file writes all alike, and one change of the mapping mends all."""

from __future__ import annotations

from collections import Counter

from scalar.errors import Fault

MOST_FILES = 3
"""Files that are listed with the same fault; one more fault counts the others."""


def named_once(faults: list[Fault]) -> list[Fault]:
    """Return the faults; of those that say the same of more than ``MOST_FILES`` files the first so many, and one more that counts the other files.

    Args:
        faults: In the order in which they are to be read.
    """
    files = Counter((f.message, f.row, f.column) for f in dict.fromkeys(faults))
    kept: list[Fault] = []
    kept_alike: Counter[tuple[str, int | None, str | None]] = Counter()
    for fault in faults:
        same = (fault.message, fault.row, fault.column)
        kept_alike[same] += 1
        if kept_alike[same] <= MOST_FILES or files[same] <= MOST_FILES:
            kept.append(fault)
        elif kept_alike[same] == MOST_FILES + 1:
            rest = files[same] - MOST_FILES
            kept.append(
                Fault(
                    fault.file,
                    f"the same in this file{f' and {rest - 1} more' if rest > 1 else ''}: {fault.message}",
                    fault.row,
                    fault.column,
                )
            )
    return kept
