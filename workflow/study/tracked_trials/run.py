"""Run tracked trials: simulate, diagnose blind, compare with the truth; a row for each set, in memory.

The diagnosis is the quick one, without the outer split. Errors are taken over unseen poses within the measured range of the joints, of
a cold arm at rest, after the base is placed anew; those of a probe also after scaling, since contacts do not determine the scale.
"""

from __future__ import annotations

import json
from dataclasses import asdict
from time import process_time
from traceback import print_exc
from typing import Any

import numpy as np
import pandas as pd

from scalar.diagnosis import Diagnosis, diagnose
from scalar.errors import ScalarError
from scalar.estimation.result import Calibration
from scalar.units import MM
from study.blind_trials.run import CRASHED
from study.tracked_trials.design import Design, Trial
from study.tracked_trials.measure import simulated
from study.tracked_trials.tracked_arm import relative

DRAWN = ("sensor", "number", "seed", "robot", "share_of_range", "noise_m", "stated", "turn_noise_rad",
         "turn_stated", "repeatability_rad", "sessions", "records_time", "records_approach")  # fmt: skip
TRIAL_COLUMNS = {
    **{name: "as study.tracked_trials.design.Trial has it" for name in DRAWN},
    "poses": "that were measured; of a probe, those that reach contact",
    "injected": "JSON, the causes: name, target, size",
    "status": "diagnosed; the error that ended the diagnosis, or crashed: a defect of ours",
    "reason": "of a failure, its first line",
    "verdict": "of diagnosis.json",
    "found": "JSON, the entries of diagnosis.json without their coefficients",
    "unobservable": "JSON, names and targets that the diagnosis says it cannot observe",
    "shipped": "which fit is shipped",
    "held_out_after_mm": "rms over poses held out, as shipped",
    "unseen_before_mm": "rms position error over the unseen poses, without the effects found",
    "unseen_found_mm": "with all of them",
    "unseen_after_mm": "as shipped",
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
    try:
        row |= {"status": "diagnosed"} | answer(
            diagnose(dataset, outer_folds=0, cores=1), unseen, truth, trial.sensor == "probe"
        )
    except ScalarError as error:
        row |= {"status": type(error).__name__, "reason": str(error).splitlines()[0]}
    except Exception as error:  # a defect of ours: counted as one, and one set does not stop the others
        print_exc()
        row |= {"status": CRASHED, "reason": f"{type(error).__name__}: {error}".splitlines()[0]}
    return row | {"seconds": process_time() - start}


def answer(diagnosis: Diagnosis, unseen: np.ndarray, truth: np.ndarray, scaled: bool) -> dict[str, Any]:
    """Return what a diagnosis says and how well its calibrations predict, as entries of a row.

    Args:
        diagnosis: Of one set. unseen: Joint angles ``(M, n)`` [rad]. truth: Frames of the first target there ``(M, 4, 4)``.
        scaled: Whether the scale is free.
    """
    mapping = diagnosis.to_mapping()
    found = [{k: v for k, v in entry.items() if k != "coefficients"} for entry in mapping["effects"]]
    calibrations = {
        "before": diagnosis.calibration_before,
        "found": diagnosis.calibration_found,
        "after": diagnosis.calibration_after,
    }
    return {
        "verdict": mapping["verdict"],
        "found": json.dumps(found),
        "unobservable": json.dumps(
            [{"name": s["name"], "target": s["target"]} for s in mapping["unobservable"]]
        ),
        "shipped": mapping["shipped"]["fit"],
        "held_out_after_mm": mapping["residual"]["after"]["held_out_rms_mm"],
        **{
            f"unseen_{when}_mm": unseen_error(predicted(calibration, unseen), truth, scaled) / MM
            for when, calibration in calibrations.items()
        },
    }


def predicted(calibration: Calibration, q: np.ndarray) -> np.ndarray:
    """Return the frames of the first target ``(M, 4, 4)`` that a calibration predicts of a cold arm at rest."""
    return np.asarray(calibration.predict(q, time=0.0, order=0, approach=np.zeros_like(q)))


def unseen_error(T: np.ndarray, truth: np.ndarray, scaled: bool = False) -> float:
    """Return the rms distance [m] of predicted frames ``(M, 4, 4)`` from the true ones, after the rigid motion, and if
    ``scaled`` the scale, that fit best.
    """
    places, true = relative(T, truth)[:, :3, 3], truth[:, :3, 3]
    places, true = places - places.mean(0), true - true.mean(0)
    scale = np.sum(places * true) / np.sum(places**2) if scaled else 1.0
    return float(np.sqrt(np.mean(np.sum((scale * places - true) ** 2, axis=1))))
