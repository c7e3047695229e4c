"""Run real-arm trials in memory: simulate each set, diagnose it without knowledge of the truth, and compare with the truth.

The diagnosis is the quick one, without the outer split. Errors are RMS position errors over unseen poses after the best rigid motion of the base.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from time import process_time
from typing import Any

import pandas as pd

from scalar.diagnosis import Diagnosis, diagnose
from scalar.units import MM
from study.blind_trials.stratified_run import ATTEMPTS
from study.common.outcomes import outcome, stated
from study.real_arm_trials.campaign import Campaign
from study.real_arm_trials.design import Design, Trial
from study.real_arm_trials.scanned import scanned_campaign
from study.real_arm_trials.tracked import tracked_campaign
from study.tracked_trials.run import unseen_error

DRAWN = ("instrument", "number", "seed", "robot", "poses", "effect", "size", "company", "noise_m", "states_noise",
         "repeatability_rad", "record", "sessions", "stops")  # fmt: skip
TRIAL_COLUMNS = {
    **{name: "the attribute of study.real_arm_trials.design.Trial" for name in DRAWN},
    "attempt": "number of scenes of this set that could not be simulated before this one",
    "injected": "JSON, what was injected: name, kind, target, size; the effect that is judged first",
    "status": "diagnosed; not_simulated; the class of the error that ended the diagnosis; or crashed, by a defect of this program",
    "reason": "first line of the message of a failure",
    "verdict": "verdict in diagnosis.json",
    "found": "JSON, the entries of diagnosis.json without their coefficients",
    "unobservable": "JSON, names and targets that the diagnosis says it cannot observe",
    "shipped": "which fit is shipped",
    "unseen_before_mm": "RMS position error over the unseen poses of the model without effects",
    "unseen_after_mm": "the same of the shipped model",
    "simulate_s": "processor time of the simulation",
    "diagnose_s": "processor time of the diagnosis",
}


def run_trials(design: Design, instrument: str, numbers: range, root: Path) -> pd.DataFrame:
    """Return the rows of some sets of an instrument, columns ``TRIAL_COLUMNS``; ``root`` is the folder from which paths of scenes start."""
    rows = []
    for number in numbers:
        row = run_trial(design, instrument, number, root)
        rows.append(row)
        names = [entry["name"] for entry in json.loads(row["found"])]
        print(
            f"{instrument} {number} {row['effect']} {row['size']} {row['company']}: {row.get('reason', '')} {names}",
            flush=True,
        )
    return pd.DataFrame(rows).reindex(columns=list(TRIAL_COLUMNS))


def run_trial(design: Design, instrument: str, number: int, root: Path) -> dict[str, Any]:
    """Return the row of one set. A scene that cannot be simulated is drawn anew, up to ``ATTEMPTS`` times in all."""
    from scalar.simulation.errors import SimulationError

    row: dict[str, Any] = {}
    for attempt in range(ATTEMPTS):
        trial = design.trial(instrument, number, attempt)
        drawn = asdict(trial)
        row = {name: drawn[name] for name in DRAWN} | {"record": " ".join(trial.record), "attempt": attempt}
        row |= {"injected": "[]", "found": "[]", "unobservable": "[]"}
        start = process_time()
        try:
            campaign = campaign_of(trial, root)
        except SimulationError as error:
            row |= {"status": "not_simulated", "reason": str(error).splitlines()[0]}
            continue
        row["simulate_s"] = process_time() - start
        row["injected"] = json.dumps([kept(entry) for entry in campaign.injected])
        start = process_time()
        row |= answered(campaign)
        return row | {"diagnose_s": process_time() - start}
    return row


def campaign_of(trial: Trial, root: Path) -> Campaign:
    """Return the campaign of a set; arguments as for ``scanned_campaign``, which says what is raised."""
    return (scanned_campaign if trial.instrument == "scanner" else tracked_campaign)(trial, root)


def kept(entry: Mapping[str, Any]) -> dict[str, Any]:
    """Return what is kept of an entry of truth.json: name, target and size, and the kind of an unknown cause."""
    return {key: entry[key] for key in ("name", "kind", "target", "size") if key in entry}


def answered(campaign: Campaign) -> dict[str, Any]:
    """Diagnose a campaign; return how the diagnosis ended and what it says, as entries of a row."""
    return outcome(lambda: answer(diagnose(campaign.dataset, outer_folds=0, cores=1), campaign))


def answer(diagnosis: Diagnosis, campaign: Campaign) -> dict[str, Any]:
    """Return what a diagnosis says of a campaign, and how well its calibrations predict the unseen poses, as entries of a row."""
    mapping = diagnosis.to_mapping()
    calibrations = {"before": diagnosis.calibration_before, "after": diagnosis.calibration_after}
    return {
        **stated(mapping),
        "shipped": mapping["shipped"]["fit"],
        **{
            f"unseen_{when}_mm": unseen_error(calibration.predict(campaign.unseen), campaign.truth) / MM
            for when, calibration in calibrations.items()
        },
    }
