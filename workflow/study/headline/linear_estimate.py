"""Compute the errors of the linear estimate of the scanner's pose, from which the original paper's fit starts (its Section III-A).

The estimate is made from the scans of the most level plane, with the nominal arm and the initial guess of that plane. For comparison, the errors of
the pose that the dataset declares are given too, from which the proposed method may start instead.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from scalar.baseline.fit import first_guess
from scalar.data.dataset import read_dataset
from scalar.geometry.se3 import Array, exp_so3, rotation_angle
from scalar.sensors import as_scans, measure
from scalar.units import DEG, MM
from study.common.seeds import found_seeds
from study.common.statistics import summary_statistics

LINEAR, DECLARED = "linear", "declared"


def linear_estimates(data_dirs: Sequence[str | Path]) -> pd.DataFrame:
    """Return the errors of the scanner's pose on the flange: columns ``seed, start, position_mm, orientation_deg``.

    ``start`` is ``linear`` or ``declared``; a dataset that declares no pose has no row for it.

    Args:
        data_dirs: Folders of simulated datasets, one for each batch, as ``simulate_seeds`` wrote them.

    Raises:
        Undetermined: The scans of the most level plane determine no linear estimate, and no pose is declared.
    """
    rows: list[dict[str, Any]] = []
    for seed, folder in sorted(found for data_dir in data_dirs for found in found_seeds(data_dir)):
        dataset = read_dataset(folder / "dataset")
        truth = json.loads((folder / "truth/truth.json").read_text(encoding="utf-8"))["parameters"]
        measurement = as_scans(measure(dataset))
        starts: dict[str, Array | None] = {
            LINEAR: first_guess(dataset, measurement, measurement.initial_target(dataset))[0],
            DECLARED: dataset.sensor.T_flange_sensor,
        }
        t, r = (np.array(truth[name], dtype=float) for name in ("t", "r"))
        rows += [
            {
                "seed": seed,
                "start": name,
                "position_mm": float(np.linalg.norm(T[:3, 3] - t)) / MM,
                "orientation_deg": float(rotation_angle(exp_so3(r).T @ T[:3, :3])) / DEG,
            }
            for name, T in starts.items()
            if T is not None
        ]
    return pd.DataFrame(rows)


def estimate_numbers(table: pd.DataFrame) -> dict[str, Any]:
    """Return statistics over the seeds: ``{start: {"position_mm": {...}, "orientation_deg": {...}}}``."""
    return {
        str(start): {
            name: summary_statistics(rows[name].to_numpy(dtype=float))
            for name in ("position_mm", "orientation_deg")
        }
        for start, rows in table.groupby("start", sort=False)
    }
