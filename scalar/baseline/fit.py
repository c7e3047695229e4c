"""The calibration as the paper prints it, literally: to be compared with, not to be used.

Every unit vector is three lmfit parameters, the third constrained to ``n_z = sqrt(1 - n_x^2 - n_y^2)`` by an
expression, the scanner's rotation is an axis and an angle, the residuals are ``n . p - d`` of all points with
one weight, and the derivatives are lmfit's finite differences. For six joints and three planes that is 43
parameters, four of them constrained. The start is the paper's: nominal DH parameters, rough planes, the
linear first guess of the scanner from the bottom plane.

Beside an upright wall the root is undefined and its slope infinite. The paper does not say how it read it, so
the readings have names: ``raise`` leaves lmfit alone, which stops at the first NaN; ``clip`` takes max(0, .);
``abs`` takes the absolute value.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import lmfit
import numpy as np

from scalar.data.dataset import Dataset
from scalar.errors import Undetermined
from scalar.estimation.initial_estimate import linear_guess
from scalar.estimation.lmfit_parameters import lmfit_names
from scalar.estimation.model import Model
from scalar.estimation.prepare import candidate_mask, prepare
from scalar.estimation.residuals import Residuals
from scalar.estimation.result import Calibration, reporting, sensor_mapping
from scalar.geometry.planes import Planes
from scalar.geometry.robot import GEOMETRY, Robot
from scalar.geometry.se3 import Array, exp_so3, transform
from scalar.sensors.line_laser import LineLaser

READINGS = {"raise": "sqrt({})", "clip": "sqrt(max(0, {}))", "abs": "sqrt(abs({}))"}
"""How the square root of the constraints is read, as an lmfit expression."""
POINTS = ("all", "compressed")
DEFAULTS: dict[str, dict[str, Any]] = {
    "now": {"xtol": 1.5e-8, "ftol": 1.5e-8, "gtol": 0.0, "epsfcn": 1e-10},
    "2018": {"xtol": 1e-7, "ftol": 1e-7, "gtol": 1e-7, "epsfcn": float(np.finfo(float).eps)},
}
"""How lmfit calls MINPACK where nothing is said: version 1.3, and 0.9 of the paper's year. `epsfcn` is the square of the
relative step of the finite differences, which decides what they make of a root whose slope is infinite."""
MAX_EVALUATIONS = 5000  # beyond it a fit is reported as capped; one that ends takes some hundreds
DH_KINDS = GEOMETRY[:4]  # the published model has no beta
SENSOR = ("r_x", "r_y", "r_z", "r_theta", "sensor_x", "sensor_y", "sensor_z")
_STEP = 1e-6  # of the central differences that carry lmfit's covariance to the coordinates that are reported


@dataclass(frozen=True, eq=False)
class Parameterisation:
    """The published parameters of a robot and its planes, and back.

    Attributes:
        nominal: The arm as the data sheet has it; its beta is kept.
        planes: Names, rough normals (which give the sign that is reported) and distances.
    """

    nominal: Robot
    planes: Planes

    @property
    def names(self) -> list[str]:
        """Return ``a_1 .. theta_n r_x .. sensor_z normal_<plane>_x .. distance_<plane>``."""
        geometry = [f"{kind}_{i + 1}" for kind in DH_KINDS for i in range(self.nominal.n_joints)]
        planes = [
            text
            for name in self.planes.names
            for text in (*(f"normal_{name}_{axis}" for axis in "xyz"), f"distance_{name}")
        ]
        return [*geometry, *SENSOR, *planes]

    def values(self, T_flange_sensor: Array) -> Array:
        """Return the parameters of the nominal arm, the rough planes and a scanner at ``(4, 4)``.

        A normal or an axis that points down, which the root cannot hold, is turned round with its distance or
        its angle, which so comes to lie in -pi to pi; no bound is set on it.
        """
        rotation_vector = Model.at(self.nominal, T_flange_sensor, self.planes).sensor_rotation_vector()
        angle = float(np.linalg.norm(rotation_vector))
        axis = rotation_vector / angle if angle > 0 else np.array([0.0, 0.0, 1.0])
        turn = -1.0 if axis[2] < 0 else 1.0
        side = np.where(self.planes.normals[:, 2:] < 0, -1.0, 1.0)
        planes = side * np.column_stack([self.planes.normals, self.planes.distances])
        geometry = self.nominal.geometry[: len(DH_KINDS)].ravel()
        return np.concatenate([geometry, turn * axis, [turn * angle], T_flange_sensor[:3, 3], planes.ravel()])

    def lmfit_parameters(self, values: Array, held: Sequence[str], reading: str) -> lmfit.Parameters:
        """Return lmfit parameters at values ``(P,)``, the last component of every unit vector constrained.

        Args:
            values: In the order of ``names``.
            held: Names of those that do not vary.
            reading: A key of ``READINGS``.
        """
        parameters = lmfit.Parameters()
        safe = dict(zip(self.names, lmfit_names(self.names), strict=True))
        for name, value in zip(self.names, values, strict=True):
            parameters.add(safe[name], value=float(value), vary=name not in held)
        for stem in ("r", *(f"normal_{name}" for name in self.planes.names)):
            x, y = safe[f"{stem}_x"], safe[f"{stem}_y"]
            parameters[safe[f"{stem}_z"]].expr = READINGS[reading].format(f"1 - {x}**2 - {y}**2")
        return parameters

    def unpack(self, values: Array) -> tuple[Robot, Array, Array, Array]:
        """Return the arm, ``T_flange_sensor`` ``(4, 4)``, normals ``(K, 3)``, almost unit, and distances."""
        n = self.nominal.n_joints
        geometry, sensor, planes = np.split(values, [len(DH_KINDS) * n, len(DH_KINDS) * n + len(SENSOR)])
        beta = self.nominal.geometry[len(DH_KINDS) :]
        robot = self.nominal.with_geometry(np.vstack([geometry.reshape(-1, n), beta]))
        axis = sensor[:3] / np.linalg.norm(sensor[:3])
        table = planes.reshape(-1, 4)
        return robot, transform(exp_so3(axis * sensor[3]), sensor[4:]), table[:, :3], table[:, 3]

    def model(self, values: Array) -> Model:
        """Return the model in reporting coordinates; a plane's sign is that of its rough guess."""
        robot, T_flange_sensor, normals, distances = self.unpack(values)
        sign = np.where(np.sum(normals * self.planes.normals, axis=1) < 0, -1.0, 1.0)
        scale = sign / np.linalg.norm(normals, axis=1)
        target = Planes.at(self.planes.names, normals * scale[:, None], distances * scale)
        sensor = np.r_[T_flange_sensor[:3, 3], 0.0, 0.0, 0.0]
        return reporting(Model(robot, self.nominal, T_flange_sensor[:3, :3], sensor, target), self.planes)


