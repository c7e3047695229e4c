"""Plant, diagnose blind, compare with the truth: a row a set, in memory.

The diagnosis is given the ``Dataset`` that its folder would be read as, and nothing else. Beside it stands a twin:
the same scene, seeds and noise without what was planted, calibrated; its error is the floor.
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

from scalar.diagnosis import Diagnosis, diagnose
from scalar.errors import ScalarError
from scalar.estimation.calibrate import calibrate
from scalar.estimation.result import Calibration
from scalar.evaluate import aligned_to, pose_errors, true_frames
from scalar.units import MM
from study.blind_trials.cases import Set, Study
from study.blind_trials.gross_errors import spoiled
from study.common.grid import with_overrides
from study.common.memory import dataset_in_memory

if TYPE_CHECKING:
    from scalar.simulation.plan import PosePlan

SET_COLUMNS = {
    "case": "of configs/closed_loop.yaml",
    "kind": "single, null, pair or unknown",
    "cell": "robot, scanner and plates",
    "seed": "of all chance in the scene",
    "size": "multiple of the effect's natural size",
    "status": "diagnosed; not_simulated; the error that ended the diagnosis, or crashed: a defect of ours",
    "reason": "of a failure, its first line",
    "planted": "JSON, what truth.json says: name, target, size",
    "verdict": "of diagnosis.json",
    "found": "JSON, the entries of diagnosis.json without their coefficients",
    "silent": "JSON, names and targets that the diagnosis says it cannot see",
    "signal_over_noise": "rms that the planted leaves in a fit without it, over the rms that noise leaves",
    "wrong_poses": "number of poses spoiled on purpose",
    "wrong_poses_found": "of them, those listed as outliers",
    "held_out_before_mm": "rms over poses held out, without the effects found",
    "held_out_after_mm": "with them",
    "held_out_floor_mm": "what the stated noise alone leaves",
    "position_before_mm": "mean error over the evaluation poses, base aligned, without the effects found",
    "position_after_mm": "with them",
    "position_floor_mm": "of the twin, the same scene and noise without what was planted, calibrated",
    "position_max_before_mm": "the largest of them",
    "position_max_after_mm": "the largest of them",
    "position_max_floor_mm": "the largest of them",
}
CRASHED = "crashed"
_SEED_OF_DIRT = 40_917  # beside the scene's own seed


@dataclass(frozen=True, eq=False)
class Twin:
    """A scene without anything planted: its config and postures, and what its calibration comes to.

    Attributes:
        floor: Errors over the evaluation poses [mm]. residual_rms: Of its points [m]: what the noise leaves.
    """

    config: Mapping[str, Any]
    base_dir: Path
    plan: PosePlan
    floor: dict[str, float | None]
    residual_rms: float


def run_sets(study: Study, case: str, cell: str, repetitions: str, root: Path) -> pd.DataFrame:
    """Return the sets of a job: a row a set, columns ``SET_COLUMNS``.

    Args:
        study: The closed loop. case, cell, repetitions: A job of it.
        root: Where the paths of scenes start.

    Raises:
        InvalidInput: The scene is at fault.
        SimulationError: Too few postures see a plate.
    """
    rows = []
    for seed, sets in groupby(study.sets(case, cell, repetitions), key=lambda wanted: wanted.seed):
        twin = make_twin(study, cell, seed, root)
        signals: dict[str, float | None] = {}
        for wanted in sets:
            row = run_set(wanted, twin, signals)
            rows.append(row)
            names = (
                [entry["name"] for entry in json.loads(row["found"])]
                if row["status"] == "diagnosed"
                else row["reason"]
            )
            print(f"{case} {cell} seed {seed} size {wanted.size:g}: {row.get('verdict')} {names}", flush=True)
    return pd.DataFrame(rows).reindex(columns=list(SET_COLUMNS))


def make_twin(study: Study, cell: str, seed: int, root: Path) -> Twin:
    """Return the twin of all sets of a cell and seed."""
    # The simulator is an extra; a diagnosis of one's own data does without.
    from scalar.simulation.config import complete_config, load_config
    from scalar.simulation.plan import plan_poses
    from scalar.simulation.scene import simulate

    scene = root / study.cells[cell]["scene"]
    config = load_config(scene)
    for overrides in (study.scene, study.cells[cell]["overrides"]):
        config = with_overrides(config, overrides)
    config = complete_config(config | {"seed": seed, "name": cell}, base_dir=scene.parent)
    plan = plan_poses(config, base_dir=scene.parent)
    simulated = simulate(config, base_dir=scene.parent, plan=plan)
    calibration = calibrate(dataset_in_memory(simulated))
    floor = errors(calibration, simulated.truth_poses, "floor")
    return Twin(config, scene.parent, plan, floor, calibration.residual_rms)


def run_set(wanted: Set, twin: Twin, signals: dict[str, float | None] | None = None) -> dict[str, Any]:
    """Return the row of one set.

    Args:
        wanted: What to plant. twin: Of its cell and seed.
        signals: By what is planted, for a size of 1: kept from one size to the next, to which they are in proportion.
    """
    from scalar.simulation.errors import SimulationError
    from scalar.simulation.scene import simulate

    row: dict[str, Any] = {key: getattr(wanted, key) for key in ("case", "kind", "cell", "seed", "size")}
    row |= {"found": "[]", "planted": "[]", "silent": "[]"} | twin.floor
    config = planted_config(wanted, twin)
    try:
        simulated = simulate(config, base_dir=twin.base_dir, plan=twin.plan)
    except SimulationError as error:
        return row | {"status": "not_simulated", "reason": str(error).splitlines()[0]}
    planted = [
        {key: entry.get(key) for key in ("name", "target", "size")} for entry in simulated.truth["effects"]
    ]
    row["planted"] = json.dumps(planted)
    row["signal_over_noise"] = signal_over_noise(wanted, twin, {} if signals is None else signals)
    rng = np.random.default_rng([wanted.seed, _SEED_OF_DIRT])
    dataset, wrong = spoiled(dataset_in_memory(simulated), wanted.dirt, rng)
    try:
        answer = found(diagnose(dataset), wrong, simulated.truth_poses)
    except ScalarError as error:
        return row | {"status": type(error).__name__, "reason": str(error).splitlines()[0]}
    except (
        Exception
    ) as error:  # a defect of ours: counted as one, and one set of thousands does not stop the others
        print_exc()
        return row | {"status": CRASHED, "reason": f"{type(error).__name__}: {error}".splitlines()[0]}
    return row | {"status": "diagnosed"} | answer


def planted_config(wanted: Set, twin: Twin) -> dict[str, Any]:
    """Return the config of a set's scene."""
    config = with_overrides(twin.config, wanted.overrides)
    return config | {"planted": [dict(entry) for entry in wanted.planted]}


