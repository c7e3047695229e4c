"""Compare with what the authors of measured data published: ``python -m benchmarks.diagnosis.published SETS --summary FILE.json``.

``SETS`` is a folder of imported datasets. Each comparison repeats the split of the authors: the diagnosis, a quick one, sees the poses from which
they learned, and both are judged by the distance between predicted and measured position, by its mean, standard deviation and maximum, on the same
poses. No pose is left out of the judgement; gross errors count.

The Motomans: learned from a grid of joints 2 and 3, judged at poses all over the workspace. The iiwa: learned from the first four fifths of the
poses. The authors publish their errors on these same poses, the parameters that they identified, and no errors for the last fifth; those follow from
their parameters, given as ``--parameters SET=outputs.mat``, once the published errors have been found again with them.
The summary holds no measured data.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.io import loadmat
from scipy.spatial.transform import Rotation

ROOT = Path(__file__).parents[2]
sys.path[:0] = [str(ROOT / "workflow")]

from study.common.provenance import code_version  # noqa: E402
from study.common.tables import read_table  # noqa: E402

from benchmarks.diagnosis.measured import rows  # noqa: E402
from scalar.data.dataset import Dataset, read_dataset  # noqa: E402
from scalar.data.io.atomic import write_json  # noqa: E402
from scalar.diagnosis.diagnose import diagnose  # noqa: E402
from scalar.geometry.se3 import Array  # noqa: E402
from scalar.units import MM  # noqa: E402

PUBLISHED = ROOT / "workflow/resources/published_measured.csv"
LEARNED_SHARE = 0.8
"""Share of the poses of an iiwa from which its authors learned: the first ones."""
LEFT_OUT = {"iiwa7_tracker": 20, "iiwa7_no_load": 1}
"""Poses at the beginning of a campaign of the iiwa that its authors left out."""
SAME_MM = 1e-3
"""Greatest difference between a published error [mm] and the same error found again."""

LENGTHS = (0.34, 0.0, 0.4, 0.0, 0.4, 0.0, 0.126)
TWISTS = (-0.5, 0.5, -0.5, 0.5, -0.5, 0.5, 0.0)
ZEROS = (0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0)
"""The authors' table of the iiwa: d [m], and alpha and the zeros of theta [pi]; all a are zero."""


@dataclass(frozen=True)
class Split:
    """The poses from which was learned, and by what name and at which poses each method is judged."""

    learned: Dataset
    judged: Mapping[str, Dataset]


def split(folder: Path, name: str) -> Split:
    """Return the authors' split of a set.

    Args:
        folder: Folder of the imported datasets.
        name: The set in the table of published values: a campaign of the iiwa, or the ``*_poses`` of a Motoman, whose ``*_grid`` was learned from.
    """
    whole = read_dataset(folder / name)
    if name.endswith("_poses"):
        return Split(read_dataset(folder / name.replace("_poses", "_grid")), {"unseen": whole})
    learned, rest = first_poses(whole.n_poses, LEFT_OUT.get(name, 0))
    return Split(whole.subset(learned), {"fit": whole.subset(learned), "unseen": whole.subset(rest)})


def first_poses(poses: int, left_out: int) -> tuple[Array, Array]:
    """Return which poses ``(N,)`` are learned from, the first ``LEARNED_SHARE`` of those that are not left out, and which are the rest."""
    place = np.arange(poses) - left_out
    learned = place < round(LEARNED_SHARE * (poses - left_out))
    return learned & (place >= 0), ~learned


def summary(distance: Array) -> dict[str, float]:
    """Return the mean, the standard deviation and the maximum [mm] of distances ``(N,)`` [m]."""
    return {
        "mean_mm": float(distance.mean()) / MM,
        "std_mm": float(distance.std(ddof=1)) / MM,
        "max_mm": float(distance.max()) / MM,
    }