class _Distances:
    """``n . p - d`` [m] of all points, or of the rows that they are compressed to, at lmfit parameters."""

    def __init__(self, how: Parameterisation, q: Array, measurement: LineLaser, points: str) -> None:
        self.how, self.q, self.points = how, q, points
        self.index = measurement.target_index.astype(np.intp)
        self.rows = measurement.R_metric
        self.pose = np.repeat(np.arange(len(q)), np.diff(measurement.starts).astype(np.intp))
        self.x, self.z = np.ascontiguousarray(measurement.points.T)

    def __call__(self, parameters: lmfit.Parameters) -> Array:
        robot, T_flange_sensor, normals, distances = self.how.unpack(_values(parameters))
        T = robot.flange(self.q) @ T_flange_sensor
        n = normals[self.index]
        offset = np.sum(n * T[:, :3, 3], axis=1) - distances[self.index]
        along_x, along_z = np.sum(n * T[:, :3, 0], axis=1), np.sum(n * T[:, :3, 2], axis=1)
        if self.points == "all":
            return offset[self.pose] + along_x[self.pose] * self.x + along_z[self.pose] * self.z
        return (self.rows @ np.stack([offset, along_x, along_z], axis=1)[:, :, None]).ravel()


def calibrate_published(
    dataset: Dataset,
    *,
    reading: str = "clip",
    points: str = "all",
    max_nfev: int = MAX_EVALUATIONS,
    held: Sequence[str] | None = None,
    defaults: str = "now",
) -> Calibration:
    """Return what the published way finds in a dataset of line scans.

    ``summary["status"]`` says how it ended: ``converged``; ``capped``, stopped at ``max_nfev``, the
    parameters being the last tried; ``raised``, stopped by lmfit at a NaN, the parameters being those of the
    start; ``stopped``, MINPACK gave up.

    Args:
        dataset: What was measured.
        reading: Of the constraints' root, a key of ``READINGS``.
        points: ``all`` points, or the ``compressed`` rows that have the same sum of squares.
        max_nfev: Most evaluations of the residual, those for derivatives included.
        held: Names to hold at their nominal values; None: what ``scalar.estimation.identifiability`` finds unseen.
        defaults: Of lmfit, a key of ``DEFAULTS``.

    Raises:
        Undetermined: The data determine no first guess; or, with ``held`` None, not the model.
    """
    if reading not in READINGS or points not in POINTS:
        raise ValueError(f"reading is one of {', '.join(READINGS)}, points one of {', '.join(POINTS)}")
    if dataset.sensor.kind != "line-laser":
        raise ValueError(f"the published way is for a line-laser, and this is a {dataset.sensor.kind}")
    measurement = LineLaser.of(dataset)
    how = Parameterisation(dataset.robot, measurement.initial_target(dataset))
    gauge: tuple[dict[str, Any], ...] = ()
    if held is None:
        found = prepare(dataset).identifiability.fixed
        held = [h.name for h in found]
        gauge = tuple({"held": h.name, "reason": h.reason, "moves_with": list(h.moves_with)} for h in found)
    _check_held(how, held)
    T_start, origin = first_guess(dataset, measurement, how.planes)
    parameters = how.lmfit_parameters(how.values(T_start), held, reading)
    end = _run(_Distances(how, dataset.q, measurement, points), parameters, max_nfev, DEFAULTS[defaults])

    model = how.model(_values(end.parameters))
    free = candidate_mask(model, held)
    covariance = np.full((int(free.sum()),) * 2, np.nan)
    if end.covariance is not None:
        rows_to_points = max(end.rows - end.varying, 1) / max(len(dataset.points) - end.varying, 1)
        covariance = _reported(how, end.parameters, free, end.covariance * rows_to_points)
    names = model.names
    return Calibration(
        model=model,
        sensor=sensor_mapping(dataset),
        free=tuple(name for name, is_free in zip(names, free, strict=True) if is_free),
        covariance=covariance,
        held={name: "held, as published" for name, is_free in zip(names, free, strict=True) if not is_free},
        gauge=gauge,
        residual_rms=Residuals.of(dataset, model, measurement).rms(model),
        summary={
            "parameterisation": "published",
            "reading": reading,
            "rows": points,
            "lmfit_defaults": defaults,
            "status": end.status,
            "message": end.message,
            "evaluations": end.evaluations,
            "parameters": len(parameters),
            "varying": end.varying,
            "started_from": origin,
            "poses": dataset.n_poses,
            "points": len(dataset.points),
        },
    )


