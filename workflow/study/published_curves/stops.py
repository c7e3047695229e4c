"""The path of the published solver to the optimum, recorded once without noise, to see where an early stop would leave it.

The solver is MINPACK's Levenberg-Marquardt (as lmfit calls it), started at the initial model. Far from the optimum the noise matters little, so
one path without noise is used for every noise, and the displacement by the noise is added to it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import leastsq

from scalar.data.poses import Poses
from scalar.errors import Undetermined
from scalar.estimation.effect_bases import EffectBases
from scalar.estimation.kinematics import Kinematics
from scalar.estimation.model import Model
from scalar.estimation.residuals import Residuals
from scalar.geometry.planes import Planes
from scalar.geometry.se3 import Array, log_so3
from scalar.sensors import as_scans, measure
from scalar.sensors.linear_guess import linear_guess
from study.published_curves.workcell import Workcell, first_poses

ITERATIONS = 40
"""Iterations after which a path is no longer followed; all have converged by then."""


@dataclass(frozen=True, eq=False)
class SolverPath:
    """Iterates of one run.

    Attributes:
        left: ``(I, P, 6)``, rotation [rad] and translation [m] by which the evaluation poses are still wrong at each iterate, the start first.
        excess: ``(I,)`` [m^2], the sum of squared distances above that of the optimum. points: Per scan, of the recorded path.
    """

    left: Array
    excess: Array
    points: int


def follow(workcell: Workcell, poses: int, guess: Planes, kept: Array) -> SolverPath:
    """Return the path from initial guesses of the planes, the last iterate repeated to ``ITERATIONS``.

    Args:
        workcell: Noise-free. poses: To use, the first of every plane. guess: The initial guesses of the planes.
        kept: Indices of the evaluation poses.
    """
    rows = first_poses(workcell, poses)
    dataset = workcell.dataset.subset(rows) if len(rows) < workcell.dataset.n_poses else workcell.dataset
    at = Poses.from_frame(workcell.evaluated.iloc[kept], dataset.robot.n_joints, order_is_row=False)
    T_true = workcell.T_true[kept]
    measurement = measure(dataset)
    T_flange = dataset.robot.flange(dataset.q)
    level = int(np.argmax(np.abs(guess.normals @ dataset.robot.gravity)))
    try:
        T_sensor = linear_guess(as_scans(measurement), T_flange, guess, measurement.target_index == level)
    except Undetermined:
        if dataset.sensor.T_flange_sensor is None:
            raise
        T_sensor = dataset.sensor.T_flange_sensor
    start = Model.at(dataset.robot, T_sensor, guess)
    residuals = Residuals.of(dataset, start, measurement)
    unit = measurement.sigma
    x_start = start.vector
    where = np.flatnonzero(workcell.free)
    path: list[tuple[Model, float]] = []

    def model_at(x: Array) -> Model:
        vector = x_start.copy()
        vector[where] = x
        return start.with_vector(vector)

    def by_x(x: Array) -> Array:
        model = model_at(x)
        residual, J = residuals.linearise(model)
        if not path or not np.array_equal(model.vector, path[-1][0].vector):  # SciPy asks twice at the start
            path.append((model, float(residual @ residual) * unit**2))
        return J[:, where]

    end: Any = leastsq(
        lambda x: residuals.residual(model_at(x)), x_start[where], Dfun=by_x, maxfev=ITERATIONS + 20
    )
    by_x(end[0])
    path = path[:ITERATIONS]
    bases = EffectBases.of(workcell.model.nominal, at, ())
    left = [_away(Kinematics.of(model, at, bases).T_base_sensor, T_true) for model, _ in path]
    left, excess = np.array(left), np.array([excess for _, excess in path])
    pad = ITERATIONS - len(path)
    return SolverPath(
        np.concatenate([left, np.repeat(left[-1:], pad, axis=0)]),
        np.concatenate([excess, np.repeat(excess[-1:], pad)]),
        workcell.ranges.shape[1],
    )


def _away(T: Array, T_true: Array) -> Array:
    turn = log_so3(T[:, :3, :3] @ np.swapaxes(T_true[:, :3, :3], 1, 2))
    return np.concatenate([turn, T[:, :3, 3] - T_true[:, :3, 3]], axis=1)


def stops_at(path: SolverPath, floor: float, tolerance: float) -> int:
    """Return the first iterate after a step that lowered the sum of squares by less than a share ``tolerance``.

    Args:
        path: The iterates. floor: Sum of squares that the noise leaves [m^2]. tolerance: lmfit's ftol.
    """
    cost = path.excess + floor
    share = 1.0 - cost[1:] / cost[:-1]
    below = np.flatnonzero(share <= tolerance)
    return int(below[0]) + 1 if len(below) else len(cost) - 1
