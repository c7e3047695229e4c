"""Convert between a model's coordinates and parameters of lmfit; a name that lmfit does not take is changed."""

from __future__ import annotations

import keyword
import re
from collections.abc import Sequence
from functools import cache, lru_cache
from typing import TYPE_CHECKING

import numpy as np

from scalar.geometry.se3 import Array

if TYPE_CHECKING:
    import lmfit


def lmfit_names(names: Sequence[str]) -> list[str]:
    """Return the names with every character that lmfit cannot take replaced, still unique."""
    return list(_safe_names(tuple(names)))


@lru_cache
def _safe_names(names: tuple[str, ...]) -> list[str]:
    """Return what ``lmfit_names`` returns; fits of one arm ask for the same names again and again."""
    safe: list[str] = []
    taken: set[str] = set()
    for name in names:
        candidate = re.sub(r"\W", "_", name, flags=re.ASCII)
        if keyword.iskeyword(candidate) or not re.match(r"[A-Za-z_]", candidate):
            candidate = "_" + candidate
        unique, count = candidate, 1
        while unique in taken:
            count += 1
            unique = f"{candidate}_{count}"
        taken.add(unique)
        safe.append(unique)
    return safe


def to_lmfit(names: Sequence[str], values: Array) -> list[lmfit.Parameter]:
    """Return free lmfit parameters of the given names and values.

    They are returned as a list, which lmfit's Minimizer takes as it is. A ``Parameters`` object it would copy deeply, which costs a tenth
    of a fit.
    """
    import lmfit  # slow to import, and the names need none of it

    return [_parameter(lmfit.Parameter, name, x) for name, x in zip(lmfit_names(names), values, strict=True)]


@cache
def _unbounded(kind: type[lmfit.Parameter]) -> lmfit.Parameter:
    """Return a parameter without bounds of which others are copies."""
    return kind("x", value=0.0)


def _parameter(kind: type[lmfit.Parameter], name: str, value: float) -> lmfit.Parameter:
    """Return a free parameter of lmfit as its constructor does, which spends seven eighths of its time on bounds that are not there."""
    found = kind.__new__(kind)
    vars(found).update(
        {key: list(kept) if isinstance(kept, list) else kept for key, kept in vars(_unbounded(kind)).items()}
    )
    found.name, found.value, found.init_value = name, float(value), float(value)
    return found


def from_lmfit(parameters: lmfit.Parameters) -> Array:
    """Return the values of lmfit parameters, in their order."""
    return np.array([parameter.value for parameter in parameters.values()])
