"""Fit the baseline at the published settings with walls that lean by up to three degrees, and with roots of negative numbers passed on as NaN.

The original paper does not say how upright its walls were, nor what its solver did with the square root of a negative number. The support of a
*reading* of that root (a variant of the baseline) may depend on both, so every reading is fitted in the same workcell with its walls turned.
"""

from __future__ import annotations

import tempfile
from collections.abc import Mapping, Sequence
from math import cos, hypot, sin
from pathlib import Path
from typing import Any

import pandas as pd
import yaml

from scalar.units import DEG
from study.common.scene_config import is_wall
from study.published_curves.curves import Curves, Setting
from study.published_curves.predict import runs_to_weigh
from study.sweeps.plans import write_plans
from study.sweeps.run import sweep_cases

LEANS_DEG = (0.0, 0.5, 1.0, 2.0, 3.0)
"""Angles by which the walls lean, if the config states none."""
READINGS = {
    "baseline-abs": "√|·|",
    "baseline-abs-2018": "√|·|, lmfit of 2018",
    "baseline-clip": "√max(0, ·)",
    "baseline-nan": "NaN passed on",
    "baseline-nan-2018": "NaN passed on, lmfit of 2018",
}
"""Methods that are fitted, with their labels."""


def leaning(config: Mapping[str, Any], lean_deg: float) -> dict[str, Any]:
    """Return a scene config whose walls lean by an angle [deg] about their horizontal axes, with the same distances from the base.

    By turns one wall leans towards the arm and the next one away from it, as in configs/scenes/paper_tilted.yaml.
    """
    planes, sign = [], 1.0
    for plane in config["planes"]:
        if is_wall(plane):
            x, y, _ = plane["normal"]
            level = cos(lean_deg * DEG) / hypot(x, y)
            planes.append({**plane, "normal": [level * x, level * y, sign * sin(lean_deg * DEG)]})
            sign = -sign
        else:
            planes.append(plane)
    return {**config, "planes": planes}


def all_runs(config: Mapping[str, Any], published: pd.DataFrame, options: Mapping[str, Any]) -> Curves:
    """Return the published runs that have enough equations, with those that the config leaves out of the weighing."""
    return runs_to_weigh(config, published, {**options, "leave_out": {}})


def overrides(setting: Setting, planes: int) -> dict[str, Any]:
    """Return the overrides ``{dotted key: value}`` that give a scene the setting of a published run, for a number of planes."""
    return {
        "poses_per_plane": setting.poses // planes,
        "sensor.points_per_scan": setting.points,
        "noise.range_noise_std_m": setting.sigma,
        "plane_guess.offset_m": setting.offset,
        "plane_guess.tilt_deg": setting.tilt,
    }


def fit_leaning_walls(
    scene: str | Path,
    published: pd.DataFrame,
    options: Mapping[str, Any],
    lean_deg: float,
    seeds: Sequence[int],
) -> pd.DataFrame:
    """Return the raw errors of every reading at every published setting: a row for each run, seed and method.

    Args:
        scene: Config file of the original paper's workcell.
        published: published_curves.csv.
        options: The config's block ``published_curves``.
        lean_deg: Angle by which the walls lean [deg].
        seeds: Seeds of the workcells.

    Raises:
        InvalidInput: The scene is at fault.
        SimulationError: Too few postures see a target plane.
    """
    from scalar.simulation.config import load_config

    config = leaning(load_config(Path(scene)), lean_deg)
    curves = all_runs(config, published, options)
    planes = len(config["planes"])
    cases = {str(i): overrides(setting, planes) for i, setting in enumerate(curves.settings)}
    most = max(setting.poses for setting in curves.settings) // planes
    with tempfile.TemporaryDirectory() as folder:
        turned, plans = Path(folder) / "scene.yaml", Path(folder) / "plans.npz"
        turned.write_text(yaml.safe_dump(config, allow_unicode=True), encoding="utf-8")
        write_plans(turned, most, seeds, plans)
        table = sweep_cases(cases, {"leaning": turned}, seeds, list(READINGS), {"leaning": plans})
    run = table["case"].astype(int).to_numpy()
    of_run = pd.DataFrame(
        {
            "lean_deg": lean_deg,
            "sweep": curves.table["sweep"].to_numpy()[run],
            "value": curves.table["value"].to_numpy()[run],
        }
    )
    table = pd.concat([of_run, table.drop(columns="case")], axis=1)
    rows: Any = table[(table["alignment"] == "raw") & table["method"].isin(list(READINGS))]
    return rows.reset_index(drop=True)