def iiwa_positions(q: Array, torque: Array, parameters: Array) -> Array:
    """Return the positions ``(N, 3)`` [m] that the authors' model of the iiwa predicts.

    ``T = T_2 prod_j Rot_z(q_j + zero_j + x_j + c_j tau_j) Trans_z(d_j + dd_j) Rot_x(alpha_j + da_j) T_1``: standard DH without a, with a compliance
    ``c_j`` of each joint by its measured torque, between two fixed frames.

    Args:
        q: ``(N, 7)`` [rad], angles of the joints.
        torque: ``(N, 7)`` [N m], torques of the joints.
        parameters: ``(40,)``: ``x, dd, da, c``, seven each; the angles about x, y and z of ``T_1`` and of ``T_2``; their translations [m].
    """
    zeros, lengths, twists, compliances = parameters[:28].reshape(4, 7)
    angles, shifts = parameters[28:34].reshape(2, 3), parameters[34:].reshape(2, 3)
    turn = Rotation.from_euler("XYZ", angles[1])
    position = np.broadcast_to(shifts[1], (len(q), 3))
    for j in range(7):
        turn = turn * Rotation.from_rotvec(
            (q[:, [j]] + np.pi * ZEROS[j] + zeros[j] + compliances[j] * torque[:, [j]]) * [0.0, 0.0, 1.0]
        )
        position = position + turn.apply([0.0, 0.0, LENGTHS[j] + lengths[j]])
        turn = turn * Rotation.from_rotvec([np.pi * TWISTS[j] + twists[j], 0.0, 0.0])
    return position + turn.apply(shifts[0])


def iiwa_errors(dataset: Dataset, parameters: Array) -> Array:
    """Return the distances ``(N,)`` [m] between measured positions and those of the authors' model."""
    torque = dataset.poses[[f"tau{j}" for j in range(1, 8)]].to_numpy()
    return np.linalg.norm(dataset.points - iiwa_positions(dataset.q, torque, parameters), axis=1)


def compare(wanted: Split, theirs: Array | None, stated: Mapping[str, float]) -> dict[str, Any]:
    """Return the errors of the diagnosis on each part of the split, without and with its correction, and those of the authors' parameters.

    Args:
        wanted: The split.
        theirs: ``(40,)``, the authors' parameters of an iiwa; None for another arm.
        stated: ``mean_mm`` and ``max_mm`` that they published on the poses of the fit, for a check of the parameters.

    Raises:
        ValueError: The parameters do not give the errors that were published.
    """
    diagnosis = diagnose(wanted.learned)
    models = {
        "geometry": diagnosis.calibration_before.model,
        "diagnosis": diagnosis.calibration_after.model,
    }
    found: dict[str, Any] = {
        "learned_from": wanted.learned.n_poses,
        "verdict": diagnosis.verdict,
        "ships_effects": diagnosis.ships_effects,
    }
    for part, dataset in wanted.judged.items():
        errors = {name: np.linalg.norm(rows(dataset, model)[0], axis=1) for name, model in models.items()}
        if theirs is not None:
            errors["theirs"] = iiwa_errors(dataset, theirs)
        found[part] = {"poses": dataset.n_poses} | {
            name: summary(distances) for name, distances in errors.items()
        }
    if theirs is not None and any(
        abs(found["fit"]["theirs"][key] - value) > SAME_MM for key, value in stated.items()
    ):
        raise ValueError(f"the parameters give {found['fit']['theirs']}, but {dict(stated)} was published")
    return found


def main() -> None:
    """Compare on each set of the table that is in the folder, and print and write the errors."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("sets", type=Path, help="folder of the imported datasets, by their names")
    parser.add_argument(
        "--parameters",
        action="append",
        default=[],
        metavar="SET=FILE",
        help="the parameters that the authors of an iiwa's data identified",
    )
    parser.add_argument("--summary", type=Path, default=None, help="where the errors are written as JSON")
    options = parser.parse_args()
    files = dict(text.split("=", 1) for text in options.parameters)
    published = read_table(PUBLISHED)
    found: dict[str, Any] = {"code": code_version(), "sets": {}}
    for name, table in published.groupby("set", sort=False):
        if not (options.sets / str(name)).exists():
            continue
        last = table.iloc[-1]
        stated = {f"{key}_mm": float(last[f"position_{key}_mm"]) for key in ("mean", "max")}
        theirs = loadmat(files[name])["x"].ravel() if name in files else None
        found["sets"][name] = compare(split(options.sets, str(name)), theirs, stated)
        print(name, found["sets"][name], flush=True)
        if options.summary is not None:
            write_json(options.summary, found)


if __name__ == "__main__":
    main()
