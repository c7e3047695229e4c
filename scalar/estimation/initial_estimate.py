"""The initial estimate of sensor and target: a linear first guess of the scanner's pose (Section III-A of the paper), refined.

For a known plane the residual is linear in the scanner's axes and origin on the flange: ``c = (n'.p + n'_4 - d, n'.X, n'.Z)`` with
``n' = n^T T_base_flange``, so nine numbers follow from one linear least-squares problem, of which a rotation is made. Since the
planes are known only roughly, planes and scanner are then refined together with the arm fixed at its nominal geometry, which tolerates
a guess of the floor that is 30 degrees off.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from scalar.errors import Undetermined
from scalar.estimation.least_squares import Fit, fit
from scalar.estimation.model import Model
from scalar.estimation.residuals import Residuals
from scalar.geometry.planes import Planes
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import Array, transform
from scalar.sensors.line_laser import LineLaser

COARSE = 1e-6  # relative tolerance of fits that others continue
_ALTERNATIONS = 8
_UNKNOWNS = 9


@dataclass(frozen=True, eq=False)
class InitialEstimate:
    """Sensor and target as first estimated, and how well they fit with the nominal arm.

    Attributes:
        model: Sensor and target fitted, robot nominal.
        rms: Root mean square distance [m].
        origin: ``nominal pose`` or ``linear guess``.
    """

    model: Model
    rms: float
    origin: str


def linear_guess(measurement: LineLaser, T_base_flange: Array, planes: Planes, use: Array) -> Array:
    """Return the scanner's pose on the flange ``(4, 4)`` from scans of planes taken as known.

    Args:
        measurement: The scans.
        T_base_flange: ``(N, 4, 4)``, of the nominal arm.
        planes: As guessed.
        use: ``(N,)`` bool, the poses to use; the paper takes those on the bottom plane.

    Raises:
        Undetermined: The poses do not determine the nine numbers.
    """
    index = measurement.target_index[use]
    n = planes.normals[index]
    T = T_base_flange[use]
    n_flange = np.einsum("nx,nxy->ny", n, T[:, :3, :3])
    offset = np.einsum("nx,nx->n", n, T[:, :3, 3]) - planes.distances[index]
    R = measurement.R[use][:, :, :3]
    A = np.concatenate([R[:, :, j : j + 1] * n_flange[:, None, :] for j in range(3)], axis=2)
    A = A.reshape(-1, _UNKNOWNS)
    b = -(R[:, :, 0] * offset[:, None]).ravel()
    solution, _, rank, _ = np.linalg.lstsq(A, b, rcond=1e-10)
    if rank < _UNKNOWNS:
        raise Undetermined(
            [f"the scans determine only {rank} of the {_UNKNOWNS} numbers of a first guess of the scanner's pose; "
             "add poses that turn the scanner about all three axes, or state sensor.nominal_pose"]
        )  # fmt: skip
    p, x, z = solution[:3], solution[3:6], solution[6:]
    x, z = x / np.linalg.norm(x), z / np.linalg.norm(z)
    U, _, Vt = np.linalg.svd(np.column_stack([x, np.cross(z, x), z]))
    return transform(U @ np.diag([1.0, 1.0, np.linalg.det(U @ Vt)]) @ Vt, p)


def estimate_initially(
    residuals: Residuals, robot: Robot, target: Any, T_flange_sensor: Array | None
) -> InitialEstimate:
    """Return the initial estimate with the least misfit, from the stated nominal pose, if there is one, and from linear guesses.

    Args:
        residuals: Of the dataset, without effects.
        robot: Nominal.
        target: As first guessed.
        T_flange_sensor: The sensor's nominal pose, or None.

    Raises:
        Undetermined: No pose is stated, and the data determine no linear guess.
    """
    measurement = residuals.measurement
    best: InitialEstimate | None = None
    lowest = np.inf
    for origin, T, planes in proposals(measurement, robot, residuals.poses.q, target, T_flange_sensor):
        found = _refined(residuals, Model.at(robot, T, planes))
        if best is None or found.chi_squared < lowest:
            model = found.model.rebased()
            best, lowest = InitialEstimate(model, residuals.rms(model), origin), found.chi_squared
    assert best is not None
    return best


def proposals(
    measurement: Any, robot: Robot, q: Array, target: Any, T_flange_sensor: Array | None
) -> list[tuple[str, Array, Any]]:
    """Return where a fit may start: (origin, sensor's pose on the flange ``(4, 4)``, target) each.

    Args:
        measurement: The dataset as rows.
        robot: Nominal.
        q: ``(N, n)`` [rad], joint angles.
        target: At its initial guess.
        T_flange_sensor: The sensor's nominal pose, or None.

    Raises:
        Undetermined: Neither a stated pose nor a linear guess is to be had.
    """
    T_base_flange = robot.flange(q)
    found: list[tuple[str, Array, Any]] = []
    if T_flange_sensor is not None:
        planes = measurement.fitted_target(T_base_flange @ T_flange_sensor, target)
        found.append(("nominal pose", T_flange_sensor, planes))
    failure = Undetermined(["state sensor.nominal_pose: this kind of sensor needs it"])
    if isinstance(measurement, LineLaser):
        for use in _plane_choices(measurement, target, robot):
            try:
                T = _alternate(measurement, T_base_flange, target, use)
                found.append(("linear guess", T, measurement.fitted_target(T_base_flange @ T, target)))
                found.append(("linear guess", linear_guess(measurement, T_base_flange, target, use), target))
            except Undetermined as error:
                failure = error
            if T_flange_sensor is not None:
                break
    if not found:
        raise failure
    return found


def sensor_and_target(residuals: Residuals, model: Model) -> Array:
    """Return which coordinates ``(P,)`` are those of the sensor, as far as it is observed, and of the target."""
    free = np.zeros(len(model.vector), dtype=bool)
    free[model.blocks["target"]] = True
    sensor = model.blocks["sensor"].start
    free[sensor : sensor + (6 if residuals.measurement.sees_sensor_rotation else 3)] = True
    return free


def _plane_choices(measurement: LineLaser, target: Planes, robot: Robot) -> list[Array]:
    """Return sets of poses to guess from: those on the most nearly level plane, as in the paper, then all."""
    up = -robot.gravity / max(float(np.linalg.norm(robot.gravity)), 1e-12)
    level = int(np.argmax(np.abs(target.normals @ up)))
    return [measurement.target_index == level, np.ones(len(measurement.target_index), dtype=bool)]


def _alternate(measurement: LineLaser, T_base_flange: Array, target: Planes, use: Array) -> Array:
    """Return the scanner's pose after alternating between the linear guess and the planes that fit it."""
    T = linear_guess(measurement, T_base_flange, target, use)
    everywhere = np.ones(len(measurement.target_index), dtype=bool)
    for _ in range(_ALTERNATIONS):
        planes = measurement.fitted_target(T_base_flange @ T, target)
        T = linear_guess(measurement, T_base_flange, planes, everywhere)
    return T


def _refined(residuals: Residuals, model: Model) -> Fit:
    return fit(residuals, model, sensor_and_target(residuals, model), tolerance=COARSE)
