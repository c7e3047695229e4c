"""Names of poses, such as ``P017`` or ``PR[17]``, alike but for one whole number, which stands for the pose."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence

from scalar.data.located_table import shorten

_NAME = re.compile("([^0-9]+)([0-9]+)([^0-9]*)")
_LEAST_SHARE = 0.5  # of the names, which the most frequent kind has to have to be proposed


def numbers_of_names(names: Sequence[str]) -> list[float] | None:
    """Return the number in each name if all are alike but for it; else None."""
    found = [match for match in map(_NAME.fullmatch, names) if match]
    if len(found) < len(names) or len(set(map(_words, found))) != 1:
        return None
    return [float(match[2]) for match in found]


def several_kinds(names: Sequence[str], column: str) -> str | None:
    """Return what to do where names are of several kinds, as P1, P2 and REF1, of which one prevails; None if they are not."""
    found = [match for match in map(_NAME.fullmatch, names) if match]
    kinds = Counter(map(_words, found))
    if not kinds:
        return None
    usual, times = kinds.most_common(1)[0]
    if times == len(names) or times < _LEAST_SHARE * len(names):
        return None
    other = next(name for name in names if not (match := _NAME.fullmatch(name)) or _words(match) != usual)
    before = next(match[1] for match in found if _words(match) == usual)
    # A sign that has a meaning in patterns stands in brackets.
    pattern = re.sub(r"([\[*?])", r"[\1]", before) + "[0-9]*"
    return (
        f"{len(names) - times} of {len(names)} names are of another kind than the rest ({shorten(other)}); if they are no poses, leave them out by "
        f"rows_like: {{{column}: '{pattern}'}} in the mapping"
    )


def _words(match: re.Match[str]) -> tuple[str, str]:
    return match[1].rstrip("-+"), match[3]
