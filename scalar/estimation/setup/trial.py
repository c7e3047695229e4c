"""How well a reading of the set-up explains the data: a fit with the nominal arm, a full fit, and a robust measure of their residuals."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from scalar.data.dataset import Dataset
from scalar.errors import ScalarError
from scalar.estimation.initial_estimate import COARSE, proposals, sensor_and_target
from scalar.estimation.least_squares import fit
from scalar.estimation.model import Model
from scalar.estimation.prepare import prepare
from scalar.estimation.ran_away import ran_away
from scalar.estimation.residuals import Residuals
from scalar.geometry.planes import Planes
from scalar.geometry.robot import GEOMETRY
from scalar.geometry.se3 import Array, log_so3
from scalar.sensors import measure

MOST_POSES = 60  # used for a nominal fit; a wrong description shows in any poses
LEAST_EQUATIONS = 2.0  # for each free parameter: with fewer, a fit may explain anything
THETA = GEOMETRY.index("theta")
STEPS = 12  # damped Gauss-Newton steps of a nominal fit


@dataclass(frozen=True, eq=False)
class Trial:
    """A reading of the set-up that was fitted.

    Attributes:
        rms: Median over the poses of their root mean square distance from the target [m].
        model: Where the fit ended.
    """

    rms: float
    model: Model


@dataclass(frozen=True, eq=False)
class NominalFit:
    """A fit of sensor and target alone to a reading of the set-up, the arm being nominal.

    Attributes:
        rms: As in ``Trial``; infinite if no fit was possible.
        turn: How far sensor and planes ended from where dataset.yaml has them, as an angle [rad]: the largest of the turn of the sensor and the
            turns of the planes' normals.
        shift: The same as a length [m]: the largest of the shift of the sensor and the shifts of the planes.
        of_all: Root mean square distance over all poses [m], which a few wrong poses change much.
    """

    rms: float
    turn: float
    shift: float
    of_all: float = np.inf


def nominal_fit(dataset: Dataset) -> NominalFit:
    """Return how well a set-up explains some of the poses with the arm nominal: sensor and target alone are fitted."""
    return quick_fit(dataset)[0]


def quick_fit(dataset: Dataset, joints: Sequence[int] = ()) -> tuple[NominalFit, Model | None]:
    """Return the fit of a set-up with the arm nominal, and its model; None if no fit was possible.

    Args:
        dataset: The measurements under some reading of the set-up.
        joints: ``(k,)``, from 0: joints that turn, whose zeros are free as well.
    """
    dataset = thinned(dataset)
    best: tuple[NominalFit, Model | None] = NominalFit(np.inf, np.inf, np.inf), None
    try:
        measurement = measure(dataset)
        guess = measurement.initial_target(dataset)
        T_nominal = dataset.sensor.T_flange_sensor
        for _, T, target in proposals(measurement, dataset.robot, dataset.q, guess, T_nominal):
            model = Model.at(dataset.robot, T, target)
            model = _few_steps(Residuals.of(dataset, model, measurement), model, joints)
            distances = Residuals.of(dataset, model, measurement).pose_distances(model)
            nominal = NominalFit(
                float(np.median(distances)),
                *_turn_and_shift(model, guess, T_nominal),
                float(np.sqrt(np.mean(distances**2))),
            )
            best = min(best, (nominal, model), key=lambda x: x[0].rms)
    except (ScalarError, np.linalg.LinAlgError, ValueError, FloatingPointError):
        pass
    return best


def _few_steps(residuals: Residuals, model: Model, joints: Sequence[int]) -> Model:
    """Return the model after a few damped Gauss-Newton steps of sensor, target and the zeros of some joints (from 0)."""
    free = sensor_and_target(residuals, model)
    first = model.blocks["geometry"].start + THETA * model.robot.n_joints
    free[[first + joint for joint in joints]] = True
    residual, jacobian = residuals.linearise(model)
    damping = 1e-3
    for _ in range(STEPS):
        J = jacobian[:, free]
        scale = np.maximum(np.linalg.norm(J, axis=0), 1e-300)
        A = J / scale
        step = np.linalg.solve(A.T @ A + damping * np.eye(len(scale)), -A.T @ residual) / scale
        vector = model.vector.copy()
        vector[free] += step
        trial = model.with_vector(vector).rebased()
        new_residual, new_jacobian = residuals.linearise(trial)
        if new_residual @ new_residual < residual @ residual:
            gained = 1.0 - (new_residual @ new_residual) / (residual @ residual)
            model, residual, jacobian, damping = trial, new_residual, new_jacobian, damping / 10
            if gained < 1e-3:
                break
        else:
            damping *= 10
    return model


def _turn_and_shift(model: Model, guess: Any, T_nominal: Array | None) -> tuple[float, float]:
    """Return how far sensor and planes are turned [rad] and shifted [m] from where dataset.yaml has them, the worst of them."""
    turn = shift = 0.0
    if T_nominal is not None:
        turn = float(np.linalg.norm(log_so3(T_nominal[:3, :3].T @ model.T_flange_sensor[:3, :3])))
        shift = float(np.linalg.norm(T_nominal[:3, 3] - model.T_flange_sensor[:3, 3]))
    if isinstance(model.target, Planes):
        turns, distances = model.target.relative_to(guess.normals)
        turn = max(turn, float(np.max(turns)))
        shift = max(shift, float(np.max(np.abs(distances - guess.distances))))
    return turn, shift


def full_fit(dataset: Dataset) -> Trial | None:
    """Return the fit of sensor, target and geometry.

    None is returned if the data cannot determine it, if it fails, or if it ends implausibly far from the data sheet: a fit in which the zero of a
    joint ran a quarter turn away explains nothing, even if its residual is small.
    """
    try:
        prepared = prepare(dataset)
        equations = int(prepared.residuals.measurement.equations.sum())
        if equations < LEAST_EQUATIONS * prepared.free.sum():
            return None
        found = fit(prepared.residuals, prepared.coarse, prepared.free, tolerance=COARSE)
        if ran_away(found.model):
            return None
        return Trial(typical_distance(prepared.residuals, found.model), found.model)
    except (ScalarError, np.linalg.LinAlgError, ValueError, FloatingPointError):
        return None


def typical_distance(residuals: Residuals, model: Model) -> float:
    """Return the median over poses of the root mean square distance from the target [m]; a few wrong poses hardly change it."""
    return float(np.median(residuals.pose_distances(model)))


def thinned(dataset: Dataset) -> Dataset:
    """Return at most ``MOST_POSES`` poses, evenly over the acquisition."""
    if dataset.n_poses <= MOST_POSES:
        return dataset
    return dataset.subset(np.linspace(0, dataset.n_poses - 1, MOST_POSES).round().astype(int))
