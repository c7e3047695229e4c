"""Tabulate which parameters the poses of one dataset determine: the singular values of the Jacobian, and every null direction in words."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd

from scalar.data.dataset import read_dataset
from scalar.estimation.prepare import prepare
from scalar.estimation.settings import DEFAULTS


def identifiability_tables(dataset_dir: str | Path) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return the singular values and the null directions of a dataset.

    Returns:
        The table ``index, singular_value, null, tolerance``: the singular values of the Jacobian with columns of unit length, divided by the
        largest, and whether each counts as zero (``null``), being below ``tolerance``. The table ``held, cause, moves_with, reason``: a row for
        each null direction, with the parameter that is fixed because of it (``held``) and those with which that one is confounded (``moves_with``).
    """
    found = prepare(read_dataset(dataset_dir)).identifiability
    values = pd.DataFrame(
        {
            "index": np.arange(1, len(found.singular_values) + 1),
            "singular_value": found.singular_values,
            "null": found.singular_values < DEFAULTS.identifiability.null_tolerance,
            "tolerance": DEFAULTS.identifiability.null_tolerance,
        }
    )
    directions = pd.DataFrame(
        [
            {
                "held": held.name,
                "cause": held.cause,
                "moves_with": " ".join(held.moves_with),
                "reason": held.reason,
            }
            for held in found.fixed
        ],
        columns=["held", "cause", "moves_with", "reason"],
    )
    return values, directions
