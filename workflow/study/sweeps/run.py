"""Run cases of a sweep for every kind of walls and seed: simulate, calibrate by every method, compare with the truth.

Datasets are kept in memory only. A fit that fails has a row too, with the reason. With any number of poses, the baseline fixes the parameters
that the original paper fixes, which the scene declares exact. Errors are taken over the first 2,000 of the 10,000 evaluation poses; their mean
differs from that over all by about 1 %, and their maximum is about 1 % lower.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from scalar.baseline.batched import fit_baseline
from scalar.errors import NotConverged, ScalarError, Undetermined
from scalar.estimation.calibrate import calibrate
from scalar.estimation.reporting import sensor_mapping
from scalar.estimation.result import Calibration
from scalar.evaluate import aligned_to, pose_errors, true_frames
from scalar.geometry.robot import Tolerance
from scalar.geometry.se3 import Array
from scalar.units import DEG, MM
from study.common.bound import POSES, bound_errors
from study.common.grid import with_overrides
from study.common.in_memory import dataset_in_memory
from study.common.methods import BOUND, CONVERGED, EFFICIENT, EVERY_METHOD, INITIAL, Method
from study.common.statistics import POSE_ERROR_COLUMNS, QUANTITIES
from study.sweeps.plans import Shared, read_plans, serves

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset

SWEEP_COLUMNS = {
    "walls": "kind of walls; each kind is a scene",
    "case": "row of the grid",
    "seed": "seed of all random draws in the scene",
    "method": "proposed, proposed-tolerance (the tolerance of the arm is stated), "
    "baseline-READING (the original paper's method), initial (before calibration), cramer-rao (the bound), "
    "efficient (the efficient estimate, which attains the bound)",
    **POSE_ERROR_COLUMNS,
    "residual_rms_mm": "RMS distance of the points from their planes after the fit",
    "evaluations": "number of evaluations of the residual by the solver",
    "reason": "first line of the message of a fit that failed",
}
_ROOT_AS_IT_IS = Method("baseline-raise", "raise")
"""The baseline whose fit ends with the status ``raised`` as soon as the argument of the square root is negative."""
_SAME_WITHOUT_A_NEGATIVE_ROOT = (Method("baseline-abs", "abs"), Method("baseline-clip", "clip"))
"""Variants of the baseline that give the same fit if that argument never becomes negative."""
MAX_EVALUATIONS = 2000
"""Evaluations of the residual after which a fit of the baseline is stopped (``capped``); one that converges takes some hundreds."""
FINEST = 9
"""Decimals of an error in mm or deg; the last one is a picometre. Further decimals of a noise-free fit are rounding of its own arithmetic."""
DIGITS = 6
"""Significant digits of a number in a table; further ones depend on rounding in the last step of a fit."""


def sweep_cases(
    cases: Mapping[str, Mapping[str, Any]],
    scenes: Mapping[str, str | Path],
    seeds: Sequence[int],
    methods: Sequence[str],
    plans: Mapping[str, str | Path],
) -> pd.DataFrame:
    """Return the errors of every method, of the initial model and of the bound: a row for each kind of walls, case, seed, method and alignment.

    Args:
        cases: ``{case: {dotted key: value}}``.
        scenes: ``{walls: config file of the scene}``.
        seeds: Seeds of the scenes.
        methods: Keys of ``study.common.methods.EVERY_METHOD``.
        plans: ``{walls: file with postures and scans that write_plans wrote}``. A case with another workcell cannot use them, and draws its own.

    Raises:
        InvalidInput: The scene is at fault.
        SimulationError: Too few postures see a target plane, or a scan leaves its target plane.
    """
    rows: list[dict[str, Any]] = []
    for walls, scene in scenes.items():
        shared = read_plans(plans[walls])
        for case, overrides in cases.items():
            key = {"walls": walls, "case": case}
            rows += [key | row for row in _rows_of_scene(Path(scene), overrides, seeds, methods, shared)]
    table = pd.DataFrame(rows).reindex(columns=list(SWEEP_COLUMNS))
    return table.round(dict.fromkeys(QUANTITIES, FINEST))


def _rows_of_scene(
    scene: Path,
    overrides: Mapping[str, Any],
    seeds: Sequence[int],
    methods: Sequence[str],
    shared: Mapping[int, Shared],
) -> Iterator[dict[str, Any]]:
    """Yield the rows of one scene with some keys replaced, for every seed, without the columns ``walls`` and ``case``."""
    # Imported here: the simulator needs pybullet, an optional dependency.
    from scalar.simulation.config import complete_config, load_config
    from scalar.simulation.scene import simulate

    config = complete_config(with_overrides(load_config(scene), overrides), base_dir=scene.parent)
    config["truth_poses"] = min(config["truth_poses"], POSES)
    fixed = config.get("initial_model", {}).get("exact", ())
    truth_poses: pd.DataFrame | None = None
    T_true, q_evaluated = np.zeros((0, 4, 4)), np.zeros((0, 0))
    for seed in seeds:
        of_seed = config | {"seed": seed}
        usable = serves(shared[seed].plan, of_seed)
        simulated = simulate(
            of_seed,
            base_dir=scene.parent,
            plan=shared[seed].plan if usable else None,
            cast=shared[seed].scans if usable else None,
        )
        if truth_poses is None or "true_robot_errors" in config:  # otherwise every seed has the same true arm
            truth_poses = simulated.truth_poses
            T_true = true_frames(truth_poses)
            q_evaluated = truth_poses[[f"q{i + 1}" for i in range(simulated.q.shape[1])]].to_numpy()
        dataset = dataset_in_memory(simulated)
        statuses = []
        bound = bound_errors(dataset, simulated.truth, fixed, truth_poses)
        for name, errors in zip((BOUND, EFFICIENT), bound or (), strict=False):
            yield {"seed": seed, "method": name, "status": name, "alignment": "raw"} | errors
        with_root_as_it_is: list[dict[str, Any]] | None = None
        for method in sorted((INITIAL, *methods), key=lambda name: name != _ROOT_AS_IT_IS.name):
            may_be_same = EVERY_METHOD.get(method) in _SAME_WITHOUT_A_NEGATIVE_ROOT
            if may_be_same and with_root_as_it_is is not None and with_root_as_it_is[0]["status"] != "raised":
                # The argument of the root was never negative, so every reading of the root gives the same bits.
                found = [row | {"method": method} for row in with_root_as_it_is]
            else:
                key = {"seed": seed, "method": method}
                stated = EVERY_METHOD[method].states_tolerance if method in EVERY_METHOD else False
                own = stating_tolerance(dataset, config) if stated else dataset
                found = _rows_of_method(key, own, fixed, T_true, q_evaluated)
            with_root_as_it_is = found if method == _ROOT_AS_IT_IS.name else with_root_as_it_is
            statuses.append(f"{method} {found[0]['status']}")
            yield from found
        print(f"{scene.stem}, seed {seed}: {', '.join(statuses)}", flush=True)


def stating_tolerance(dataset: Dataset, config: Mapping[str, Any]) -> Dataset:
    """Return a dataset whose arm has as its tolerance the standard deviations of the errors of the initial model.

    Args:
        dataset: What was measured.
        config: Content of the scene, with ``length_std_m`` and ``angle_std_deg`` of its ``initial_model``.
    """
    errors = config["initial_model"]
    tolerance = Tolerance(errors["length_std_m"], errors["angle_std_deg"] * DEG)
    return replace(dataset, robot=replace(dataset.robot, tolerance=tolerance))


def _rows_of_method(
    key: dict[str, Any], dataset: Dataset, fixed: Sequence[str], T_true: Array, q_evaluated: Array
) -> list[dict[str, Any]]:
    """Return the raw and the aligned row of one method."""
    try:
        calibration, ended = _calibrated(key["method"], dataset, fixed)
    except ScalarError as error:
        status = _status(error)
        reason = str(error).splitlines()[0]
        return [key | {"status": status, "alignment": a, "reason": reason} for a in ("raw", "aligned")]
    # The calibrations have no effects, which could need more of a pose than its joint angles.
    T_hat = calibration.predict(q_evaluated)
    return [
        key | ended | {"alignment": alignment} | pose_errors(T_true, T).to_mapping()
        for alignment, T in (("raw", T_hat), ("aligned", aligned_to(T_true, T_hat)))
    ]


def _calibrated(method: str, dataset: Dataset, fixed: Sequence[str]) -> tuple[Calibration, dict[str, Any]]:
    """Return a calibration by a method, and the columns on how its fit ended."""
    if method == INITIAL:
        return Calibration.nominal(dataset), {"status": INITIAL}
    wanted = EVERY_METHOD[method]
    if wanted.reading is not None:
        end = fit_baseline(
            dataset, wanted.reading, fixed, MAX_EVALUATIONS, wanted.defaults, wanted.nan_policy
        )
        ended = {"status": end.status, "evaluations": end.evaluations, "residual_rms_mm": end.rms / MM}
        return Calibration(end.model, sensor_mapping(dataset)), ended
    found = calibrate(dataset, explain=False)
    return found, {
        "status": CONVERGED,
        "evaluations": found.summary.get("evaluations"),
        "residual_rms_mm": found.residual_rms / MM,
    }


def _status(error: ScalarError) -> str:
    """Return the status of a calibration that ended in an error."""
    if isinstance(error, NotConverged):
        return "not_converged"
    return "undetermined" if isinstance(error, Undetermined) else "refused"
