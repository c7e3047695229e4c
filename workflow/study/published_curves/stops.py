"""Record the path of the original paper's solver to the optimum, to compute the errors that remain if it stops early.

The solver is MINPACK's Levenberg-Marquardt (as lmfit calls it), started at the initial model. Far from the optimum the noise matters little, so
one path without noise is used for every noise, and the displacement by the noise is added to it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from scalar.data.poses import Poses
from scalar.errors import Undetermined
from scalar.estimation.effect_bases import EffectBases
from scalar.estimation.kinematics import Kinematics
from scalar.estimation.minpack import levenberg_marquardt
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
    """The I iterates of one run of the solver, the start first.

    Attributes:
        left: ``(I, P, 6)``, the errors of the evaluation poses that are left at each iterate: rotation [rad] and translation [m].
        excess: ``(I,)`` [m^2], the sum of squared distances of the points from the planes, in excess of that at the optimum.
        points: Number of points in a scan with which the path was recorded.
    """

    left: Array
    excess: Array
    points: int


def follow(workcell: Workcell, poses: int, guess: Planes, kept: Array) -> SolverPath:
    """Return the iterates of the solver from initial guesses of the planes; if it converges early, the last one is repeated to ``ITERATIONS``.

    Args:
        workcell: A workcell without noise.
        poses: Number of poses to use, the first of every plane.
        guess: The initial guesses of the planes.
        kept: ``(P,)``, indices of the evaluation poses that are used.
    """
    rows = first_poses(workcell, poses)
    dataset = workcell.dataset.subset(rows) if len(rows) < workcell.dataset.n_poses else workcell.dataset
    at = Poses.from_frame(workcell.evaluated.iloc[kept], dataset.robot.slides, order_is_row=False)
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
    x_start = start.vector
    free = np.flatnonzero(workcell.free)
    path: list[tuple[Model, float]] = []

    def model_at(x: Array) -> Model:
        vector = x_start.copy()
        vector[free] = x
        return start.with_vector(vector)

    def recorded_jacobian(x: Array) -> Array:
        """Return the Jacobian, which the solver asks for once at each iterate, and append the iterate to the path."""
        model = model_at(x)
        residual, J = residuals.linearise(model)
        if not path or not np.array_equal(model.vector, path[-1][0].vector):  # SciPy asks twice at the start
            path.append((model, float(residual @ residual) * measurement.sigma**2))
        return J[:, free]

    end, _, _ = levenberg_marquardt(
        lambda x: residuals.residual(model_at(x)),
        recorded_jacobian,
        x_start[free],
        max_evaluations=ITERATIONS + 20,
    )
    recorded_jacobian(end)
    path = path[:ITERATIONS]
    bases = EffectBases.of(workcell.model.nominal, at, ())
    left = [_pose_errors(Kinematics.of(model, at, bases).T_base_sensor, T_true) for model, _ in path]
    left, excess = np.array(left), np.array([excess for _, excess in path])
    pad = ITERATIONS - len(path)
    return SolverPath(
        np.concatenate([left, np.repeat(left[-1:], pad, axis=0)]),
        np.concatenate([excess, np.repeat(excess[-1:], pad)]),
        workcell.ranges.shape[1],
    )


def _pose_errors(T: Array, T_true: Array) -> Array:
    """Return the rotations [rad] and translations [m] ``(P, 6)`` from true frames ``(P, 4, 4)`` to frames ``(P, 4, 4)``, in the base frame."""
    turn = log_so3(T[:, :3, :3] @ np.swapaxes(T_true[:, :3, :3], 1, 2))
    return np.concatenate([turn, T[:, :3, 3] - T_true[:, :3, 3]], axis=1)


def stops_at(path: SolverPath, floor: float, tolerance: float) -> int:
    """Return the index of the first iterate whose step lowered the sum of squares by at most the share ``tolerance``; without one, of the last.

    Args:
        path: The iterates.
        floor: Sum of squares that the noise leaves at the optimum [m^2].
        tolerance: lmfit's ``ftol``.
    """
    cost = path.excess + floor
    share = 1.0 - cost[1:] / cost[:-1]
    below = np.flatnonzero(share <= tolerance)
    return int(below[0]) + 1 if len(below) else len(cost) - 1
