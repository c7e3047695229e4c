"""Tabulate the errors of all calibrations of one case against the truth: those of poses, planes and parameters.

Units are in the names of columns, or in a column ``unit`` if a table contains lengths and angles. A fit that
failed has rows with its status and without numbers in the table of pose errors, and none in the others.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from scalar.data.dataset import read_dataset
from scalar.estimation.result import Calibration, load_calibration
from scalar.evaluate import Evaluation, evaluate
from scalar.evaluate.truth import read_truth
from scalar.units import DEG, MM
from study.common.methods import CONVERGED, INITIAL
from study.common.seeds import found_seeds
from study.common.statistics import POSE_ERROR_COLUMNS
from study.headline.calibrate import FAILURE_FORMAT

ERROR_COLUMNS = {
    "case": "row of the grid",
    "seed": "seed of all random draws in the scene",
    "method": "proposed, baseline-READING (the original paper's method), or initial (the model before calibration)",
    **POSE_ERROR_COLUMNS,
    "predicted_position_std_mean_mm": "the calibration's own standard error of the position",
    "residual_rms_mm": "RMS distance of the points from their planes after the fit",
    "misfit": "the residual divided by what the noise explains; about 1 for a complete model",
    "evaluations": "number of evaluations of the residual by the solver",
}
PLANE_COLUMNS = {
    "case": "row of the grid",
    "seed": "seed of all random draws in the scene",
    "method": "as in errors.csv",
    "status": "as in errors.csv",
    "plane": "name of the plane",
    "normal_error_deg": "angle between the calibrated normal and the true one",
    "distance_error_mm": "calibrated minus true distance from the base's origin",
}
PARAMETER_COLUMNS = {
    "case": "row of the grid",
    "seed": "seed of all random draws in the scene",
    "method": "as in errors.csv",
    "status": "as in errors.csv",
    "parameter": "a alpha d theta beta by joint, and the sensor's pose on the flange",
    "unit": "unit of the next four columns: mm or deg",
    "value": "calibrated value",
    "truth": "true value",
    "error": "calibrated minus true value",
    "std": "the calibration's own standard error; empty if the parameter was fixed",
    "normalized_error": "error / std; its standard deviation is 1 if the standard errors are right",
    "held": "True if the parameter was not estimated",
}


@dataclass(frozen=True, eq=False)
class Tables:
    """The tables of an evaluation.

    Attributes:
        errors: A row for each seed, method and alignment, columns ``ERROR_COLUMNS``.
        planes: A row for each seed, method and plane, columns ``PLANE_COLUMNS``.
        parameters: A row for each seed, method and parameter, columns ``PARAMETER_COLUMNS``.
    """

    errors: pd.DataFrame
    planes: pd.DataFrame
    parameters: pd.DataFrame


def evaluate_seeds(case: str, data_dir: str | Path, calibration_dirs: Mapping[str, str | Path]) -> Tables:
    """Return the errors of every calibration of a batch, and of the initial model.

    Args:
        case: Name of the case in the tables.
        data_dir: Folder of simulated datasets, as ``simulate_seeds`` wrote it.
        calibration_dirs: ``{method: folder of its calibrations}``, as ``calibrate_seeds`` wrote them.
    """
    errors: list[dict[str, Any]] = []
    planes: list[pd.DataFrame] = []
    parameters: list[pd.DataFrame] = []
    for seed, folder in found_seeds(data_dir):
        dataset = read_dataset(folder / "dataset")
        truth_poses, truth = read_truth(folder / "truth", dataset.robot.n_joints)
        for method in (INITIAL, *calibration_dirs):
            key = {"case": case, "seed": seed, "method": method}
            calibration, status = None, INITIAL
            if method != INITIAL:
                calibration, status = _load(Path(calibration_dirs[method]) / f"{folder.name}.json")
            elif dataset.sensor.T_flange_sensor is not None:
                calibration = Calibration.nominal(dataset)
            if calibration is None:
                errors += [
                    key | {"status": status, "alignment": alignment} for alignment in ("raw", "aligned")
                ]
                continue
            found = evaluate(calibration, truth_poses, truth)
            key |= {"status": status}
            errors += _error_rows(key, calibration, found)
            planes.append(found.planes.assign(**key))
            parameters.append(_parameter_rows(found.parameters).assign(**key))
        print(f"seed {seed}: evaluated {len(calibration_dirs)} methods", flush=True)
    return Tables(
        pd.DataFrame(errors).reindex(columns=list(ERROR_COLUMNS)),
        _joined(planes, list(PLANE_COLUMNS)),
        _joined(parameters, list(PARAMETER_COLUMNS)),
    )


def _load(path: Path) -> tuple[Calibration | None, str]:
    """Return a calibration and its status; None and the status of the failure if there is none."""
    content = json.loads(path.read_text(encoding="utf-8"))
    if content.get("format") == FAILURE_FORMAT:
        return None, content["status"]
    return load_calibration(path), content["summary"].get("status", CONVERGED)


def _error_rows(key: dict[str, Any], calibration: Calibration, found: Evaluation) -> list[dict[str, Any]]:
    estimated = len(calibration.free) > 0
    common = {
        "predicted_position_std_mean_mm": found.predicted_position_std.mean() / MM if estimated else None,
        "residual_rms_mm": calibration.residual_rms / MM if estimated else None,
        "misfit": calibration.summary.get("misfit"),
        "evaluations": calibration.summary.get("evaluations"),
    }
    return [
        key | {"alignment": alignment} | errors.to_mapping() | common
        for alignment, errors in (("raw", found.raw), ("aligned", found.aligned))
    ]


def _parameter_rows(found: pd.DataFrame) -> pd.DataFrame:
    """Return the parameters in millimetres and degrees, with their errors in standard errors."""
    rows = found.copy()
    scale = np.where(rows["unit"] == "m", MM, DEG)
    rows["unit"] = np.where(rows["unit"] == "m", "mm", "deg")
    for column in ("value", "truth", "error", "std"):
        rows[column] = pd.to_numeric(rows[column]) / scale
    std = rows["std"].to_numpy(dtype=float)
    with np.errstate(divide="ignore", invalid="ignore"):
        rows["normalized_error"] = np.where(std > 0, rows["error"] / std, np.nan)
    return rows


def _joined(tables: list[pd.DataFrame], columns: list[str]) -> pd.DataFrame:
    whole = [table for table in tables if len(table)]
    return (
        pd.concat(whole, ignore_index=True).reindex(columns=columns)
        if whole
        else pd.DataFrame(columns=columns)
    )
