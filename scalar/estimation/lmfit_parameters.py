"""Convert between a model's coordinates and parameters of lmfit; a name that lmfit does not take is changed."""

from __future__ import annotations

import keyword
import re
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from scalar.geometry.se3 import Array

if TYPE_CHECKING:
    import lmfit


def lmfit_names(names: Sequence[str]) -> list[str]:
    """Return the names with every character that lmfit cannot take replaced, still unique."""
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

    return [lmfit.Parameter(name, value=float(x)) for name, x in zip(lmfit_names(names), values, strict=True)]


def from_lmfit(parameters: lmfit.Parameters) -> Array:
    """Return the values of lmfit parameters, in their order."""
    return np.array([parameter.value for parameter in parameters.values()])