def found(diagnosis: Diagnosis, wrong: list[int], truth_poses: pd.DataFrame) -> dict[str, Any]:
    """Return what a diagnosis says, as cells of a row.

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
        "silent": json.dumps([{"name": s["name"], "target": s["target"]} for s in mapping["unobservable"]]),
        "wrong_poses": len(wrong),
        "wrong_poses_found": len(set(wrong) & set(mapping["outliers"]["poses"])),
        "held_out_before_mm": residual["before"]["held_out_rms_mm"],
        "held_out_after_mm": residual["after"]["held_out_rms_mm"],
        "held_out_floor_mm": residual["floor_mm"],
        **errors(diagnosis.calibration_before, truth_poses, "before"),
        **errors(diagnosis.calibration_after, truth_poses, "after"),
    }


def errors(calibration: Calibration, truth_poses: pd.DataFrame, when: str) -> dict[str, float | None]:
    """Return mean and largest position error [mm] over true poses, base aligned; None where the calibration cannot say."""
    T_true = true_frames(truth_poses)
    try:
        position = pose_errors(T_true, aligned_to(T_true, calibration.predict(truth_poses))).position / MM
    except ScalarError:
        return {f"position_{when}_mm": None, f"position_max_{when}_mm": None}
    return {f"position_{when}_mm": float(position.mean()), f"position_max_{when}_mm": float(position.max())}


def signal_over_noise(wanted: Set, twin: Twin, known: dict[str, float | None]) -> float | None:
    """Return how much of what is planted a fit without it leaves, over what the noise leaves; both rms over all points.

    Taken from the same scene without noise, at the size asked for first, and in proportion for the others.
    """
    from scalar.simulation.scene import simulate

    if not wanted.planted:
        return 0.0
    key = json.dumps(
        [{k: v for k, v in entry.items() if k != "size"} for entry in wanted.planted], sort_keys=True
    )
    if key not in known:
        noise = twin.config["noise"]
        quiet = planted_config(wanted, twin) | {"noise": {**noise, "range_noise_std_m": 0.0}}
        dataset = dataset_in_memory(simulate(quiet, base_dir=twin.base_dir, plan=twin.plan))
        stated = replace(dataset, sensor=replace(dataset.sensor, noise=noise["range_noise_std_m"]))
        try:
            known[key] = calibrate(stated).residual_rms / twin.residual_rms / wanted.size
        except ScalarError:
            known[key] = None
    unit = known[key]
    return None if unit is None else unit * wanted.size
