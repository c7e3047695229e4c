"""Inject, diagnose blind, compare with the truth: a row for each set, in memory.

The diagnosis is given the ``Dataset`` that its folder would be read as, and nothing else. Beside it stands a matched control:
the same scene, seeds and noise without what was injected, calibrated; its error is what a perfect diagnosis would reach.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import groupby
from pathlib import Path
from traceback import print_exc
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from scalar.data.dataset import Dataset
from scalar.diagnosis import Diagnosis, diagnose
from scalar.errors import ScalarError
from scalar.estimation.calibrate import calibrate
from scalar.estimation.result import Calibration
from scalar.evaluate import aligned_to, pose_errors, true_frames
from scalar.units import MM
from study.blind_trials.cases import Set, Study
from study.blind_trials.gross_errors import with_gross_errors
from study.common.grid import with_overrides
from study.common.memory import dataset_in_memory
from study.common.scene_config import scene_config

if TYPE_CHECKING:
    from scalar.simulation.plan import PosePlan

SET_COLUMNS = {
    "case": "of configs/blind_trials.yaml",
    "kind": "single, null, pair or unknown",
    "workcell": "robot, scanner and target planes",
    "seed": "of all random draws in the scene",
    "size": "multiple of the effect's natural size",
    "status": "diagnosed; not_simulated; the error that ended the diagnosis, or crashed: a defect of ours",
    "reason": "of a failure, its first line",
    "injected": "JSON, what truth.json says: name, target, size",
    "verdict": "of diagnosis.json",
    "found": "JSON, the entries of diagnosis.json without their coefficients",
    "unobservable": "JSON, names and targets that the diagnosis says it cannot observe",
    "signal_over_noise": "rms that the injected effect leaves in a fit without it, over the rms that noise leaves",
    "wrong_poses": "number of poses spoiled on purpose",
    "wrong_poses_found": "of them, those listed as outliers",
    "held_out_before_mm": "rms over poses held out, without the effects found",
    "held_out_after_mm": "with them",
    "held_out_noise_floor_mm": "what the stated noise alone leaves",
    "position_before_mm": "mean error over the evaluation poses, base aligned, without the effects found",
    "position_after_mm": "with them",
    "position_control_mm": "of the matched control, the same scene and noise without what was injected, calibrated",
    "position_max_before_mm": "the largest of them",
    "position_max_after_mm": "the largest of them",
    "position_max_control_mm": "the largest of them",
}
CRASHED = "crashed"
_SEED_OF_GROSS_ERRORS = 40_917  # beside the scene's own seed


@dataclass(frozen=True, eq=False)
class MatchedControl:
    """A scene without anything injected: its config and postures, and what its calibration comes to.

    Attributes:
        errors: Errors over the evaluation poses [mm]. residual_rms: Of its points [m]: what the noise leaves.
    """

    config: Mapping[str, Any]
    base_dir: Path
    plan: PosePlan
    errors: dict[str, float | None]
    residual_rms: float


def run_sets(study: Study, case: str, workcell: str, repetitions: str, root: Path) -> pd.DataFrame:
    """Return the sets of a job: a row for each set, columns ``SET_COLUMNS``.

    Args:
        study: The blind trials. case, workcell, repetitions: A job of it.
        root: Where the paths of scenes start.

    Raises:
        InvalidInput: The scene is at fault.
        SimulationError: Too few postures see a target plane.
    """
    rows = []
    for seed, sets in groupby(study.sets(case, workcell, repetitions), key=lambda wanted: wanted.seed):
        control = make_control(study, workcell, seed, root)
        signals: dict[str, float | None] = {}
        for wanted in sets:
            row = run_set(wanted, control, signals)
            rows.append(row)
            names = (
                [entry["name"] for entry in json.loads(row["found"])]
                if row["status"] == "diagnosed"
                else row["reason"]
            )
            print(
                f"{case} {workcell} seed {seed} size {wanted.size:g}: {row.get('verdict')} {names}",
                flush=True,
            )
    return pd.DataFrame(rows).reindex(columns=list(SET_COLUMNS))


def make_control(study: Study, workcell: str, seed: int, root: Path) -> MatchedControl:
    """Return the matched control of all sets of a workcell and seed."""
    # Imported here: the simulator needs pybullet, an optional dependency.
    from scalar.simulation.plan import plan_poses
    from scalar.simulation.scene import simulate

    scene = root / study.workcells[workcell]["scene"]
    overrides = (study.scene, study.workcells[workcell]["overrides"])
    config = scene_config(scene, overrides, seed=seed, name=workcell)
    plan = plan_poses(config, base_dir=scene.parent)
    simulated = simulate(config, base_dir=scene.parent, plan=plan)
    calibration = calibrate(dataset_in_memory(simulated))
    reached = errors(calibration, simulated.truth_poses, "control")
    return MatchedControl(config, scene.parent, plan, reached, calibration.residual_rms)


def run_set(
    wanted: Set, control: MatchedControl, signals: dict[str, float | None] | None = None
) -> dict[str, Any]:
    """Return the row of one set.

    Args:
        wanted: What to inject. control: Of its workcell and seed.
        signals: ``signal_over_noise`` at size 1, by what is injected. It is computed once and scaled to the other sizes.
    """
    from scalar.simulation.errors import SimulationError
    from scalar.simulation.scene import simulate

    row: dict[str, Any] = {key: getattr(wanted, key) for key in ("case", "kind", "workcell", "seed", "size")}
    row |= {"found": "[]", "injected": "[]", "unobservable": "[]"} | control.errors
    config = injected_config(wanted, control)
    try:
        simulated = simulate(config, base_dir=control.base_dir, plan=control.plan)
    except SimulationError as error:
        return row | {"status": "not_simulated", "reason": str(error).splitlines()[0]}
    injected = [
        {key: entry.get(key) for key in ("name", "target", "size")} for entry in simulated.truth["effects"]
    ]
    row["injected"] = json.dumps(injected)
    row["signal_over_noise"] = signal_over_noise(wanted, control, {} if signals is None else signals)
    rng = np.random.default_rng([wanted.seed, _SEED_OF_GROSS_ERRORS])
    dataset, wrong = with_gross_errors(dataset_in_memory(simulated), wanted.gross_errors, rng)
    return row | answered(dataset, wrong, simulated.truth_poses)


def answered(dataset: Dataset, wrong: list[int], truth_poses: pd.DataFrame) -> dict[str, Any]:
    """Return how the diagnosis of a dataset ended, and what it says, as entries of a row.

    Args:
        dataset: Of one set. wrong: Ids of its poses that were spoiled.
        truth_poses: Joint angles and true frames.
    """
    try:
        return {"status": "diagnosed"} | found(diagnose(dataset), wrong, truth_poses)
    except ScalarError as error:
        return {"status": type(error).__name__, "reason": str(error).splitlines()[0]}
    except (
        Exception
    ) as error:  # a defect of ours: counted as one, and one set of thousands does not stop the others
        print_exc()
        return {"status": CRASHED, "reason": f"{type(error).__name__}: {error}".splitlines()[0]}


def injected_config(wanted: Set, control: MatchedControl) -> dict[str, Any]:
    """Return the config of a set's scene."""
    config = with_overrides(control.config, wanted.overrides)
    return config | {"injected": [dict(entry) for entry in wanted.injected]}


