"""Run sets of the stratified trials: simulate, diagnose blind, compare with the truth; a row for each set. No dataset is written.

The *floor* is the noise-limited error: that of a calibration by the rigid model of the same scene, with the same poses and draws of noise, but
without what was injected, without bent target planes, a distorting lens and effects of edges. It would be reached by a fit that knows all causes and
need not estimate them. The error of a fit that is told the causes and estimates them is given as well (``study.blind_trials.told``).
"""

from __future__ import annotations

import json
from pathlib import Path
from time import process_time
from typing import TYPE_CHECKING, Any

import pandas as pd

from scalar.errors import ScalarError
from scalar.estimation.calibrate import calibrate
from study.blind_trials.outer_split import SPLIT_COLUMNS, all_poses, quick_errors, seen_poses, split_answer
from study.blind_trials.run import answered, errors
from study.blind_trials.stratified_design import FACTORS, Design, Trial
from study.blind_trials.told import told
from study.common.in_memory import dataset_in_memory
from study.common.scene_config import scene_config

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset
    from scalar.simulation.scene import SimulatedScene

WITHOUT_FLAWS = {"scanner": {"linearity_m": 0.0, "edge_share": 0.0}, "surface": {"bow_m": 0.0}}
"""Keys of the scene that are replaced for the floor."""
ATTEMPTS = 5
"""Attempts to simulate a set, each with another seed: effects may move scans off their target plane, or no posture may see a plane."""
TRIAL_COLUMNS = {
    "number": "number of the set in the design",
    "row": "row of the table of rates in which the set is counted",
    **{factor: "level of this factor" for factor in FACTORS},
    "seed": "seed of all random draws in the scene",
    "attempt": "number of scenes of this set that could not be simulated before this one",
    "status": "diagnosed; not_simulated; the class of the error that ended the diagnosis; or crashed, by a defect of this program",
    "reason": "first line of the message of a failure",
    "injected": "JSON, the injected effects in truth.json: name, kind, target, size",
    "scanner_truth": "JSON, the scanner's block of truth.json, or null",
    "surface_truth": "JSON, the surfaces' block of truth.json, or null",
    "found": "JSON, the entries of diagnosis.json without their coefficients",
    "unobservable": "JSON, names and targets that the diagnosis says it cannot observe",
    "set_aside": "number of poses that the diagnosis sets aside; all poses of these trials are good",
    "components": "JSON, names of the components of the scanner's own noise",
    "position_before_mm": "mean position error over the evaluation poses, base aligned, without the effects found",
    "position_after_mm": "the same with the effects found",
    "position_floor_mm": "the noise-limited error over the same poses",
    "position_told_mm": "the error over the same poses of a calibration that is told the causes; none if one is no effect of the catalogue",
    "told_significance": "JSON, for each injected effect by how many standard errors its coefficients differ from zero in that calibration, or null",
    "simulate_s": "processor time of simulating both scenes and of calibrating the floor and with the causes told",
    "diagnose_s": "processor time of the diagnosis",
}


def run_trials(design: Design, numbers: range, root: Path) -> pd.DataFrame:
    """Simulate and diagnose some sets of a design; return a row for each, columns ``TRIAL_COLUMNS``.

    Args:
        design: The stratified trials.
        numbers: Numbers of the sets.
        root: Folder from which the paths of scenes start.
    """
    rows = []
    for trial in design.trials(numbers.stop)[numbers.start :]:
        row = run_trial(design, trial, root)
        rows.append(row)
        names = [entry["name"] for entry in json.loads(row["found"])] or row.get("reason", "")
        print(f"set {trial.number} {trial.row}: {names}", flush=True)
    columns = TRIAL_COLUMNS | (SPLIT_COLUMNS if design.outer_split else {})
    return pd.DataFrame(rows).reindex(columns=list(columns))


