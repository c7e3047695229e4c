"""Run all contestants on stratified sets: ``python -m benchmarks.diagnosis.stratified --sets 40 -o benchmarks/diagnosis/results.csv``.

The table has a row for each set and contestant: what it named, scored by the rules of the blind trials, and the mean position error over
unseen poses before and after its correction. The rivals begin with the cleaned dataset and the calibration without effects of the diagnosis, so
that none has to deal with gross errors. Every rival's correction is its whole answer, refitted; the diagnosis decides for itself what it ships.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
import pandas as pd

ROOT = Path(__file__).parents[2]
sys.path[:0] = [str(ROOT / "workflow")]

from study.blind_trials.run import errors  # noqa: E402
from study.blind_trials.statistics import wilson  # noqa: E402
from study.blind_trials.stratified_design import Design, Trial, load_design  # noqa: E402
from study.blind_trials.stratified_run import ATTEMPTS, scenes, truth_of  # noqa: E402
from study.blind_trials.stratified_score import WORSE, trial_score  # noqa: E402
from study.common.in_memory import dataset_in_memory  # noqa: E402
from study.common.provenance import code_version  # noqa: E402
from study.common.tables import write_table  # noqa: E402

from benchmarks.diagnosis.compensation import Compensation  # noqa: E402
from benchmarks.diagnosis.rivals import chosen_by_lasso, chosen_by_steps, entries  # noqa: E402
from benchmarks.diagnosis.stability import chosen_by_stability  # noqa: E402
from scalar.data.io.atomic import write_json  # noqa: E402
from scalar.diagnosis.diagnose import diagnose  # noqa: E402
from scalar.diagnosis.fit.fitted_state import FittedState  # noqa: E402
from scalar.effects import Effect  # noqa: E402
from scalar.errors import ScalarError  # noqa: E402
from scalar.estimation.reporting import sensor_mapping  # noqa: E402
from scalar.estimation.result import Calibration  # noqa: E402
from scalar.evaluate import aligned_to, pose_errors, true_frames  # noqa: E402
from scalar.geometry.se3 import Array  # noqa: E402
from scalar.sensors import as_scans, measure  # noqa: E402
from scalar.simulation.errors import SimulationError  # noqa: E402
from scalar.simulation.scene import SimulatedScene  # noqa: E402
from scalar.units import MM  # noqa: E402

DIAGNOSIS, PROCESS = "diagnosis", "gaussian-process"
CONTESTANTS = (DIAGNOSIS, "stepwise", "lasso", "stability", PROCESS)
COLUMNS = (
    "number", "row", "poses", "contestant", "status", "named", "injected", "clean", "missed", "wrong",
    "wrong_sure", "worse", "much_worse", "after_over_before", "position_before_mm", "position_after_mm", "seconds",
)  # fmt: skip


def run(design: Design, trial: Trial) -> list[dict[str, Any]]:
    """Return a row for each contestant; an empty list if the scene cannot be simulated."""
    for attempt in range(ATTEMPTS):
        again = design.trial(trial.number, trial.conditions, attempt) if attempt else trial
        try:
            simulated, _ = scenes(design, again, ROOT)
        except SimulationError:
            continue
        return _rows(trial, simulated)
    return []


def _rows(trial: Trial, simulated: SimulatedScene) -> list[dict[str, Any]]:
    key = {"number": trial.number, "row": trial.row, "poses": trial.conditions["poses"]}
    truth, there = truth_of(simulated), simulated.truth_poses
    start = process_time()
    diagnosis = diagnose(dataset_in_memory(simulated))
    took = process_time() - start
    before = errors(diagnosis.calibration_before, there, "before")["position_before_mm"]
    said = json.loads(json.dumps(diagnosis.to_mapping()))
    after = errors(diagnosis.calibration_after, there, "after")["position_after_mm"]
    rows = [_row(DIAGNOSIS, truth, said["effects"], said["unobservable"], before, after, took)]
    state = diagnosis.before
    for name, choose in (
        ("stepwise", chosen_by_steps),
        ("lasso", chosen_by_lasso),
        ("stability", lambda state: chosen_by_stability(state, np.random.default_rng(trial.seed))),
    ):
        start = process_time()
        chosen = choose(state)
        reached = _position_after(state, chosen, simulated)
        rows.append(_row(name, truth, entries(chosen), [], before, reached, process_time() - start))
    start = process_time()
    reached = _compensated(state, diagnosis.calibration_before, simulated)
    rows.append(_row(PROCESS, truth, [], [], before, reached, process_time() - start))
    return [key | row for row in rows]


def _row(
    name: str,
    truth: dict[str, Any],
    found: list[dict[str, Any]],
    unobservable: list[dict[str, Any]],
    before: float | None,
    after: float | None,
    seconds: float,
) -> dict[str, Any]:
    """Return the columns of one contestant; what is about names is left empty for one that gives none."""
    found = json.loads(json.dumps(found))
    score = trial_score(truth, found, unobservable, {"before": before, "after": after})
    if name == PROCESS:
        score |= dict.fromkeys(("clean", "missed", "wrong", "wrong_sure"), None)
    return {
        "contestant": name,
        "status": "failed" if after is None else "answered",
        "named": json.dumps([{k: e.get(k) for k in ("name", "target", "confidence")} for e in found]),
        "injected": json.dumps(truth["injected"]),
        "position_before_mm": before,
        "position_after_mm": after,
        "seconds": seconds,
    } | {key: score[key] for key in COLUMNS if key in score}


def _position_after(
    state: FittedState, chosen: tuple[Effect, ...], simulated: SimulatedScene
) -> float | None:
    """Return the mean position error [mm] over unseen poses with the chosen effects refitted; None if they cannot be fitted."""
    try:
        model = state.refitted(chosen).model
        calibration = Calibration(model, sensor_mapping(state.dataset))
        return errors(calibration, simulated.truth_poses, "after")["position_after_mm"]
    except (ScalarError, np.linalg.LinAlgError):
        return None


def _compensated(state: FittedState, calibration: Calibration, simulated: SimulatedScene) -> float:
    """Return the mean position error [mm] over unseen poses with the Gaussian process's error added to the calibration without effects."""
    dataset = state.dataset
    process = Compensation(dataset.q, *_normals_and_distances(state))
    T_true = true_frames(simulated.truth_poses)
    T = calibration.predict(simulated.truth_poses)
    q = simulated.truth_poses[[f"q{i + 1}" for i in range(dataset.q.shape[1])]].to_numpy()
    T[:, :3, 3] += process.error_at(q)
    return float(pose_errors(T_true, aligned_to(T_true, T)).position.mean() / MM)


