"""Compare the diagnosis with learned compensation on measured arms: ``python -m benchmarks.diagnosis.measured SET... --summary FILE.json``.

The poses of each set are dealt to ``BLOCKS`` blocks of successive ones, a repetition of a pose with its first time. Every second block is learned
from, and the other blocks have no part in cleaning, selection or fit: neither for the diagnosis, a quick one, which ships what it
ships, nor for the learners, which are added to its calibration without effects (``learners``). Then the halves change their roles. Errors
are root mean squares of distances at unseen poses; gross errors, which the cleaning of all poses sets aside, are not counted. Several targets on
one flange are learned one by one, since each shows an error of its own, and each counts as a point. Errors are given for all unseen
poses, and for those within the ranges of the joints that were learned from (``*_within_mm``), beside the expected error within the joint limits that
the diagnosis states.
The summary holds no measured data.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
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
from scalar.diagnosis.held_out.repetitions import first_of_repetitions  # noqa: E402
from scalar.diagnosis.shipping.nested_models import LIMITS  # noqa: E402
from scalar.errors import Fault, InvalidInput, ScalarError  # noqa: E402
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
    """Return the residual ``(N, m)`` [m] of each pose and its directions ``(N, m, 3)``, those of the tracker's frame or of the planes.

    A tracker that sees t targets at each pose has m = 3 t, target by target.
    """
    residuals = Residuals.of(dataset, model)
    measurement, metres = residuals.measurement.in_metres()
    in_metres = Residuals(measurement, residuals.poses, residuals.bases, residuals.known)
    residual = in_metres.residual(model)[: len(dataset.q) * measurement.rows_per_pose] * metres
    residual = residual.reshape(len(dataset.q), -1)
    target: Any = model.target
    if isinstance(target, Planes):
        return residual, target.normals[residuals.measurement.target_index.astype(np.intp)][:, None]
    frame = np.tile(np.eye(3), (residual.shape[1] // 3, 1))
    return residual, np.broadcast_to(frame, (len(residual), *frame.shape))


def targets(directions: Array) -> list[slice]:
    """Return the columns of each target: three of a tracked point, or the one along the normal of a plane; ``directions`` is ``(N, m, 3)``."""
    m = directions.shape[1]
    return [slice(k, min(k + 3, m)) for k in range(0, m, 3)]


def left_by(
    learn: Callable[[Array, Array], Any],
    learned: tuple[Array, Array],
    unseen: tuple[Array, Array],
    q: Array,
) -> Array:
    """Return what a learner leaves ``(P, m)`` [m] of the residual at unseen poses; it learns the error of each target by itself.

    Args:
        learn: Fits a learner to directions ``(N, c, 3)`` and residuals ``(N, c)`` [m] of one target.
        learned: Residuals ``(N, m)`` [m] and directions ``(N, m, 3)`` to learn from. unseen: The same of the P unseen poses.
        q: ``(P, n)``, the joint values of the unseen poses [rad, m].
    """
    residual, directions = learned
    left, along = unseen
    predicted = [
        learn(directions[:, columns], residual[:, columns]).predicted(q, along[:, columns])
        for columns in targets(directions)
    ]
    return left - np.concatenate(predicted, axis=1)


def compare(dataset: Dataset) -> list[dict[str, Any]]:
    """Return a row for each half: numbers of poses, RMS errors [mm] at the unseen poses of each method, and what the diagnosis states.

    Raises:
        InvalidInput: The data contradict themselves, or have fewer poses than blocks.
        Undetermined: A half does not determine the geometry.
    """
    block, first = halves(dataset.q)
    if len(np.unique(block)) < BLOCKS:
        message = f"{dataset.n_poses} poses are too few for {BLOCKS} blocks of poses; leave the set out"
        raise InvalidInput([Fault("poses.csv", message)])
    sound = np.isin(dataset.poses["pose"].to_numpy(), clean(dataset).dataset.poses["pose"].to_numpy())
    found = []
    for learned in (first, ~first):
        train, test = dataset.subset(learned), dataset.subset(~learned & sound)
        diagnosis = diagnose(train)
        geometry, shipped = diagnosis.calibration_before.model, diagnosis.calibration_after.model
        kept = np.isin(train.poses["pose"].to_numpy(), diagnosis.before.dataset.poses["pose"].to_numpy())
        cleaned = diagnosis.before.dataset
        seen, unseen = rows(cleaned, geometry), rows(test, geometry)
        learners = _learners(cleaned.q, block[learned][kept] // 2)
        unseen_errors = {
            "geometry": unseen[0],
            "diagnosis": rows(test, shipped)[0],
            **{name: left_by(learn, seen, unseen, test.q) for name, learn in learners.items()},
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
            | {f"{name}_mm": rms(errors) for name, errors in unseen_errors.items()}
            | {f"{name}_within_mm": rms(errors[within]) for name, errors in unseen_errors.items()}
        )
    return found


def _learners(q: Array, block: Array) -> dict[str, Callable[[Array, Array], Any]]:
    """Return how each learner is fitted to the poses at joint values ``q`` ``(N, n)`` in the blocks ``block`` ``(N,)``."""
    return {
        "gaussian_process": lambda directions, residual: Process(q, directions, residual),
        "network": lambda directions, residual: Network(
            q, directions, residual, block, np.random.default_rng(SEED)
        ),
    }


def rms(residual: Array) -> float | None:
    """Return the root mean square distance [mm] of points with residuals ``(N, m)`` [m], three columns a point or one; None without any."""
    if not len(residual):
        return None
    points = len(residual) * max(1, residual.shape[1] // 3)
    return float(np.sqrt(np.sum(residual**2) / points)) / MM


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
        try:
            found["sets"][folder.name] = {"halves": compare(read_dataset(folder))}
        except ScalarError as error:
            print(f"{folder.name} is left out: {error}", file=sys.stderr, flush=True)
            continue
        print(folder.name, found["sets"][folder.name], flush=True)
        if options.summary is not None:
            write_json(options.summary, found)


if __name__ == "__main__":
    main()
