"""The published curves as runs, one for each point: its setting, and the logarithms of its four errors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from scalar.geometry.se3 import Array
from scalar.units import MM
from study.common.statistics import QUANTITIES


@dataclass(frozen=True)
class Setting:
    """The setting of a run.

    Attributes:
        poses: On all planes. points: A scan. sigma: Stated noise of a point [m].
        offset: Of the initial guesses of the planes [m]. tilt: Of the initial guesses of the planes [deg].
    """

    poses: int
    points: int
    sigma: float
    offset: float
    tilt: float

    @property
    def design(self) -> tuple[int, int]:
        """Return poses and points, on which the derivatives depend."""
        return self.poses, self.points


@dataclass(frozen=True, eq=False)
class Curves:
    """The runs that are weighed, and those that are not.

    Attributes:
        table: Rows of published_curves.csv that are used, in its order. left_out: The others, with a ``reason``.
        settings: Of each row used. log_errors: ``(R, 4)``, natural logarithm of mm and degrees, by ``QUANTITIES``.
    """

    table: pd.DataFrame
    left_out: pd.DataFrame
    settings: tuple[Setting, ...]
    log_errors: Array


LEFT_OUT = "left out by the config"
"""The reason of a run that could be weighed and is not."""

# The field of Setting that each published sweep varies, and its unit in SI (degrees stay degrees).
_VARIED: dict[str, tuple[str, float]] = {
    "noise": ("sigma", MM),
    "poses": ("poses", 1.0),
    "points": ("points", 1.0),
    "plane_offset": ("offset", MM),
    "plane_tilt": ("tilt", 1.0),
}


def read_curves(
    table: pd.DataFrame, base: Setting, leave_out: Mapping[str, Sequence[float]], least_poses: int
) -> Curves:
    """Return the published runs about a base setting.

    Args:
        table: Of published_curves.csv.
        base: The setting of all that a sweep does not vary.
        leave_out: ``{sweep: values}`` that are not weighed.
        least_poses: Fewest poses that give as many equations as there are unknowns.
    """
    settings, used, dropped, reasons = [], [], [], []
    seen: set[tuple[float, ...]] = set()
    for row in table.to_dict("records"):
        name, unit = _VARIED[str(row["sweep"])]
        value = float(row["value"]) * unit
        fields = {**base.__dict__, name: int(value) if name in ("poses", "points") else value}
        setting = Setting(**fields)
        errors = tuple(float(row[name]) for name in QUANTITIES)
        if setting.poses < least_poses:
            reason = "fewer equations than unknowns"
        elif float(row["value"]) in map(float, leave_out.get(str(row["sweep"]), ())):
            reason = LEFT_OUT
        elif errors in seen:
            reason = "the same run as in another sweep"
        else:
            seen.add(errors)
            used.append(row)
            settings.append(setting)
            continue
        dropped.append(row)
        reasons.append(reason)
    left_out = pd.DataFrame(dropped, columns=table.columns).assign(reason=reasons)
    kept = pd.DataFrame(used, columns=table.columns)
    return Curves(kept, left_out, tuple(settings), np.log(kept[list(QUANTITIES)].to_numpy(dtype=float)))