def _normals_and_distances(state: FittedState) -> tuple[Array, Array]:
    """Return the normal ``(N, 3)`` of each pose's target plane and the mean distance ``(N,)`` [m] of its points from it."""
    measurement = as_scans(measure(state.dataset))
    planes: Any = state.model.target
    index = measurement.target_index.astype(np.intp)
    T = state.residuals.kinematics(state.model).T_base_sensor
    starts = np.asarray(measurement.starts, dtype=np.intp)
    middle = np.add.reduceat(measurement.points, starts[:-1], axis=0) / np.diff(starts)[:, None]
    place = T[:, :3, 3] + middle[:, :1] * T[:, :3, 0] + middle[:, 1:] * T[:, :3, 2]
    normals = planes.normals[index]
    return normals, np.einsum("ni,ni->n", normals, place) - planes.distances[index]


def summary(table: pd.DataFrame) -> dict[str, Any]:
    """Return counts of each contestant over all sets, medians of the errors, and how it stands against the diagnosis set by set.

    ``clean_low`` and ``clean_high`` are Wilson's interval of the share of clean answers. ``only_diagnosis_clean`` and ``only_this_clean`` count sets
    that one of the two answers without a fault; ``nearer`` and ``farther`` those in which the error after this contestant's correction
    is by more than 5 % smaller or larger than after that of the diagnosis.
    """
    found: dict[str, Any] = {"sets": int(table["number"].nunique())}
    of_diagnosis: Any = table[table["contestant"] == DIAGNOSIS].set_index("number")
    for name, rows in table.groupby("contestant", sort=False):
        own: Any = rows.set_index("number")
        found[str(name)] = {
            key: None if own[key].isna().all() else int(np.count_nonzero(own[key].astype(bool)))
            for key in ("clean", "missed", "wrong", "worse", "much_worse")
        } | {
            "median_after_over_before": float(own["after_over_before"].median()),
            "seconds": float(own["seconds"].median()),
        }
        if found[str(name)]["clean"] is not None:
            low, high = wilson(found[str(name)]["clean"], len(own))
            here, there = own["clean"].astype(bool), of_diagnosis["clean"].astype(bool)
            found[str(name)] |= {
                "clean_share": found[str(name)]["clean"] / len(own),
                "clean_low": low,
                "clean_high": high,
                "only_diagnosis_clean": int((there & ~here).sum()),
                "only_this_clean": int((here & ~there).sum()),
            }
        times = (own["position_after_mm"] / of_diagnosis["position_after_mm"]).to_numpy(dtype=float)
        found[str(name)] |= {
            "nearer": int(np.sum(times < 1 / WORSE)),
            "farther": int(np.sum(times > WORSE)),
        }
    return found


def main() -> None:
    """Run the sets that the table lacks, and print a line for each; a run that was stopped goes on where it was."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--config", default=str(ROOT / "configs/blind_trials_benchmark.yaml"))
    parser.add_argument("--sets", type=int, default=None, help="only the first of the design")
    parser.add_argument("-o", "--out", type=Path, default=Path("benchmark_diagnosis.csv"))
    parser.add_argument("--summary", type=Path, default=None, help="where the counts are written as JSON")
    options = parser.parse_args()
    design = load_design(options.config)
    table = pd.read_csv(options.out) if options.out.exists() else pd.DataFrame(columns=list(COLUMNS))
    for trial in design.trials(options.sets):
        if trial.number in set(table["number"]):
            continue
        rows = pd.DataFrame(run(design, trial)).reindex(columns=list(COLUMNS))
        table = rows if table.empty else pd.concat([table, rows], ignore_index=True)
        write_table(options.out, table)
        ratios = dict(zip(rows["contestant"], rows["after_over_before"].round(2), strict=True))
        print(f"set {trial.number} {trial.row}: {ratios}", flush=True)
    numbers = {"code": code_version()} | summary(table)
    print(json.dumps(numbers, indent=1))
    if options.summary is not None:
        write_json(options.summary, numbers)


if __name__ == "__main__":
    main()