def run_trial(design: Design, trial: Trial, root: Path) -> dict[str, Any]:
    """Return the row of one set; arguments as for ``run_trials``. A scene that cannot be simulated is drawn anew, up to ``ATTEMPTS`` times in all."""
    from scalar.simulation.errors import SimulationError

    for attempt in range(ATTEMPTS):
        again = design.trial(trial.number, trial.conditions, attempt) if attempt else trial
        row: dict[str, Any] = {"number": trial.number, "row": trial.row, **trial.conditions}
        row |= {"seed": again.seed, "attempt": attempt, "found": "[]", "injected": "[]", "unobservable": "[]"}
        row |= {
            "components": "[]",
            "scanner_truth": "null",
            "surface_truth": "null",
            "told_significance": "[]",
        }
        start = process_time()
        try:
            simulated, floor = scenes(design, again, root)
        except SimulationError as error:
            row |= {"status": "not_simulated", "reason": str(error).splitlines()[0]}
            continue
        truth = truth_of(simulated)
        row |= {f"{key}_truth": json.dumps(truth[key]) for key in ("scanner", "surface")}
        row |= {"injected": json.dumps(truth["injected"])}
        if design.outer_split:
            return row | with_outer_split(design, again, simulated, floor, process_time() - start)
        row |= noise_limited_error(dataset_in_memory(floor), floor) | told(simulated, truth)
        row["simulate_s"] = process_time() - start
        start = process_time()
        answer = answered(dataset_in_memory(simulated), [], simulated.truth_poses)
        return row | {"diagnose_s": process_time() - start} | answer
    return row  # pyright: ignore[reportPossiblyUnboundVariable]


def with_outer_split(
    design: Design, trial: Trial, simulated: SimulatedScene, floor: SimulatedScene, simulate_s: float
) -> dict[str, Any]:
    """Return the entries of a set that is diagnosed without and with the outer split; half of its poses are measured, and the others are unseen.

    Args:
        design: The stratified trials.
        trial: The set.
        simulated: Its scene, with twice as many poses.
        floor: The scene of its floor, with the same poses.
        simulate_s: Processor time so far [s].
    """
    seen = seen_poses(simulated, trial.seed)
    start, dataset = process_time(), all_poses(simulated).subset(seen)
    entries = noise_limited_error(dataset_in_memory(floor).subset(seen), floor)
    entries |= {"simulate_s": simulate_s + process_time() - start}
    start = process_time()
    entries |= answered(
        dataset, [], simulated.truth_poses, more=lambda diagnosis: quick_errors(diagnosis, simulated, ~seen)
    )
    entries |= {"diagnose_s": process_time() - start}
    return entries | split_answer(dataset, simulated, ~seen, design.outer_split)


def scenes(design: Design, trial: Trial, root: Path) -> tuple[SimulatedScene, SimulatedScene]:
    """Return the scene of a trial, and the scene whose calibration gives its floor; with an outer split both have twice as many poses.

    Raises:
        SimulationError: Too few postures see a target plane, or a scan leaves its target plane.
    """
    # Imported here: the simulator needs pybullet, an optional dependency.
    from scalar.simulation.config import load_config
    from scalar.simulation.plan import plan_poses
    from scalar.simulation.scene import simulate

    scene = root / design.content["robots"][trial.conditions["robot"]]["scene"]
    poses_per_plane = trial.conditions["poses"] // len(load_config(scene)["planes"])
    poses_per_plane *= 2 if design.outer_split else 1
    config = scene_config(
        scene,
        [trial.overrides],
        seed=trial.seed,
        name=f"set-{trial.number}",
        poses_per_plane=poses_per_plane,
        injected=[dict(entry) for entry in trial.injected],
    )
    plan = plan_poses(config)
    simulated = simulate(config, plan=plan)
    ideal = {block: config[block] | changes for block, changes in WITHOUT_FLAWS.items()}
    return simulated, simulate({**config, **ideal, "injected": []}, plan=plan)


def truth_of(simulated: SimulatedScene) -> dict[str, Any]:
    """Return the truth of a simulated scene, as ``trial_score`` takes it."""
    keys = ("name", "kind", "target", "size")
    return {
        "injected": [{k: entry[k] for k in keys if k in entry} for entry in simulated.truth["effects"]],
        "scanner": simulated.truth.get("scanner"),
        "surface": simulated.truth.get("surface"),
    }


def noise_limited_error(dataset: Dataset, floor: SimulatedScene) -> dict[str, float | None]:
    """Return ``{"position_floor_mm": the noise-limited error [mm]}``; None if the scene of the floor cannot be calibrated.

    Args:
        dataset: The poses of the scene of the floor that are measured.
        floor: This scene.
    """
    try:
        calibration = calibrate(dataset)
    except ScalarError:
        return {"position_floor_mm": None}
    return {"position_floor_mm": errors(calibration, floor.truth_poses, "floor")["position_floor_mm"]}
