"""Which paragraphs on errors stand at the head of the report, and the first words of the others, in bold, so that one finds what is looked for."""

from __future__ import annotations

import re

_LEAD_IN = re.compile(
    r"By its data sheet|On poses that took no part in the diagnosis|Where nothing was measured"
    r"|When each of \d+ regions of the joint space is held out as a whole|Measured over a small part of the joint limits"
    r"|Use after\.json (?:only at poses like those that were measured|within the ranges of the joints that were measured)|Not confirmed"
)

_WARNINGS = "Take care", "after.json is the model without", "Use after.json only"


def is_warning(text: str) -> bool:
    """Return whether a paragraph says that a correction may do harm, or is not made: it stands at the head of the report, in bold."""
    return text.startswith(_WARNINGS)


def lead_in(text: str) -> tuple[str, str]:
    """Return the first words of a paragraph that say what it is about, and the rest; the first is empty if they are none of the usual ones."""
    found = _LEAD_IN.match(text)
    end = found.end() if found else 0
    return text[:end], text[end:]
