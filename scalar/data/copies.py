"""Poses that repeat another one with its measurements to the last digit, which noise never does: one of them is a copy."""

from __future__ import annotations

from collections.abc import Hashable, Iterable


def copies_in_words(contents: Iterable[tuple[int, Hashable]]) -> str:
    """Return a clause that names the first two poses with the same content and counts further such pairs; empty if there are none.

    Args:
        contents: The number of each pose, and its joint angles with its measurements.
    """
    first: dict[Hashable, int] = {}
    pairs = [(same, pose) for pose, content in contents if (same := first.setdefault(content, pose)) != pose]
    if not pairs:
        return ""
    one, other = pairs[0]
    more = f", and {len(pairs) - 1} more such pairs" if len(pairs) > 1 else ""
    return f"poses {one} and {other} have the same joint angles and measurements to the last digit{more}"
