"""Simulate the sets of the blind trials, diagnose them blind, and compare the answers with the truth: a row for each set. No dataset is written.

The diagnosis is given the same ``Dataset`` as a user's, and nothing else. For comparison, a *matched control* is calibrated: the same scene with the
same poses and draws of noise, but without what was injected. Its error is the one that a perfect diagnosis would reach.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from itertools import groupby
from pathlib import Path
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
from study.common.in_memory import dataset_in_memory
from study.common.outcomes import outcome, stated
from study.common.scene_config import scene_config

if TYPE_CHECKING:
    from scalar.simulation.plan import PosePlan

SET_COLUMNS = {
    "case": "name of the case, from configs/blind_trials.yaml",
    "kind": "single, null, pair or unknown",
    "workcell": "name of the workcell: robot, scanner and target planes",
    "seed": "seed of all random draws in the scene",
    "size": "multiple of the effect's natural size",
    "status": "diagnosed; not_simulated; the class of the error that ended the diagnosis; or crashed, by a defect of this program",
    "reason": "first line of the message of a failure",
    "injected": "JSON, the injected effects in truth.json: name, target, size",
    "verdict": "verdict in diagnosis.json",
    "found": "JSON, the entries of diagnosis.json without their coefficients",
    "unobservable": "JSON, names and targets that the diagnosis says it cannot observe",
    "signal_over_noise": "RMS residual that the injected effect leaves in a fit without it, divided by the RMS residual that the noise leaves",
    "wrong_poses": "number of poses to which gross errors were added",
    "wrong_poses_found": "number of those that the diagnosis lists as outliers",
    "held_out_before_mm": "RMS error over held-out poses, without the effects found",
    "held_out_after_mm": "the same with the effects found",
    "held_out_noise_floor_mm": "the RMS error that the stated noise alone leaves",
    "position_before_mm": "mean position error over the evaluation poses, base aligned, without the effects found",
    "position_after_mm": "the same with the effects found",
    "position_control_mm": "the same of the matched control",
    "position_max_before_mm": "largest position error over the evaluation poses, without the effects found",
    "position_max_after_mm": "the same with the effects found",
    "position_max_control_mm": "the same of the matched control",
}
_SEED_OF_GROSS_ERRORS = 40_917  # with the scene's seed, the seed of the gross errors


@dataclass(frozen=True, eq=False)
class MatchedControl:
    """A scene without anything injected, and the errors of its calibration.

    Attributes:
        config: Complete config of the scene.
        base_dir: Folder from which the paths in the config start.
        plan: The postures of the scene.
        errors: The columns ``position_control_mm`` and ``position_max_control_mm``.
        residual_rms: RMS distance of the points from their planes after the calibration [m], which is due to the noise.
    """

    config: Mapping[str, Any]
    base_dir: Path
    plan: PosePlan
    errors: dict[str, float | None]
    residual_rms: float


def run_sets(study: Study, case: str, workcell: str, repetitions: str, root: Path) -> pd.DataFrame:
    """Simulate and diagnose the sets of a job; return a row for each, columns ``SET_COLUMNS``.

    Args:
        study: The blind trials.
        case: Name of the job's case.
        workcell: Name of the job's workcell.
        repetitions: Repetitions of the job, such as ``001-002``.
        root: Folder from which the paths of scenes start.

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
    """Return the matched control of all sets of a workcell and seed: its scene without effects, and the errors of its calibration.

    Args:
        study: The blind trials.
        workcell: Name of the workcell.
        seed: Seed of its scene.
        root: Folder from which the paths of scenes start.

    Raises:
        InvalidInput: The scene is at fault.
        SimulationError: Too few postures see a target plane.
    """
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
        wanted: The set to simulate and diagnose.
        control: The matched control of its workcell and seed.
        signals: Cache of ``signal_over_noise``, filled by this call: the ratio at size 1 by what is injected, which is scaled to other sizes.
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


def answered(
    dataset: Dataset,
    wrong: list[int],
    truth_poses: pd.DataFrame,
    outer_folds: int = 0,
    more: Callable[[Diagnosis], Mapping[str, Any]] = lambda diagnosis: {},
) -> dict[str, Any]:
    """Diagnose a dataset; return how the diagnosis ended and what it says, as entries of a row.

    Args:
        dataset: The dataset of one set.
        wrong: Ids of its poses to which gross errors were added.
        truth_poses: Joint angles and true frames at the evaluation poses, content of ``truth_poses.csv``.
        outer_folds: Number of parts of the outer split; with zero there is none.
        more: Returns further entries.
    """

    def entries() -> dict[str, Any]:
        diagnosis = diagnose(dataset, outer_folds=outer_folds, cores=1)
        return answer_entries(diagnosis, wrong, truth_poses) | dict(more(diagnosis))

    return outcome(entries)


def injected_config(wanted: Set, control: MatchedControl) -> dict[str, Any]:
    """Return the config of a set's scene."""
    config = with_overrides(control.config, wanted.overrides)
    return config | {"injected": [dict(entry) for entry in wanted.injected]}


def answer_entries(diagnosis: Diagnosis, wrong: list[int], truth_poses: pd.DataFrame) -> dict[str, Any]:
    """Return what a diagnosis says, as entries of a row.

    Args:
        diagnosis: The diagnosis of one set.
        wrong: Ids of its poses to which gross errors were added.
        truth_poses: Joint angles and true frames at the evaluation poses, content of ``truth_poses.csv``.
    """
    mapping = diagnosis.to_mapping()
    residual = mapping["residual"]
    return {
        **stated(mapping),
        "components": json.dumps([part["name"] for part in mapping["noise"]["components"]]),
        "wrong_poses": len(wrong),
        "set_aside": len(mapping["outliers"]["poses"]),
        "wrong_poses_found": len(set(wrong) & set(mapping["outliers"]["poses"])),
        "held_out_before_mm": residual["before"]["held_out_rms_mm"],
        "held_out_after_mm": residual["after"]["held_out_rms_mm"],
        "held_out_noise_floor_mm": residual["floor_mm"],
        **errors(diagnosis.calibration_before, truth_poses, "before"),
        **errors(diagnosis.calibration_after, truth_poses, "after"),
    }


def errors(calibration: Calibration, truth_poses: pd.DataFrame, when: str) -> dict[str, float | None]:
    """Return ``{"position_WHEN_mm": mean, "position_max_WHEN_mm": largest}`` of the position errors over the evaluation poses, base aligned.

    The values are None if the calibration cannot predict these poses.

    Args:
        calibration: The calibration to evaluate.
        truth_poses: Content of ``truth_poses.csv``.
        when: Part of the names of the entries, for example ``before``.
    """
    T_true = true_frames(truth_poses)
    try:
        position = pose_errors(T_true, aligned_to(T_true, calibration.predict(truth_poses))).position / MM
    except ScalarError:
        return {f"position_{when}_mm": None, f"position_max_{when}_mm": None}
    return {f"position_{when}_mm": float(position.mean()), f"position_max_{when}_mm": float(position.max())}


def signal_over_noise(wanted: Set, control: MatchedControl, known: dict[str, float | None]) -> float | None:
    """Return the RMS residual that injected effects leave in a fit without them, divided by that which the noise leaves; None if the fit fails.

    The residual is computed in the same scene without noise, at the first size that is asked for, and scaled to the other sizes.

    Args:
        wanted: The set.
        control: The matched control of its workcell and seed.
        known: Cache, filled by this call: the ratio at size 1 by what is injected.
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
    at_size_one = known[key]
    return None if at_size_one is None else at_size_one * wanted.size
