"""The first words of the paragraphs on errors, by which a report orders them and sets the words that say what a paragraph is about in bold.

The modules that write these paragraphs begin them with these words.
"""

from __future__ import annotations

import re

BY_DATA_SHEET = "By its data sheet"
ON_UNSEEN_POSES = "On poses that took no part in the diagnosis"
WHERE_UNMEASURED = "Where nothing was measured"
SMALL_RANGES = "Measured over a small part of the joint limits"
NOT_CONFIRMED = "Not confirmed"
IN_MEASURED_RANGES = "Use after.json within the ranges of the joints that were measured"

# The words of warnings: the correction may do harm, or is not made.
ONLY_LIKE_MEASURED = "Use after.json only at poses like those that were measured"
WITHOUT_EFFECTS = "after.json is the model without effects"
FITS_DISAGREE = "Take care"

_WARNINGS = ONLY_LIKE_MEASURED, WITHOUT_EFFECTS, FITS_DISAGREE
# What a paragraph on the regions of the joint space begins with, once their number is written into it.
REGIONS = "When each of {count} regions of the joint space is held out as a whole"

_FIXED = (
    BY_DATA_SHEET,
    ON_UNSEEN_POSES,
    WHERE_UNMEASURED,
    SMALL_RANGES,
    NOT_CONFIRMED,
    IN_MEASURED_RANGES,
    ONLY_LIKE_MEASURED,
)
_LEAD_IN = re.compile("|".join([*map(re.escape, _FIXED), REGIONS.format(count=r"\d+")]))


def is_warning(text: str) -> bool:
    """Return whether a paragraph says that a correction may do harm, or is not made: it stands at the head of the report, in bold."""
    return text.startswith(_WARNINGS)


def lead_in(text: str) -> tuple[str, str]:
    """Return the first words of a paragraph that say what it is about, and the rest; the first is empty if they are none of the usual ones."""
    found = _LEAD_IN.match(text)
    end = found.end() if found else 0
    return text[:end], text[end:]
