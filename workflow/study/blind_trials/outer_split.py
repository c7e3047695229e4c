"""What the outer split adds to the diagnosis of stratified trials: rates with and without it, the errors it states, and the names it refuses.

Each set is diagnosed twice, without and with the split. Twice as many poses are simulated as are measured: the error that the split states for unseen
poses is compared with the true one at the other half, in the same unit, the distance of scanned points from their planes. Stray
points are left out there, as the diagnosis leaves out those of its own poses.
"""

from __future__ import annotations

import json
from dataclasses import replace
from time import process_time
from typing import TYPE_CHECKING, Any

import numpy as np

from scalar.errors import ScalarError
from scalar.estimation.gross_errors import without_stray_points
from scalar.estimation.residuals import Residuals
from scalar.geometry.se3 import Array
from scalar.units import MM
from study.blind_trials.run import answered
from study.common.in_memory import dataset_in_memory

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset
    from scalar.diagnosis import Diagnosis
    from scalar.simulation.scene import SimulatedScene

SPLIT_COLUMNS = {
    "found_split": "JSON, as found, of the diagnosis with the outer split",
    "not_confirmed": "JSON, entries of the same diagnosis that too few of its runs chose",
    "status_split": "as status",
    "position_after_split_mm": "as position_after_mm",
    "unseen_stated_mm": "RMS error at unseen poses that this diagnosis states for what it ships",
    "unseen_true_mm": "RMS error of the same calibration at the other half of the poses",
    "held_out_stated_mm": "RMS error at held-out poses that the diagnosis without the split states for what it ships",
    "held_out_true_mm": "RMS error of the calibration of that diagnosis at the other half of the poses",
    "diagnose_split_s": "processor time of the diagnosis with the split",
}


def seen_poses(simulated: SimulatedScene, seed: int) -> Array:
    """Return which poses of a scene are measured, ``(N,)`` bool: a random half of those of each plane."""
    planes = simulated.poses["plane"].to_numpy()
    rng, seen = np.random.default_rng([seed, 2]), np.zeros(len(planes), dtype=bool)
    for plane in sorted(set(planes)):
        mine = np.flatnonzero(planes == plane)
        seen[rng.permutation(mine)[: len(mine) // 2]] = True
    return seen


def all_poses(simulated: SimulatedScene) -> Dataset:
    """Return all poses of a scene with their order of acquisition as a column, so that both halves know when each pose was measured."""
    dataset = dataset_in_memory(simulated)
    return replace(dataset, poses=dataset.poses.assign(order=np.arange(dataset.n_poses, dtype=float)))


def quick_errors(diagnosis: Diagnosis, simulated: SimulatedScene, unseen: Array) -> dict[str, float | None]:
    """Return the error that a diagnosis without the split states for held-out poses, and the true one at unseen poses; arguments as below."""
    rest = all_poses(simulated).subset(unseen)
    stated = diagnosis.errors_after["held_out_rms_mm"]
    return {"held_out_stated_mm": stated, "held_out_true_mm": true_error(diagnosis, rest)}


def split_answer(dataset: Dataset, simulated: SimulatedScene, unseen: Array, parts: int) -> dict[str, Any]:
    """Diagnose a dataset with the outer split; return the entries ``SPLIT_COLUMNS`` of its row but for those of the diagnosis without.

    Args:
        dataset: The measured poses.
        simulated: The scene with all poses.
        unseen: ``(N,)`` bool, which of them are not in ``dataset``.
        parts: Number of parts.
    """
    rest = all_poses(simulated).subset(unseen)

    def more(diagnosis: Diagnosis) -> dict[str, Any]:
        mapping = diagnosis.to_mapping()
        return {
            "not_confirmed": json.dumps(
                [{k: v for k, v in e.items() if k != "coefficients"} for e in mapping["not_confirmed"]]
            ),
            "unseen_stated_mm": mapping["residual"]["after"]["unseen_rms_mm"],
            "unseen_true_mm": true_error(diagnosis, rest),
        }

    start = process_time()
    answer = answered(dataset, [], simulated.truth_poses, parts, more)
    entries = {
        "found": "found_split",
        "status": "status_split",
        "position_after_mm": "position_after_split_mm",
    }
    renamed = {new: answer.get(old) for old, new in entries.items()}
    kept = {key: answer.get(key) for key in ("not_confirmed", "unseen_stated_mm", "unseen_true_mm")}
    kept = {"not_confirmed": "[]"} | {key: value for key, value in kept.items() if value is not None}
    return (
        renamed
        | kept
        | {"found_split": answer.get("found", "[]"), "diagnose_split_s": process_time() - start}
    )


def true_error(diagnosis: Diagnosis, rest: Dataset) -> float | None:
    """Return the root mean square distance [mm] of points of unseen poses from what the shipped calibration predicts; None if it predicts none.

    Args:
        diagnosis: Of the measured poses.
        rest: The unseen poses.
    """
    model = diagnosis.calibration_after.model
    try:
        kept, _, corrupted = without_stray_points(rest)
        squares, n = Residuals.of(kept.subset(~corrupted), model).squared_distances(model)
    except ScalarError:
        return None
    return float(np.sqrt(squares.sum() / n.sum())) / MM
