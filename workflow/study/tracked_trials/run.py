"""Run tracked trials in memory: simulate each set, diagnose it without knowledge of the truth, and compare with the truth.

The diagnosis is the quick one, without the outer split. Errors are those of predictions for a cold arm at rest at unseen poses within the measured
range of the joints, after the best rigid motion of the base; with a probe also after the best scale, since contacts do not determine it.
"""

from __future__ import annotations

import json
from dataclasses import asdict
from time import process_time
from typing import Any

import numpy as np
import pandas as pd

from scalar.diagnosis import Diagnosis, diagnose
from scalar.estimation.result import Calibration
from scalar.units import MM
from study.common.outcomes import outcome, stated
from study.tracked_trials.design import Design, Trial
from study.tracked_trials.measure import simulated
from study.tracked_trials.tracked_arm import relative

DRAWN = ("sensor", "number", "seed", "robot", "share_of_range", "noise_m", "stated", "turn_noise_rad",
         "turn_stated", "repeatability_rad", "sessions", "records_time", "records_approach")  # fmt: skip
TRIAL_COLUMNS = {
    **{name: "the attribute of study.tracked_trials.design.Trial" for name in DRAWN},
    "poses": "number of poses that were measured; with a probe, of those that reach contact",
    "injected": "JSON, the causes: name, target, size",
    "status": "diagnosed; the class of the error that ended the diagnosis; or crashed, by a defect of this program",
    "reason": "first line of the message of a diagnosis that failed",
    "verdict": "verdict in diagnosis.json",
    "found": "JSON, the entries of diagnosis.json without their coefficients",
    "unobservable": "JSON, names and targets that the diagnosis says it cannot observe",
    "shipped": "which fit is shipped",
    "held_out_after_mm": "RMS error over held-out poses of the shipped model",
    "unseen_before_mm": "RMS position error over the unseen poses of the model without effects",
    "unseen_found_mm": "the same of the model with all effects that were found",
    "unseen_after_mm": "the same of the shipped model",
    "seconds": "processor time of the set",
}


def run_trials(design: Design, sensor: str, numbers: range) -> pd.DataFrame:
    """Return the rows of some sets of a kind of sensor, columns ``TRIAL_COLUMNS``."""
    rows = []
    for number in numbers:
        row = run_trial(design.trial(sensor, number))
        rows.append(row)
        names = [entry["name"] for entry in json.loads(row["found"])]
        print(f"{sensor} {number}: {row.get('verdict') or row['reason']} {names}", flush=True)
    return pd.DataFrame(rows).reindex(columns=list(TRIAL_COLUMNS))


def run_trial(trial: Trial) -> dict[str, Any]:
    """Return the row of one set."""
    start = process_time()
    drawn = asdict(trial)
    row: dict[str, Any] = {name: drawn[name] for name in DRAWN}
    row |= {"injected": json.dumps(trial.causes), "found": "[]", "unobservable": "[]"}
    dataset, unseen, truth = simulated(trial)
    row["poses"] = len(dataset.poses)
    row |= outcome(
        lambda: answer(diagnose(dataset, outer_folds=0, cores=1), unseen, truth, trial.sensor == "probe")
    )
    return row | {"seconds": process_time() - start}


def answer(diagnosis: Diagnosis, unseen: np.ndarray, truth: np.ndarray, scaled: bool) -> dict[str, Any]:
    """Return what a diagnosis says and how well its calibrations predict, as entries of a row.

    Args:
        diagnosis: The diagnosis of one set.
        unseen: Joint angles of the unseen poses ``(M, n)`` [rad].
        truth: True frames of the first target at them ``(M, 4, 4)``.
        scaled: Whether errors are taken after the best scale.
    """
    mapping = diagnosis.to_mapping()
    calibrations = {
        "before": diagnosis.calibration_before,
        "found": diagnosis.calibration_found,
        "after": diagnosis.calibration_after,
    }
    return {
        **stated(mapping),
        "shipped": mapping["shipped"]["fit"],
        "held_out_after_mm": mapping["residual"]["after"]["held_out_rms_mm"],
        **{
            f"unseen_{when}_mm": unseen_error(predicted(calibration, unseen), truth, scaled) / MM
            for when, calibration in calibrations.items()
        },
    }


def predicted(calibration: Calibration, q: np.ndarray) -> np.ndarray:
    """Return the frames of the first target ``(M, 4, 4)`` that a calibration predicts for a cold arm at rest."""
    return np.asarray(calibration.predict(q, time=0.0, order=0, approach=np.zeros_like(q)))


def unseen_error(T: np.ndarray, truth: np.ndarray, scaled: bool = False) -> float:
    """Return the RMS distance [m] of the origins of predicted frames ``(M, 4, 4)`` from the true ones, after the best rigid motion.

    If ``scaled``, they are multiplied by the best scale as well.
    """
    places, true = relative(T, truth)[:, :3, 3], truth[:, :3, 3]
    places, true = places - places.mean(0), true - true.mean(0)
    scale = np.sum(places * true) / np.sum(places**2) if scaled else 1.0
    return float(np.sqrt(np.mean(np.sum((scale * places - true) ** 2, axis=1))))
