"""Compare the diagnosis with learned compensation on measured arms: ``python -m benchmarks.diagnosis.measured SET... --summary FILE.json``.

The poses of each set are dealt to ``BLOCKS`` blocks of successive ones, a repetition of a pose with its first time. Every second block is learned
from, and the other blocks have no part in cleaning, selection or fit: neither for the diagnosis, a quick one, which ships what it
ships, nor for the learners, which are added to its calibration without effects (``learners``). Then the halves change their roles. Errors
are root mean squares of distances at unseen poses; gross errors, which the cleaning of all poses sets aside, are not counted. They are given for
all unseen poses, and for those within the ranges of the joints that were learned from (``*_within_mm``), beside the expected error within the joint
limits that the diagnosis states.
The summary holds no measured data.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).parents[2]
sys.path[:0] = [str(ROOT / "workflow")]

from study.common.provenance import code_version  # noqa: E402

from benchmarks.diagnosis.learners import Network, Process  # noqa: E402
from scalar.data.dataset import Dataset, read_dataset  # noqa: E402
from scalar.data.io.atomic import write_json  # noqa: E402
from scalar.diagnosis.diagnose import diagnose  # noqa: E402
from scalar.diagnosis.held_out.hold_out import first_of_repetitions  # noqa: E402
from scalar.diagnosis.shipping.nested_models import LIMITS  # noqa: E402
from scalar.estimation.gross_errors import clean  # noqa: E402
from scalar.estimation.model import Model  # noqa: E402
from scalar.estimation.residuals import Residuals  # noqa: E402
from scalar.geometry.planes import Planes  # noqa: E402
from scalar.geometry.se3 import Array  # noqa: E402
from scalar.units import MM  # noqa: E402

BLOCKS = 20
SEED = 1_409_717_223
"""Of the networks' starts, drawn once."""


def halves(q: Array) -> tuple[Array, Array]:
    """Return the block ``(N,)`` of every pose and which poses ``(N,)`` are of the first half, the even blocks.

    Args:
        q: ``(N, n)`` [rad], in the order of acquisition; a repetition belongs to the block of the pose that it repeats.
    """
    first = first_of_repetitions(q)
    new = first == np.arange(len(q))
    block = ((np.cumsum(new) - 1) * BLOCKS // int(new.sum()))[first]
    return block, block % 2 == 0


def rows(dataset: Dataset, model: Model) -> tuple[Array, Array]:
    """Return the residual ``(N, m)`` [m] of each pose and its directions ``(N, m, 3)``, those of the tracker's frame or of the planes."""
    residuals = Residuals.of(dataset, model)
    measurement, metres = residuals.measurement.in_metres()
    in_metres = Residuals(measurement, residuals.poses, residuals.bases, residuals.known)
    residual = in_metres.residual(model)[: len(dataset.q) * measurement.rows_per_pose] * metres
    residual = residual.reshape(len(dataset.q), -1)
    target: Any = model.target
    if isinstance(target, Planes):
        return residual, target.normals[residuals.measurement.target_index.astype(np.intp)][:, None]
    return residual, np.broadcast_to(np.eye(3), (len(residual), 3, 3))


def compare(dataset: Dataset) -> list[dict[str, Any]]:
    """Return a row for each half: numbers of poses, RMS errors [mm] at the unseen poses of each method, and what the diagnosis states.

    Raises:
        InvalidInput: The data contradict themselves.
        Undetermined: A half does not determine the geometry.
    """
    block, first = halves(dataset.q)
    sound = np.isin(dataset.poses["pose"].to_numpy(), clean(dataset).dataset.poses["pose"].to_numpy())
    found = []
    for learned in (first, ~first):
        train, test = dataset.subset(learned), dataset.subset(~learned & sound)
        diagnosis = diagnose(train)
        geometry, shipped = diagnosis.calibration_before.model, diagnosis.calibration_after.model
        kept = np.isin(train.poses["pose"].to_numpy(), diagnosis.before.dataset.poses["pose"].to_numpy())
        cleaned = diagnosis.before.dataset
        residual, directions = rows(cleaned, geometry)
        unseen, along = rows(test, geometry)
        learners = {
            "gaussian_process": Process(cleaned.q, directions, residual),
            "network": Network(
                cleaned.q, directions, residual, block[learned][kept] // 2, np.random.default_rng(SEED)
            ),
        }
        unseen_errors = {
            "geometry": unseen,
            "diagnosis": rows(test, shipped)[0],
            **{name: unseen - one.predicted(test.q, along) for name, one in learners.items()},
        }
        within = np.all((test.q >= cleaned.q.min(axis=0)) & (test.q <= cleaned.q.max(axis=0)), axis=1)
        choice = diagnosis.shipped.choice
        stated = choice.errors_as_chosen[LIMITS] if diagnosis.ships_effects else choice.std_without
        found.append(
            {
                "learned_from": int(learned.sum()),
                "unseen": test.n_poses,
                "within_share": float(within.mean()),
                "verdict": diagnosis.verdict,
                "stated_mm": stated / MM or None,
            }
            | {f"{name}_mm": _rms(errors) for name, errors in unseen_errors.items()}
            | {f"{name}_within_mm": _rms(errors[within]) for name, errors in unseen_errors.items()}
        )
    return found


def _rms(residual: Array) -> float:
    """Return the root mean square distance [mm] of residuals ``(N, m)`` [m]."""
    return float(np.sqrt(np.mean(np.sum(residual**2, axis=1)))) / MM


def main() -> None:
    """Compare on each set, and print and write the errors."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "sets", nargs="+", type=Path, help="dataset folders; their names name them in the summary"
    )
    parser.add_argument("--summary", type=Path, default=None, help="where the errors are written as JSON")
    options = parser.parse_args()
    found: dict[str, Any] = {"code": code_version(), "blocks": BLOCKS, "sets": {}}
    for folder in options.sets:
        found["sets"][folder.name] = {"halves": compare(read_dataset(folder))}
        print(folder.name, found["sets"][folder.name], flush=True)
        if options.summary is not None:
            write_json(options.summary, found)


if __name__ == "__main__":
    main()
