"""Run spoiled set-ups: write the folder of each, read and calibrate it as `scalar calibrate` does, and keep what is said."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time
from traceback import print_exc
from typing import Any

import pandas as pd

from scalar.data.dataset import read_dataset
from scalar.errors import InvalidInput, ScalarError
from scalar.estimation.calibrate import calibrate
from scalar.estimation.misfit import lacks_something
from scalar.estimation.setup.suspicion import WrongSetup
from scalar.units import MM
from study.spoiled_setups.beyond_moves import least_change
from study.spoiled_setups.design import Design, SetUp
from study.spoiled_setups.score import outcome_of
from study.spoiled_setups.spoilings import Spoiled, spoil
from study.spoiled_setups.workcell import OutOfReach, Workcell, measured_points, workcell

DRAWN = ("number", "attempt", "kind", "sensor", "arm", "poses", "noise_m", "states_pose", "standard", "named")
COLUMNS = {
    **{name: "the attribute of study.spoiled_setups.design.SetUp" for name in DRAWN},
    "done": "what was made wrong",
    "change_mm": "RMS change of predictions after the best moves of base and sensor; empty where measurements were changed",
    "exit": "exit status of `scalar calibrate`: 0, 2 or 3; 1 for a defect of this program",
    "stage": "where it ended: read, set-up (another reading was named), fit, accepted, or crashed",
    "said": "JSON, what is said of the set-up: what, where and sentence of each suspicion, or of the refusal",
    "outcome": "one of study.spoiled_setups.score.OUTCOMES",
    "one_of": "number of suspicions among which the right one stands; 0 if it does not",
    "seconds": "processor time of reading and calibrating",
}
MOST_ATTEMPTS = 200


def run_setups(design: Design, numbers: range) -> pd.DataFrame:
    """Return the rows of some sets, columns ``COLUMNS``."""
    rows = []
    for number in numbers:
        row = run_setup(design, number)
        rows.append(row)
        print(f"{number}: {row['done']} ({row['arm']}, {row['sensor']}): {row['outcome']}", flush=True)
    return pd.DataFrame(rows).reindex(columns=list(COLUMNS))


def run_setup(design: Design, number: int) -> dict[str, Any]:
    """Return the row of one set."""
    setup, spoiled, change = drawn(design, number)
    row: dict[str, Any] = {name: asdict(setup)[name] for name in DRAWN}
    row |= {"done": spoiled.done, "change_mm": None if change is None else change / MM}
    start = process_time()
    row |= what_is_said(spoiled)
    row["seconds"] = process_time() - start
    outcome, one_of = outcome_of(spoiled.truth, row["stage"], row["said"])
    return row | {"said": json.dumps(row["said"]), "outcome": outcome, "one_of": one_of}


def drawn(design: Design, number: int) -> tuple[SetUp, Spoiled, float | None]:
    """Return the first set-up of a number that changes predictions beyond a move of base or sensor, its spoiled campaign, and that change [m].

    The change is None where the measurements are made wrong, so that no move undoes it.
    """
    for attempt in range(MOST_ATTEMPTS):
        setup, rng = design.drawn(number, attempt)
        try:
            sound = workcell(setup, rng)
        except OutOfReach:
            continue
        spoiled = spoil(setup.kind, sound, rng)
        change = change_of(sound, spoiled)
        if change is None or change > design.content["least_change_m"]:
            return setup, spoiled, change
    raise AssertionError(f"set {number}: no spoiling of {MOST_ATTEMPTS} changes predictions")


def change_of(sound: Workcell, spoiled: Spoiled) -> float | None:
    """Return by how much predictions change after the best moves of base and sensor [m]; None where the measurements are wrong."""
    if spoiled.right is None or spoiled.wrong is None:
        return None
    return least_change(spoiled.right, spoiled.wrong, measured_points(sound))


def what_is_said(spoiled: Spoiled) -> dict[str, Any]:
    """Return the columns ``exit``, ``stage`` and ``said`` (not yet JSON) of a spoiled campaign that is written, read and calibrated."""
    with TemporaryDirectory() as folder:
        path = spoiled.campaign.write(Path(folder) / "set")
        try:
            dataset = read_dataset(path)
        except InvalidInput as error:
            return {"exit": 2, "stage": "read", "said": [_of_error(error, path)]}
    try:
        calibration = calibrate(dataset)
        said = list(calibration.summary.get("setup", []))
        said = [{key: entry[key] for key in ("what", "where", "sentence")} for entry in said]
        if calibration.summary.get("misfit_p_value") is not None and lacks_something(calibration.summary):
            lacks = f"the residual is {calibration.summary['misfit']:.1f} times what the noise explains"
            said.append({"what": "misfit", "where": "", "sentence": lacks})
        return {"exit": 0, "stage": "accepted", "said": said}
    except WrongSetup as error:
        said = [{"what": s.what, "where": s.where, "sentence": s.sentence} for s in error.suspicions]
        return {"exit": 2, "stage": "set-up", "said": said}
    except ScalarError as error:
        status = 2 if isinstance(error, InvalidInput) else 3
        return {"exit": status, "stage": "fit", "said": [_of_error(error, path)]}
    except Exception as error:  # a defect of this program: counted, and the other sets are still run
        print_exc()
        return {"exit": 1, "stage": "crashed", "said": [_of_error(error, path)]}


def _of_error(error: Exception, path: Path) -> dict[str, str]:
    """Return the entry of a refusal, without the name of the temporary folder."""
    sentence = str(error).replace(str(path.parent), "")
    return {"what": "refusal", "where": type(error).__name__, "sentence": sentence}
