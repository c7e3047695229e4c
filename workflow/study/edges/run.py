"""Add faults of several degrees to a simulated dataset, diagnose each, and compare with the truth: a row for each degree. No dataset is written."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from traceback import print_exc
from typing import Any

import numpy as np
import pandas as pd

from scalar.data.dataset import Dataset
from scalar.diagnosis import diagnose
from scalar.errors import ScalarError
from study.blind_trials.run import errors
from study.blind_trials.score import NOISES
from study.common.grid import with_overrides
from study.common.in_memory import dataset_in_memory
from study.common.outcomes import CRASHED
from study.common.scene_config import scene_config
from study.edges.axes import AXES

INJECTED: dict[str, list[dict[str, Any]]] = {
    "nothing": [],
    "gear": [{"effect": "joint_harmonic", "size": 3.0e-4}],  # rad; its joint and order are drawn
}
SCENE = {"poses_per_plane": 25, "sensor.points_per_scan": 40, "truth_poses": 500}
"""Keys of the scene that all sets share."""
EDGE_COLUMNS = {
    "axis": "kind of fault",
    "value": "its degree, in the unit of the axis",
    "seed": "seed of all random draws in the scene",
    "injected": "nothing, or gear: one eccentric gear",
    "answer": "right: exactly the injected effects are named; wrong: another effect is named, or the gear is not; refused; "
    "crashed: by a defect of this program",
    "reason": "first line of the message of a refusal or a crash",
    "verdict": "verdict of the diagnosis",
    "position_after_mm": "mean error of positions over the evaluation poses, base aligned, by the calibration that is shipped",
    "position_max_after_mm": "the largest of them",
}
_SEED_OF_SPOILING = 51_337  # with the scene's seed, the seed of the draws that spoil a dataset


def run_edges(scene: Path, values: Mapping[str, Sequence[float]], seeds: Sequence[int]) -> pd.DataFrame:
    """Return the rows of all axes, columns ``EDGE_COLUMNS``; the dataset without a fault is diagnosed once, and has a row in each axis.

    Args:
        scene: Config file of the scene that all datasets start from.
        values: The values to try, ``{key of AXES: values}``.
        seeds: Seeds of the scenes.
    """
    from scalar.simulation.plan import plan_poses
    from scalar.simulation.scene import simulate

    degrees = [(axis, value) for axis, tried in values.items() for value in tried]
    rows = []
    for seed in seeds:
        config = scene_config(scene, [SCENE], seed=seed)
        plan = plan_poses(config, base_dir=scene.parent)
        for name, injected in INJECTED.items():
            without_fault = None
            for axis, value in degrees:
                fault = AXES[axis]
                found = without_fault if value == fault.scene_value else None
                if found is None:
                    made = with_overrides(config, fault.overrides(value)) | {"injected": injected}
                    simulated = simulate(made, base_dir=scene.parent, plan=plan)
                    rng = np.random.default_rng([seed, _SEED_OF_SPOILING])
                    found = answer(
                        lambda s=simulated, v=value, r=rng, f=fault: f.spoil(dataset_in_memory(s), v, r),
                        simulated.truth["effects"],
                        simulated.truth_poses,
                    )
                    print(f"{axis} {value:g}, seed {seed}, {name}: {found['answer']}", flush=True)
                if value == fault.scene_value:
                    without_fault = found
                rows.append({"axis": axis, "value": value, "seed": seed, "injected": name, **found})
    return pd.DataFrame(rows).reindex(columns=list(EDGE_COLUMNS))


def answer(make: Any, injected: Sequence[Mapping[str, Any]], truth_poses: pd.DataFrame) -> dict[str, Any]:
    """Make a dataset and diagnose it; return the answer and the errors, as entries of a row.

    Args:
        make: Function without arguments that returns the dataset, or raises a ``ScalarError``.
        injected: The injected effects, entries of truth.json.
        truth_poses: Joint angles and true frames at the evaluation poses, content of ``truth_poses.csv``.
    """
    try:
        dataset: Dataset = make()
        found = diagnose(dataset, outer_folds=0)
        mapping = found.to_mapping()
        return {
            "answer": "right" if is_right(mapping["effects"], injected) else "wrong",
            "verdict": mapping["verdict"],
            **errors(found.calibration_after, truth_poses, "after"),
        }
    except ScalarError as error:
        return {"answer": "refused", "reason": str(error).splitlines()[0]}
    except Exception as error:  # a defect of this program: counted, and the other sets are still run
        print_exc()
        return {"answer": CRASHED, "reason": f"{type(error).__name__}: {error}".splitlines()[0]}


def is_right(found: Sequence[Mapping[str, Any]], injected: Sequence[Mapping[str, Any]]) -> bool:
    """Return whether the named effects are those that were injected, each on its joint; variance components are not compared."""

    def places(entries: Sequence[Mapping[str, Any]]) -> set[tuple[str, Any]]:
        return {(e["name"], e["target"].get("joint")) for e in entries if e["name"] not in NOISES}

    return places(found) == places(injected)
