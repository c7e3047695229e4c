"""Words of the report that do not belong to a single effect: titles of entries of diagnosis.json, columns, p-values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from scalar.effects import registry
from scalar.effects.title import titled
from scalar.effects.wording import (
    UNKNOWN,
    angle,
    coefficient,
    columns_in_words,
    length,
    listed,
    number,
    sized,
)

__all__ = [
    "CONFIDENCE",
    "angle",
    "capital",
    "chance",
    "coefficient",
    "columns_in_words",
    "confident",
    "length",
    "listed",
    "number",
    "quoted",
    "sized",
    "title",
]

LEAST_P_VALUE = 1e-12  # below it a p-value is not computed accurately
CONFIDENCE = (
    "Confidence is how often a name with such evidence was right in simulated trials: 80 % means that about 80 of 100 such names were right. "
    "If it is below 80 %, confirm the cause before anything is repaired."
)
"""The sentence that explains a confidence."""
_MOST_STATED = 0.995  # a larger confidence would be rounded to 100 %, and no name is certain
COMPONENTS = {
    "pose_jitter": "jitter of the joints from pose to pose",
    "scan_bias": "random offset of each measurement",
}
"""Titles of the variance components, by name."""


def confident(confidence: float) -> str:
    """Return a confidence, 0 to 1, in per cent: ``94 %``; ``above 99 %`` where it would be rounded to 100."""
    return "above 99 %" if confidence >= _MOST_STATED else f"{100 * confidence:.0f} %"


def title(name: str, target: Mapping[str, Any], depends_on: Sequence[str] = ()) -> str:
    """Return the title of an entry of diagnosis.json: its place, then its kind."""
    if name in COMPONENTS:
        return COMPONENTS[name]
    kinds = registry.known()
    return titled(kinds[name].kind or name if name in kinds else name, target, depends_on)


def chance(p: float | None) -> str:
    """Return a p-value as text: a number, or a bound if it is too small to be computed accurately."""
    if p is None or not np.isfinite(p):
        return UNKNOWN
    if p < LEAST_P_VALUE:
        return "< 10⁻¹²"
    return number(p, 2)


def quoted(title: str) -> str:
    """Return the title of an effect in quotation marks, for a sentence: titles have a colon."""
    return f"“{title}”"


def capital(text: str) -> str:
    """Return a text with its first letter in upper case."""
    return text[:1].upper() + text[1:]
