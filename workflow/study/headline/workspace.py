"""Compute the correlations of one calibration's parameters, and a map of position errors over the workspace from many seeds."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from scalar.data.dataset import read_dataset
from scalar.data.io.plain_yaml import load_yaml
from scalar.estimation.result import Calibration, load_calibration
from scalar.evaluate import pose_errors, true_frames
from scalar.evaluate.truth import read_truth
from scalar.geometry.se3 import Array
from scalar.units import MM
from study.common.seeds import found_seeds
from study.headline.calibrate import FAILURE_FORMAT

BIN = 0.06  # m: side of a cell of the map
STATES = ("before_mm", "after_mm", "predicted_mm")
"""Errors that are mapped: those of the nominal model, of the calibrated one, and the standard error that the calibration states."""


def correlation(calibration: Calibration) -> pd.DataFrame:
    """Return the correlation matrix of the free parameters, with their names in the column ``parameter``; NaN where a standard error is zero."""
    std = np.sqrt(np.diag(calibration.covariance))
    with np.errstate(divide="ignore", invalid="ignore"):
        matrix = calibration.covariance / std / std[:, None]
    table = pd.DataFrame(matrix, columns=list(calibration.free))
    table.insert(0, "parameter", list(calibration.free))
    return table


def map_errors(
    data_dirs: Sequence[str | Path], calibration_dirs: Sequence[str | Path]
) -> tuple[pd.DataFrame, int]:
    """Return root mean square position errors over the seeds by place of the scanner, and the number of seeds.

    Args:
        data_dirs: A folder of simulated datasets for each batch, as ``simulate_seeds`` wrote it.
        calibration_dirs: The folders of their calibrations in the same order, as ``calibrate_seeds`` wrote them.

    Returns:
        Columns ``view, u_m, v_m, poses, before_mm, after_mm, predicted_mm``, with a row for each cell of the map that contains an evaluation pose.
        The coordinates u and v are the distance from the base's axis and the height in the view ``side``, and x and y in the view ``above``;
        ``u_m`` and ``v_m`` are those of the cell's middle. ``predicted_mm`` is the root of the mean trace of the covariance that the calibration
        states.
    """
    squares: list[Array] = []
    points = np.zeros((0, 3))
    for data, calibrations in zip(data_dirs, calibration_dirs, strict=True):
        for _, folder in found_seeds(data):
            path = Path(calibrations) / f"{folder.name}.json"
            if load_yaml(path).get("format") == FAILURE_FORMAT:
                continue
            dataset = read_dataset(folder / "dataset")
            truth_poses, _ = read_truth(folder / "truth", dataset.robot.n_joints)
            T_true = true_frames(truth_poses)
            calibration = load_calibration(path)
            both = (Calibration.nominal(dataset), calibration)
            errors = [pose_errors(T_true, model.predict(truth_poses)).position for model in both]
            squares.append(np.stack([*errors, calibration.predict_std(truth_poses)[0]]) ** 2)
            points = T_true[:, :3, 3]
    if not squares:
        return pd.DataFrame(columns=["view", "u_m", "v_m", "poses", *STATES]), 0
    mean_square = np.mean(squares, axis=0)
    side = np.column_stack([np.linalg.norm(points[:, :2], axis=1), points[:, 2]])
    views = {"side": side, "above": points[:, :2]}
    parts = [_binned(places, mean_square).assign(view=view) for view, places in views.items()]
    whole = pd.concat(parts, ignore_index=True).reindex(columns=["view", "u_m", "v_m", "poses", *STATES])
    return whole, len(squares)


def _binned(places: Array, mean_square: Array) -> pd.DataFrame:
    """Return the root mean square [mm] of the three ``STATES`` in each cell.

    Args:
        places: ``(N, 2)`` [m], the coordinates u and v of each pose.
        mean_square: ``(3, N)`` [m^2], mean over the seeds of the squared errors of each state.
    """
    cells = np.floor(places / BIN).astype(int)
    table = pd.DataFrame({"u": cells[:, 0], "v": cells[:, 1], **dict(zip(STATES, mean_square, strict=True))})
    grouped: Any = table.groupby(["u", "v"], sort=True)
    found = np.sqrt(grouped[list(STATES)].mean()) / MM
    found["poses"] = grouped.size()
    found = found.reset_index()
    return found.assign(u_m=(found["u"] + 0.5) * BIN, v_m=(found["v"] + 0.5) * BIN)
