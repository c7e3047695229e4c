"""Compare the errors of calibrations with planned poses and with poses drawn at random, for each of several numbers of poses.

Planned and random poses are taken from one pool of postures in which the true scanner sees a target plane. The planner knows what a user knows
before measuring: the declared arm, which differs from the true one by the errors of the scene, initial guesses of the scanner's pose and of the
planes, and the noise. Each posture of the pool has one draw of the noise, whoever chooses it. Errors are taken over the simulator's evaluation poses.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from scalar.data.dataset import Dataset
from scalar.errors import ScalarError
from scalar.estimation.calibrate import calibrate
from scalar.evaluate import aligned_to, pose_errors, true_frames
from scalar.geometry.se3 import Array
from scalar.planning.information import Information, information
from scalar.planning.plan import best_design
from scalar.planning.workcell import View, Workcell
from scalar.units import MM
from study.common.in_memory import dataset_in_memory

RANDOM, PLANNED = "random", "planned"
POSES = 1000  # the first of the evaluation poses: the standard error of their mean is some 2 %
CRITERION = "error"  # of ``scalar.planning.plan.CRITERIA``: the expected error of predicted positions
DIGITS = 6  # significant digits in the table; further ones depend on rounding in the last step of a fit
PLANNING_COLUMNS = {
    "seed": "seed of the declared arm's errors, the noise and the random choice",
    "way": f"how the poses were chosen: {RANDOM} or {PLANNED}",
    "poses": "number of poses that were calibrated",
    "status": "calibrated, or the class of the error that ended the calibration",
    "expected_error_mm": "root mean square over random poses, as the plan states it before measuring",
    "position_mean_mm": f"over the first {POSES} evaluation poses, after the best rigid motion of the base",
    "position_max_mm": "the largest of them",
    "orientation_mean_deg": "mean angle of the error rotation over the same poses",
    "orientation_max_deg": "the largest of them",
    "position_rms_mm": "root mean square over the same poses",
}


def compare_plans(
    scene: str | Path, seeds: Sequence[int], sizes: Sequence[int], pool_per_plane: int
) -> pd.DataFrame:
    """Return the errors of calibrations with planned and random poses: a row for each seed, number of poses and way of choosing them.

    Args:
        scene: Config file of a scene whose true arm is the same for every seed.
        seeds: Seeds of the declared arm's errors, the noise and the random choice.
        sizes: Numbers of poses to choose.
        pool_per_plane: Number of postures on each plane to choose from.

    Raises:
        InvalidInput: The scene is at fault.
        SimulationError: Too few postures see a target plane.
    """
    # Imported here: the simulator needs pybullet, an optional dependency.
    from dataclasses import replace

    from scalar.simulation.config import complete_config, load_config
    from scalar.simulation.plan import plan_poses, workcell_text
    from scalar.simulation.scene import simulate

    scene = Path(scene)
    config = load_config(scene) | {"poses_per_plane": pool_per_plane}
    plan = plan_poses(config, base_dir=scene.parent)
    rows: list[dict[str, Any]] = []
    for seed in seeds:
        seeded = config | {"seed": seed}
        # The true arm is the same, and so are the postures from which it sees the planes.
        same = replace(plan, workcell=workcell_text(complete_config(seeded, base_dir=scene.parent)))
        simulated = simulate(seeded, base_dir=scene.parent, plan=same)
        truth = simulated.truth_poses.head(POSES)
        pool = dataset_in_memory(simulated)
        info = _expected_information(pool, simulated.config)
        for size in sizes:
            for way in (RANDOM, PLANNED):
                rng = np.random.default_rng([seed, size])
                chosen = _chosen(info, pool, way, size, rng)
                key = {"seed": seed, "way": way, "poses": size}
                rows.append(
                    key | {"expected_error_mm": _expected(info, chosen) / MM} | _errors(pool, chosen, truth)
                )
        print(f"seed {seed}", flush=True)
    return pd.DataFrame(rows).reindex(columns=list(PLANNING_COLUMNS))


def _expected_information(pool: Dataset, config: Any) -> Information:
    """Return the information that the poses of the pool are expected to give, computed with the declared workcell."""
    view = View(points=config["sensor"]["points_per_scan"])
    workcell = Workcell.of(pool.robot, pool.sensor, pool.planes, view=view)
    return information(workcell.model, workcell.dataset(pool.q, pool.plane_index), 0.0)


def _chosen(info: Information, pool: Dataset, way: str, size: int, rng: np.random.Generator) -> list[int]:
    """Return the indices in the pool of the planned poses, or of random ones that are shared equally among the planes."""
    if way == PLANNED:
        return best_design(info, size, CRITERION, rng)[0].chosen
    planes = pool.plane_index
    share = np.bincount(np.arange(size) % (planes.max() + 1))
    return [int(i) for k, n in enumerate(share) for i in rng.permutation(np.flatnonzero(planes == k))[:n]]


def _expected(info: Information, chosen: list[int]) -> float:
    """Return the expected error of a predicted position [m], root mean square over random poses, after measuring the chosen poses."""
    A = info.rows[chosen].reshape(-1, len(info.start))
    return info.error(np.linalg.inv(info.start + A.T @ A))


def _errors(pool: Dataset, chosen: list[int], truth: pd.DataFrame) -> dict[str, Any]:
    """Return the status of a calibration with the chosen poses, and its errors against the true frames in ``truth``, base aligned."""
    T_true: Array = true_frames(truth)
    try:
        calibration = calibrate(pool.subset(np.array(chosen)))
    except ScalarError as error:
        return {"status": type(error).__name__}
    errors = pose_errors(T_true, aligned_to(T_true, calibration.predict(truth)))
    rms = float(np.sqrt(np.mean(errors.position**2)) / MM)
    return {"status": "calibrated", "position_rms_mm": rms} | errors.to_mapping()
