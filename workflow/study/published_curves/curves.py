"""Read the published curves as runs: each point of a curve is a run with its setting and the logarithms of its four errors."""

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
        poses: Number of poses on all planes together.
        points: Number of points in a scan.
        sigma: Stated noise of a point [m].
        offset: Offset of the initial guesses of the planes [m].
        tilt: Tilt of the initial guesses of the planes [deg].
    """

    poses: int
    points: int
    sigma: float
    offset: float
    tilt: float

    @property
    def design(self) -> tuple[int, int]:
        """Return the numbers of poses and of points in a scan, on which the Jacobian of a run depends."""
        return self.poses, self.points


@dataclass(frozen=True, eq=False)
class Curves:
    """The published runs that are used, and those that are not.

    Attributes:
        table: Rows of published_curves.csv that are used, in the order of the file.
        left_out: The other rows, with a column ``reason``.
        settings: The setting of each row that is used.
        log_errors: ``(R, 4)``, natural logarithms of the errors in mm and degrees, in the order of ``QUANTITIES``.
    """

    table: pd.DataFrame
    left_out: pd.DataFrame
    settings: tuple[Setting, ...]
    log_errors: Array


LEFT_OUT = "left out by the config"
"""The reason of a run that could be used and is not."""

# ``{sweep: (field of Setting that it varies, factor from the unit of the file to that of the field)}``
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
    """Return the published runs, of which each varies one field of a base setting.

    Args:
        table: published_curves.csv.
        base: The setting from which each sweep varies one field.
        leave_out: ``{sweep: values}`` of the runs that are not used.
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
