"""Keys and method names of configs that were renamed: an old name is refused with a message that states the new one."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

RENAMED_KEYS = {
    "closed_loop": "blind_trials",
    "first_loop": "published_curves",
    "other_cells": "other_workcells",
    "other_cell_seeds": "other_workcell_seeds",
    "cells": "workcells",
    "planted": "injected",
    "dirt": "gross_errors",
}
RENAMED_METHODS = {
    "manifold": "proposed",
    "published-abs": "baseline-abs",
    "published-abs-2018": "baseline-abs-2018",
    "published-clip": "baseline-clip",
    "published-raise": "baseline-raise",
}


def renamed_faults(config: Any, place: str = "") -> list[str]:
    """Return a message for every key and method of a config that was renamed, with its place.

    Args:
        config: Mappings and lists, as read from YAML.
        place: Path of ``config`` within the whole config, with dots.
    """
    return list(_faults(config, place))


def _faults(value: Any, place: str) -> Iterator[str]:
    if isinstance(value, dict):
        for key, item in value.items():
            where = f"{place}.{key}" if place else str(key)
            if key in RENAMED_KEYS:
                yield f"{where}: the key {key!r} is now called {RENAMED_KEYS[key]!r}; rename it"
            yield from _faults(item, where)
    elif isinstance(value, list):
        for k, item in enumerate(value):
            yield from _faults(item, f"{place}[{k}]")
    elif isinstance(value, str) and value in RENAMED_METHODS:
        yield f"{place}: the method {value!r} is now called {RENAMED_METHODS[value]!r}; rename it"
