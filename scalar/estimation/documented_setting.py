"""A threshold with its documentation: the field of a frozen dataclass that says its unit, its meaning and the reason for its size."""

from __future__ import annotations

from dataclasses import field
from typing import Any


def setting(default: Any, unit: str, meaning: str, reason: str) -> Any:
    """Return the field of a threshold with its documentation, for a frozen dataclass.

    Args:
        default: Its value.
        unit: Of the value; ``1`` for a plain number.
        meaning: What it decides.
        reason: Its source, or why it was chosen so.
    """
    return field(default=default, metadata={"unit": unit, "meaning": meaning, "reason": reason})
