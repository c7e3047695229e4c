"""The variants of the settings: every threshold halved and doubled, one at a time, and all at once as traced numbers."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from scalar.diagnosis.settings import DEFAULTS, Settings
from scalar.estimation.settings import changed, documentation
from study.sensitivity.traced import Trace, Traced

HALVED, DOUBLED = "halved", "doubled"
DIRECTIONS = (HALVED, DOUBLED)


@dataclass(frozen=True)
class Variant:
    """One threshold with another value.

    Attributes:
        setting: Its dotted name.
        direction: ``halved`` or ``doubled``.
        value: The changed value.
    """

    setting: str
    direction: str
    value: float

    @property
    def settings(self) -> Settings:
        """Return the settings with this threshold changed."""
        return changed(DEFAULTS, {self.setting: self.value})


def variants(names: Iterable[str] | None = None) -> list[Variant]:
    """Return the variants of the named settings, or of all; settings whose value is True, False or None have none."""
    found = []
    for name, entry in documentation(DEFAULTS).items():
        value = entry["value"]
        if (names is not None and name not in names) or isinstance(value, bool) or value is None:
            continue
        for direction in DIRECTIONS:
            other = halved(value) if direction == HALVED else doubled(value, entry["unit"])
            if other != value:
                found.append(Variant(name, direction, other))
    return found


def halved(value: float) -> float:
    """Return half of a number; half of a count is rounded up, so that at least one is left."""
    return math.ceil(value / 2) if isinstance(value, int) else value / 2


def doubled(value: float, unit: str) -> float:
    """Return twice a number; a share or a chance that would leave its range goes half-way to one instead.

    Args:
        value: The number.
        unit: Its unit; that of a share is ``1`` or begins with ``of``.
    """
    if isinstance(value, int):
        return 2 * value
    is_share = value < 1.0 and (unit == "1" or unit.startswith("of "))
    return (1.0 + value) / 2 if is_share and 2 * value >= 1.0 else 2 * value


def traced_settings(wanted: Iterable[Variant], trace: Trace) -> Settings:
    """Return the default settings with every threshold of the variants traced: its alternatives are the variants' values, by variant."""
    alternatives: dict[str, dict[Any, Any]] = {}
    for variant in wanted:
        alternatives.setdefault(variant.setting, {})[variant] = variant.value
    values = documentation(DEFAULTS)
    return changed(
        DEFAULTS,
        {name: Traced(values[name]["value"], others, trace) for name, others in alternatives.items()},
    )
