"""Compare the calibration of scanner and arm at once with calibrations of one after the other, from the same data and the same start.

A *pass* fits two blocks in turn, each with the other fixed: the scanner and the planes (``scanner``), and the arm and the planes (``robot``).
One pass is the sequential calibration of practice. Repeated passes are block coordinate descent, which ends at the optimum of all parameters.
Near that optimum, a pass multiplies the remaining error by ``cos^2`` of the smallest principal angle between the columns
of the two blocks, with those of the planes projected out. This rate follows from one Jacobian, and is compared with the number of passes.

All orders fix the same unobservable parameters and minimise the same objective. A sequence with separate scans for the scanner is not examined.
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
from scalar.estimation.sufficiency import check_determined
from scalar.evaluate import aligned_to, pose_errors, true_frames
from scalar.geometry.se3 import Array
from scalar.sensors import as_scans
from scalar.sensors.linear_guess import linear_guess
from scalar.units import MM
from study.common.grid import with_overrides
from study.common.in_memory import dataset_in_memory
from study.common.methods import CONVERGED, INITIAL

AT_ONCE = "at_once"
ORDERS: dict[str, tuple[str, tuple[str, str]]] = {
    "scanner_first": ("declared", ("scanner", "robot")),
    "robot_first": ("declared", ("robot", "scanner")),
    "robot_first_linear": ("linear guess", ("robot", "scanner")),
}
"""``{way: (initial guess of the scanner's pose, order of the blocks)}``."""

CONVERGED_WITHIN = 0.1  # standard errors: passes end when the joint optimum is no farther away than this
MAX_PASSES = 100
REWEIGHTED_PASSES = 6  # number of first passes in which weights are computed anew; they are then kept, so that the passes converge
POSES = 1000  # the first of the evaluation poses: the standard error of their mean is some 2 %
DIGITS = 6  # significant digits in the table; further ones depend on rounding in the last step of a fit
SEQUENTIAL_COLUMNS = {
    "case": "row of the grid",
    "poses": "number of poses",
    "noise_mm": "stated noise of a point",
    "length_error_mm": "standard deviation of the initial model's lengths",
    "angle_error_deg": "the same for its angles",
    "seed": "seed of all random draws in the scene",
    "way": "initial, at_once, scanner_first, robot_first, or robot_first_linear (the scanner starts at the linear guess)",
    "passes": "number of passes so far; 0 for initial and at_once",
    "last": "whether this is the last pass",
    "status": f"converged; stopped (after {MAX_PASSES} passes); the class of the error of a failure; or one_pass if only one was asked for",
    "alignment": "raw: poses as predicted; aligned: after the best rigid motion of the base",
    "position_mean_mm": f"mean position error over the first {POSES} evaluation poses (equation 18 of the original paper)",
    "position_max_mm": "the largest of them",
    "orientation_mean_deg": "mean angle of the error rotation over the same poses",
    "orientation_max_deg": "the largest of them",
    "residual_rms_mm": "RMS distance of the points from their planes",
    "remaining_std": "length of the Gauss-Newton step to the joint optimum, in standard errors",
    "rate": "share of the error that a pass leaves near the joint optimum, from the Jacobian there; stated for at_once only",
}


@dataclass(frozen=True, eq=False)
class Blocks:
    """Which of the P coordinates are free in each fit, ``(P,)`` bool each.

    Attributes:
        everything: All coordinates that the data determine.
        scanner: Those of the scanner and the planes.
        robot: Those of the arm and the planes.
        planes: Those of the planes.
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
        cases: ``{name: {dotted key: value}}``, cases with the same workcell; with the same seed they share their postures, and a case with fewer
            poses uses the first of them.
        seeds: Seeds of the scenes.
        alternate: Names of the cases in which passes are repeated until they converge; in the others there is one pass.

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
            # Without errors of the true arm that are drawn, every seed has the same true arm.
            if truth_poses is None or "true_robot_errors" in base:
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
        dataset: Line scans of planes, with a declared pose of the scanner.
        truth_poses: Content of ``truth_poses.csv``.
        alternate: Whether passes are repeated until they converge.
    """
    at = Poses.from_frame(truth_poses, dataset.robot.slides, order_is_row=False)
    T_true = true_frames(truth_poses)

    def rows(key: dict[str, Any], model: Model) -> list[dict[str, Any]]:
        T_hat = model.robot.flange(at.q) @ model.T_flange_sensor
        both = (("raw", T_hat), ("aligned", aligned_to(T_true, T_hat)))
        return [key | {"alignment": name} | pose_errors(T_true, T).to_mapping() for name, T in both]

    try:
        prepared = prepare(dataset)
        check_determined(prepared.identifiability)
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
    """Return ``{initial guess of the scanner: model}``: the nominal arm and the initial guesses of the planes, with two guesses of the scanner.

    ``declared`` is the declared pose, ``linear guess`` the linear estimate from the scans of the most level plane.

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
    """Yield (number of passes, model, residuals) after every pass; the iterator does not end.

    Args:
        residuals: The residuals of the dataset.
        model: The model to start from.
        steps: For each step of a pass ``(P,)`` bool, which coordinates are free.
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
    """Return how many standard errors a model is away from the joint optimum, to first order.

    Args:
        residuals: The residuals of the joint fit.
        model: The model.
        free: ``(C,)`` bool, which of the model's C coordinates are estimated.
    """
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
