"""Separate what the parameters contribute to convergence from what the start contributes: both methods from the start of either.

The proposed method starts from the better of two poses of the scanner, and fits scanner and planes to the nominal arm before anything else; the
baseline starts from the guessed planes and a linear estimate. Here the proposed method is also run without a stated pose of the scanner, so that
linear estimates are its only start, and the clipped reading of the baseline also with the planes of the proposed method's initial estimate as its
guesses.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pandas as pd

from scalar.baseline.batched import fit_baseline
from scalar.errors import ScalarError
from scalar.estimation.calibrate import calibrate
from scalar.estimation.initial_estimate import estimate_initially
from scalar.estimation.model import Model
from scalar.estimation.reporting import sensor_mapping
from scalar.estimation.residuals import Residuals
from scalar.estimation.result import Calibration
from scalar.evaluate import pose_errors, true_frames
from scalar.geometry.planes import Planes
from scalar.geometry.se3 import Array
from scalar.sensors import measure
from study.common.bound import POSES
from study.common.grid import with_overrides
from study.common.in_memory import dataset_in_memory
from study.common.methods import CONVERGED
from study.sweeps.plans import Shared, serves
from study.sweeps.run import MAX_EVALUATIONS
from study.sweeps.summary import LOST_MM

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset

READING = "clip"
PROPOSED, BASELINE = "proposed", f"baseline-{READING}"
OWN, OTHER = "own", "other"
START_COLUMNS = {
    "axis": "sweep to which the case belongs",
    "walls": "kind of walls; each kind is a scene",
    "case": "row of the grid",
    "value": "value of the case on the axis of its sweep, in the unit of its label",
    "seed": "seed of all random draws in the scene",
    "method": "proposed, or baseline-READING",
    "start": "own: as the method starts elsewhere; other: without a stated pose of the scanner (proposed), or from the planes of the proposed "
    "method's initial estimate (baseline)",
    "status": "converged, or how the fit ended",
    "position_mean_mm": "mean position error over the first 2,000 of the evaluation poses, raw",
}


def compare_starts(
    scene: str | Path,
    cases: Mapping[str, Mapping[str, Any]],
    seeds: Sequence[int],
    plans: Mapping[int, Shared],
) -> pd.DataFrame:
    """Return how the fits of both methods end from both starts: a row for each case, seed, method and start.

    The columns are those of ``START_COLUMNS`` from ``case`` on, without ``value``.

    Args:
        scene: Config file of the scene.
        cases: ``{case: {dotted key: value}}``, such as the tilts of the initial planes.
        seeds: Seeds of the scene.
        plans: ``{seed: postures and scans}``, as ``study.sweeps.plans.read_plans`` returns them.

    Raises:
        InvalidInput: The scene is at fault.
        SimulationError: Too few postures see a target plane, or a scan leaves its target plane.
    """
    # Imported here: the simulator needs pybullet, an optional dependency.
    from scalar.simulation.config import complete_config, load_config
    from scalar.simulation.scene import simulate

    scene = Path(scene)
    rows: list[dict[str, Any]] = []
    for case, overrides in cases.items():
        config = complete_config(with_overrides(load_config(scene), overrides), base_dir=scene.parent)
        config["truth_poses"] = min(config["truth_poses"], POSES)
        fixed = config.get("initial_model", {}).get("exact", ())
        for seed in seeds:
            of_seed, shared = config | {"seed": seed}, plans[seed]
            known = {"plan": shared.plan, "cast": shared.scans} if serves(shared.plan, of_seed) else {}
            simulated = simulate(of_seed, base_dir=scene.parent, **known)
            dataset, truth = dataset_in_memory(simulated), simulated.truth_poses
            q = truth[[f"q{i + 1}" for i in range(simulated.q.shape[1])]].to_numpy()
            for method, start in ((m, s) for m in (PROPOSED, BASELINE) for s in (OWN, OTHER)):
                end = _ended(method, start, dataset, fixed)
                error = None if end[1] is None else _mean_error(truth, end[1].predict(q))
                key = {"case": case, "seed": seed, "method": method, "start": start}
                rows.append(key | {"status": end[0], "position_mean_mm": error})
        print(f"{scene.stem}, {case}: {len(rows)} fits so far", flush=True)
    return pd.DataFrame(rows)


def _ended(method: str, start: str, dataset: Dataset, fixed: Sequence[str]) -> tuple[str, Any]:
    """Return the status of a fit and its model or calibration, None if there is none."""
    try:
        if method == PROPOSED:
            sensor = dataset.sensor if start == OWN else replace(dataset.sensor, T_flange_sensor=None)
            return CONVERGED, calibrate(replace(dataset, sensor=sensor), explain=False)
        begun = dataset if start == OWN else with_initial_planes(dataset)
        end = fit_baseline(begun, READING, fixed, MAX_EVALUATIONS)
    except ScalarError as error:
        return type(error).__name__, None
    return end.status, Calibration(end.model, sensor_mapping(dataset))


def _mean_error(truth: pd.DataFrame, T: Array) -> float:
    """Return the mean position error [mm] of predicted frames ``(N, 4, 4)``."""
    return float(pose_errors(true_frames(truth), T).to_mapping()["position_mean_mm"])


def with_initial_planes(dataset: Dataset) -> Dataset:
    """Return a dataset of scans whose guesses of the planes are those of the proposed method's initial estimate, with the arm nominal."""
    measurement = measure(dataset)
    guess, T = measurement.initial_target(dataset), dataset.sensor.T_flange_sensor
    assert isinstance(guess, Planes) and T is not None
    residuals = Residuals.of(dataset, Model.at(dataset.robot, T, guess), measurement)
    planes: Any = estimate_initially(residuals, dataset.robot, guess, T).model.target
    found = {name: (n, d) for name, n, d in zip(planes.names, planes.normals, planes.distances, strict=True)}
    guesses = [replace(p, normal=found[p.name][0], distance=float(found[p.name][1])) for p in dataset.planes]
    return replace(dataset, planes=tuple(guesses))


def start_numbers(table: pd.DataFrame) -> dict[str, Any]:
    """Return the numbers that the paper quotes: ``seeds``, and for each axis, walls, method and start how its fits ended.

    ``fits`` counts them, ``failed`` those that did not converge, ``lost`` those that converged farther than ``LOST_MM`` from the truth, and
    ``all_succeed_up_to`` is the largest value of the axis up to which every fit succeeds (None if there is none).

    Args:
        table: Columns as ``START_COLUMNS``.
    """
    found: dict[str, Any] = {"seeds": len(set(table["seed"]))}
    groups: Any = table.groupby(["axis", "walls", "method", "start"], sort=False)
    for (axis, walls, method, start), rows in groups:
        failed = rows["status"] != CONVERGED
        lost = ~failed & (rows["position_mean_mm"] > LOST_MM)
        good = (~(failed | lost)).groupby(rows["value"]).all().sort_index()
        reached = good.index[good.cummin()]
        of_method = found.setdefault(axis, {}).setdefault(walls, {}).setdefault(method, {})
        of_method[start] = {
            "fits": len(rows),
            "failed": int(failed.sum()),
            "lost": int(lost.sum()),
            "all_succeed_up_to": float(reached.max()) if len(reached) else None,
        }
    return found
