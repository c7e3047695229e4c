"""Errors of the positions that an instrument measures, as effects on points add them to the rows."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from scalar.geometry.se3 import Array
from scalar.sensors.target import Target


def with_position_errors(
    rows: Array, effects: Sequence[Any], T_base_sensor: Array, target: Target, index: Array, y: Array
) -> tuple[Array, Array]:
    """Return rows with what effects on points add to them, and the derivatives by their coefficients.

    Args:
        rows: ``(N, m)`` [m, rad], unweighted: three of each of K targets, then those of orientations, to which nothing is added.
        effects: Effects on points, bound to the poses.
        T_base_sensor: ``(N, 4, 4)``.
        target: What is measured.
        index: ``(N,)``, the session of each pose.
        y: ``(N, K, 3)`` [m], the measured positions; NaN where none was measured.

    Returns:
        Rows ``(N, m)`` and derivatives ``(N, m, e)``, for e coefficients in all.
    """
    if not effects:
        return rows, np.zeros((*rows.shape, 0))
    places = y.reshape(len(y), -1)
    each = [effect.contact_columns(T_base_sensor, target, index, places) for effect in effects]
    columns = np.nan_to_num(np.concatenate(each, axis=2))
    columns = np.pad(columns, ((0, 0), (0, rows.shape[1] - columns.shape[1]), (0, 0)))
    return rows + columns @ np.concatenate([effect.coefficients for effect in effects]), columns
