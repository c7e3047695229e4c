"""How much memory the arrays take that an object holds, itself or through others."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np


def held_bytes(thing: Any, counted: set[int]) -> int:
    """Return the size of the arrays that an object of this package or a container of such objects holds, each counted once [bytes].

    A view counts as the whole array that it keeps in memory. Objects of other packages, tables for example, are not looked into.

    Args:
        thing: The object.
        counted: ``id`` of what counts no longer; what is counted here is added, so these objects must live as long as the set is used.
    """
    total, waiting = 0, [thing]
    while waiting:
        each = waiting.pop()
        if isinstance(each, np.ndarray):
            each = _owner(each)
        if each is None or id(each) in counted:
            continue
        counted.add(id(each))
        if isinstance(each, np.ndarray):
            total += each.nbytes
        else:
            waiting.extend(_parts(each))
    return total


def _owner(array: np.ndarray) -> np.ndarray:
    """Return the array in whose memory a view lies."""
    while isinstance(array.base, np.ndarray):
        array = array.base
    return array


def _parts(thing: Any) -> Iterable[Any]:
    """Return what a container or an object of this package refers to."""
    own: list[Any] = []
    if isinstance(thing, dict):
        own += thing.values()
    elif isinstance(thing, (list, tuple, set)):
        own += thing
    if type(thing).__module__.partition(".")[0] == __name__.partition(".")[0]:
        own += getattr(thing, "__dict__", {}).values()
    return own
