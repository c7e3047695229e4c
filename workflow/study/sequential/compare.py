"""Scanner and arm at once, or one after the other? The same data and the same start, in every order.

A *pass* fits one block with the other fixed, then the other: ``scanner`` and planes with the arm as it is, ``robot`` and planes with the
scanner as it is. One pass is the sequential calibration of practice; passes repeated are block coordinate descent, which ends at the
optimum of all at once. Near that optimum a pass shrinks what is left by ``cos^2`` of the smallest principal angle between the columns
of the two blocks, with those of the planes projected out. This rate follows from one Jacobian, and is compared with the number of passes.

All orders fix the same unobservable parameters and minimise the same objective. Left out: a sequence with scans of its own for the scanner.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from scalar.data.dataset import Dataset
from scalar.data.poses import Poses
from scalar.errors import ScalarError, Undetermined
from scalar.estimation.initial_estimate import COARSE
from scalar.estimation.joint_fit import fit_from
from scalar.estimation.least_squares import covariance_and_step, fit
from scalar.estimation.model import Model
from scalar.estimation.prepare import Prepared, prepare
from scalar.estimation.residuals import Residuals
from scalar.evaluate import aligned_to, pose_errors, true_frames
from scalar.geometry.se3 import Array
from scalar.sensors import as_scans
from scalar.sensors.linear_guess import linear_guess
from scalar.units import MM
from study.common.grid import with_overrides
from study.common.memory import dataset_in_memory
from study.common.methods import CONVERGED, INITIAL

AT_ONCE = "at_once"
ORDERS: dict[str, tuple[str, tuple[str, str]]] = {
    "scanner_first": ("declared", ("scanner", "robot")),
    "robot_first": ("declared", ("robot", "scanner")),
    "robot_first_linear": ("linear guess", ("robot", "scanner")),
}
"""{way: (where the scanner starts, order of the blocks)}."""

CONVERGED_WITHIN = (
    0.1  # standard errors: alternating ends when the joint optimum is no farther away than this
)
MAX_PASSES = 100
REWEIGHTED_PASSES = (
    6  # the weights are computed anew in the first passes only; then they stay, so that the passes converge
)
POSES = 1000  # the first of the evaluation poses: the standard error of their mean is some 2 %
DIGITS = 6  # significant digits in the table; further ones depend on rounding in the last step of a fit
SEQUENTIAL_COLUMNS = {
    "case": "row of the grid",
    "poses": "in the data",
    "noise_mm": "of a point",
    "length_error_mm": "standard deviation of the initial model's lengths",
    "angle_error_deg": "the same for its angles",
    "seed": "of all random draws in the scene",
    "way": "initial, at_once, scanner_first, robot_first, or robot_first_linear (the scanner starts at the linear guess)",
    "passes": "done so far; 0 for initial and at_once",
    "last": "whether this is where the way ends",
    "status": "converged, or stopped (passes run out), or how it failed; one_pass where only one was asked for",
    "alignment": "raw: poses as predicted; aligned: after the best rigid motion of the base",
    "position_mean_mm": f"over the first {POSES} evaluation poses (equation 18)",
    "position_max_mm": "the largest of them",
    "orientation_mean_deg": "mean angle of the error rotation over the same poses",
    "orientation_max_deg": "the largest of them",
    "residual_rms_mm": "distance of points and planes",
    "remaining_std": "length of the Gauss-Newton step that is left to the joint optimum, in standard errors",
    "rate": "share of the error that a pass leaves near the joint optimum, from the Jacobian there; of at_once only",
}


@dataclass(frozen=True, eq=False)
class Blocks:
    """Which coordinates each step frees.

    Attributes:
        everything, scanner, robot: ``(P,)`` bool; planes belong to all three.
        planes: ``(P,)`` bool.
    """

    everything: Array
    scanner: Array
    robot: Array
    planes: Array

    @classmethod
    def of(cls, prepared: Prepared) -> Blocks:
        """Return the blocks of the free coordinates of a prepared dataset."""
        model, free = prepared.initial.model, prepared.free

        def only(name: str) -> Array:
            mask = np.zeros_like(free)
            mask[model.blocks[name]] = True
            return mask & free

        planes = only("target")
        return cls(free, only("sensor") | planes, only("geometry") | planes, planes)


def compare_sequential(
    scene: str | Path, cases: Mapping[str, Mapping[str, Any]], seeds: Sequence[int], alternate: Sequence[str]
) -> pd.DataFrame:
    """Return the errors of every way after every pass: a row for each case, seed, way, pass and alignment.

    Args:
        scene: Config file of the scene.
        cases: ``{name: {dotted key: value}}``, of one workcell; all share the seed's postures, the first of them where they ask for fewer.
        seeds: To run.
        alternate: Cases in which passes are repeated until they converge; in the others there is one.

    Raises:
        InvalidInput: The scene is at fault.
        SimulationError: Too few postures see a target plane, or a scan leaves its target plane.
    """
    # Imported here: the simulator needs pybullet, an optional dependency.
    from scalar.simulation.config import complete_config, load_config, poses_wanted
    from scalar.simulation.plan import plan_poses
    from scalar.simulation.scene import simulate

    scene = Path(scene)
    base = load_config(scene)
    configs = {name: with_overrides(base, overrides) for name, overrides in cases.items()}
    complete = {name: complete_config(config, base_dir=scene.parent) for name, config in configs.items()}
    most = max(count for config in complete.values() for count in poses_wanted(config))
    rows: list[dict[str, Any]] = []
    truth_poses: pd.DataFrame | None = None
    for seed in seeds:
        plan = plan_poses(base | {"seed": seed, "poses_per_plane": most}, base_dir=scene.parent)
        for name, config in configs.items():
            simulated = simulate(config | {"seed": seed}, base_dir=scene.parent, plan=plan)
            if (
                truth_poses is None or "true_robot_errors" in base
            ):  # otherwise every seed has the same true arm
                truth_poses = simulated.truth_poses.head(POSES)
            dataset = dataset_in_memory(simulated)
            key = {
                "case": name,
                "poses": dataset.n_poses,
                "noise_mm": (dataset.sensor.noise or 0.0) / MM,
                "length_error_mm": complete[name].get("initial_model", {}).get("length_std_m", 0.0) / MM,
                "angle_error_deg": complete[name].get("initial_model", {}).get("angle_std_deg", 0.0),
                "seed": seed,
            }
            found = compare_ways(dataset, truth_poses, name in alternate)
            rows += [key | row for row in found]
        print(f"seed {seed}: {', '.join(configs)}", flush=True)
    return pd.DataFrame(rows).reindex(columns=list(SEQUENTIAL_COLUMNS))


def compare_ways(dataset: Dataset, truth_poses: pd.DataFrame, alternate: bool) -> list[dict[str, Any]]:
    """Return the rows of one dataset, ``way`` to ``rate`` of ``SEQUENTIAL_COLUMNS``.

    Args:
        dataset: Line scans of planes, the scanner's declared pose stated.
        truth_poses: As in ``truth_poses.csv``.
        alternate: Whether passes are repeated until they converge.
    """
    at = Poses.from_frame(truth_poses, dataset.robot.n_joints, order_is_row=False)
    T_true = true_frames(truth_poses)

    def rows(key: dict[str, Any], model: Model) -> list[dict[str, Any]]:
        T_hat = model.robot.flange(at.q) @ model.T_flange_sensor
        both = (("raw", T_hat), ("aligned", aligned_to(T_true, T_hat)))
        return [key | {"alignment": name} | pose_errors(T_true, T).to_mapping() for name, T in both]

    try:
        prepared = prepare(dataset)
        optimum, residuals = fit_from(dataset, prepared.initial.model, prepared.free)
        first = starts(dataset, prepared)
    except ScalarError as error:
        failed = {"passes": 0, "last": True, "status": type(error).__name__}
        return [failed | {"way": w, "alignment": a} for w in (AT_ONCE, *ORDERS) for a in ("raw", "aligned")]
    blocks = Blocks.of(prepared)
    found = rows({"way": INITIAL, "passes": 0, "last": True, "status": INITIAL}, first["declared"])
    found += rows(
        {
            "way": AT_ONCE,
            "passes": 0,
            "last": True,
            "status": CONVERGED,
            "residual_rms_mm": residuals.rms(optimum.model) / MM,
            "remaining_std": remaining(residuals, optimum.model, blocks.everything),
            "rate": contraction(residuals, optimum.model, blocks),
        },
        optimum.model,
    )
    for way, (start, order) in ORDERS.items():
        steps = [getattr(blocks, name) for name in order]
        for done, model, reached in passes(Residuals.of(dataset, first[start]), first[start], steps):
            left = remaining(reached, model, blocks.everything)
            converged = left < CONVERGED_WITHIN
            last = converged or not alternate or done == MAX_PASSES
            status = CONVERGED if converged else "stopped" if alternate else "one_pass"
            key = {"way": way, "passes": done, "last": last, "status": status if last else ""}
            found += rows(key | {"residual_rms_mm": reached.rms(model) / MM, "remaining_std": left}, model)
            if last:
                break
    return found


def starts(dataset: Dataset, prepared: Prepared) -> dict[str, Model]:
    """Return the nominal arm and the initial guesses of the planes with the scanner as declared, and at the linear guess of the most level plane.

    Raises:
        Undetermined: No pose is declared, or the plane's scans determine no guess.
    """
    measurement = prepared.residuals.measurement
    planes = measurement.initial_target(dataset)
    declared = dataset.sensor.T_flange_sensor
    if declared is None:
        raise Undetermined(["no pose of the scanner is stated to start from"])
    level = int(np.argmax(np.abs(planes.normals @ dataset.robot.gravity)))
    guess = linear_guess(
        as_scans(measurement), dataset.robot.flange(dataset.q), planes, measurement.target_index == level
    )
    coarse = prepared.coarse
    return {
        name: replace(
            Model.at(dataset.robot, T, planes), priors=coarse.priors, misfit_ratio=coarse.misfit_ratio
        )
        for name, T in (("declared", declared), ("linear guess", guess))
    }


def passes(
    residuals: Residuals, model: Model, steps: Sequence[Array]
) -> Iterator[tuple[int, Model, Residuals]]:
    """Yield (passes done, model, residuals) after every pass, without end.

    Args:
        residuals: Of the dataset.
        model: Where to start.
        steps: ``(P,)`` bool each, what is free in turn.
    """
    done = 0
    while True:
        if done < REWEIGHTED_PASSES:
            model = model.rebased()
            residuals = residuals.reweighted(model)
        for free in steps:
            model = fit(residuals, model, free, tolerance=COARSE).model
        done += 1
        yield done, model, residuals


def remaining(residuals: Residuals, model: Model, free: Array) -> float:
    """Return how many standard errors the joint optimum is away, to first order."""
    residual, J = residuals.linearise(model)
    return covariance_and_step(J[:, free], residual)[1]


def contraction(residuals: Residuals, model: Model, blocks: Blocks) -> float:
    """Return the share of the error that a pass leaves near an optimum: ``cos^2`` of the smallest angle between the blocks.

    Minimising a quadratic over overlapping blocks by turns is alternating projection onto the complements of their columns; with the
    shared columns projected out its rate is the squared largest canonical correlation (Deutsch, Best Approximation in Inner Product
    Spaces, chapter 9).
    """
    J = residuals.linearise(model)[1]
    shared = np.linalg.qr(J[:, blocks.planes])[0]

    def basis(free: Array) -> Array:
        own = J[:, free & ~blocks.planes]
        own = own / np.linalg.norm(own, axis=0)
        return np.linalg.qr(own - shared @ (shared.T @ own))[0]

    cosines = np.linalg.svd(basis(blocks.scanner).T @ basis(blocks.robot), compute_uv=False)
    return float(cosines[0] ** 2)