@dataclass(frozen=True, eq=False)
class _End:
    """How lmfit ended, with its covariance ``(V, V)`` of the varying parameters where it has one."""

    status: str
    message: str
    parameters: lmfit.Parameters
    covariance: Array | None
    evaluations: int
    rows: int
    varying: int


def _run(
    distances: _Distances, parameters: lmfit.Parameters, max_nfev: int, defaults: dict[str, Any]
) -> _End:
    minimiser = lmfit.Minimizer(distances, parameters, max_nfev=max_nfev, nan_policy="raise")
    varying = sum(parameter.vary for parameter in parameters.values())
    with np.errstate(all="ignore"):  # lmfit sets this for itself, and leaves it so when it raises
        try:
            result: Any = minimiser.leastsq(**defaults)
        except ValueError as error:
            reached: Any = minimiser.result
            if not np.isnan(_values(reached.params)).any():
                raise
            message = " ".join(str(error).split())
            return _End("raised", message, parameters, None, int(reached.nfev), 0, varying)
    if result.aborted:
        status = "capped"
    else:
        status = "converged" if result.success else "stopped"
    covariance = result.covar if result.errorbars and np.all(np.isfinite(result.covar)) else None
    message = " ".join(str(result.message).split())
    return _End(status, message, result.params, covariance, int(result.nfev), len(result.residual), varying)


def _values(parameters: lmfit.Parameters) -> Array:
    return np.array([parameter.value for parameter in parameters.values()], dtype=float)


def first_guess(dataset: Dataset, measurement: LineLaser, planes: Planes) -> tuple[Array, str]:
    """Return the scanner's linear first guess ``(4, 4)`` from the most level plane; else its nominal pose."""
    level = int(np.argmax(np.abs(planes.normals @ dataset.robot.gravity)))
    T_base_flange = dataset.robot.flange(dataset.q)
    try:
        return linear_guess(
            measurement, T_base_flange, planes, measurement.target_index == level
        ), "linear guess"
    except Undetermined:
        if dataset.sensor.T_flange_sensor is None:
            raise
        return dataset.sensor.T_flange_sensor, "nominal pose"


def _check_held(how: Parameterisation, held: Sequence[str]) -> None:
    without = [name for name in held if name not in how.names]
    if without:
        raise Undetermined(
            [f"{name} would have to be held, and the published way has no such parameter" for name in without]
        )


def _reported(how: Parameterisation, parameters: lmfit.Parameters, free: Array, covariance: Array) -> Array:
    """Return lmfit's covariance carried to the free coordinates that are reported, ``(F, F)``."""
    columns = []
    for parameter in parameters.values():
        if not parameter.vary:
            continue
        centre, ends = parameter.value, []
        for step in (-_STEP, _STEP):
            parameter.value = centre + step
            parameters.update_constraints()
            ends.append(how.model(_values(parameters)).vector)
        parameter.value = centre
        columns.append((ends[1] - ends[0]) / (2 * _STEP))
    parameters.update_constraints()
    G = np.column_stack(columns)[np.flatnonzero(free)]
    return G @ covariance @ G.T