def found(diagnosis: Diagnosis, wrong: list[int], truth_poses: pd.DataFrame) -> dict[str, Any]:
    """Return what a diagnosis says, as entries of a row.

    Args:
        diagnosis: Of one set. wrong: Ids of its poses that were spoiled.
        truth_poses: Joint angles and true frames.
    """
    mapping = diagnosis.to_mapping()
    entries = [{k: v for k, v in entry.items() if k != "coefficients"} for entry in mapping["effects"]]
    residual = mapping["residual"]
    return {
        "verdict": mapping["verdict"],
        "found": json.dumps(entries),
        "unobservable": json.dumps(
            [{"name": s["name"], "target": s["target"]} for s in mapping["unobservable"]]
        ),
        "components": json.dumps([part["name"] for part in mapping["noise"]["components"]]),
        "wrong_poses": len(wrong),
        "wrong_poses_found": len(set(wrong) & set(mapping["outliers"]["poses"])),
        "held_out_before_mm": residual["before"]["held_out_rms_mm"],
        "held_out_after_mm": residual["after"]["held_out_rms_mm"],
        "held_out_noise_floor_mm": residual["floor_mm"],
        **errors(diagnosis.calibration_before, truth_poses, "before"),
        **errors(diagnosis.calibration_after, truth_poses, "after"),
    }


def errors(calibration: Calibration, truth_poses: pd.DataFrame, when: str) -> dict[str, float | None]:
    """Return mean and largest position error [mm] over true poses, base aligned; None where the calibration cannot predict these poses."""
    T_true = true_frames(truth_poses)
    try:
        position = pose_errors(T_true, aligned_to(T_true, calibration.predict(truth_poses))).position / MM
    except ScalarError:
        return {f"position_{when}_mm": None, f"position_max_{when}_mm": None}
    return {f"position_{when}_mm": float(position.mean()), f"position_max_{when}_mm": float(position.max())}


def signal_over_noise(wanted: Set, control: MatchedControl, known: dict[str, float | None]) -> float | None:
    """Return the residual that injected effects leave in a fit without them, over that which the noise leaves; both rms over all points.

    Computed in the same scene without noise at the size that is asked for first, and scaled to the other sizes.
    """
    from scalar.simulation.scene import simulate

    if not wanted.injected:
        return 0.0
    key = json.dumps(
        [{k: v for k, v in entry.items() if k != "size"} for entry in wanted.injected], sort_keys=True
    )
    if key not in known:
        noise = control.config["noise"]
        quiet = injected_config(wanted, control) | {"noise": {**noise, "range_noise_std_m": 0.0}}
        dataset = dataset_in_memory(simulate(quiet, base_dir=control.base_dir, plan=control.plan))
        stated = replace(dataset, sensor=replace(dataset.sensor, noise=noise["range_noise_std_m"]))
        try:
            known[key] = calibrate(stated).residual_rms / control.residual_rms / wanted.size
        except ScalarError:
            known[key] = None
    unit = known[key]
    return None if unit is None else unit * wanted.size
