"""The calibration exactly as the original paper prints it, for comparison.

The parameters are those of ``scalar.baseline.parameterisation``, the residuals are ``n . p - d`` of all points with one weight, and the
derivatives are lmfit's finite differences. The initial estimate is the paper's: nominal DH parameters, initial guesses of the planes,
and the linear first guess of the scanner's pose from the bottom plane.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from scalar.baseline.parameterisation import READINGS, Parameterisation
from scalar.data.dataset import Dataset
from scalar.errors import Undetermined
from scalar.estimation.measured_ranges import MEASURED_RANGES
from scalar.estimation.prepare import candidate_mask, prepare
from scalar.estimation.random_poses import ranges_of_joints
from scalar.estimation.reporting import sensor_mapping
from scalar.estimation.residuals import Residuals
from scalar.estimation.result import Calibration
from scalar.estimation.sufficiency import check_determined
from scalar.geometry.planes import Planes
from scalar.geometry.se3 import Array
from scalar.sensors import Scans, as_scans, measure
from scalar.sensors.linear_guess import linear_guess

if TYPE_CHECKING:
    import lmfit

POINTS = ("all", "compressed")
DEFAULTS: dict[str, dict[str, Any]] = {
    "now": {"xtol": 1.5e-8, "ftol": 1.5e-8, "gtol": 0.0, "epsfcn": 1e-10},
    "2018": {"xtol": 1e-7, "ftol": 1e-7, "gtol": 1e-7, "epsfcn": float(np.finfo(float).eps)},
}
"""The arguments with which lmfit calls MINPACK by default, in version 1.3, and in version 0.9, of the paper's year. `epsfcn` is the square of the
relative step of the finite differences, on which their values depend near a root whose slope is infinite."""
MAX_EVALUATIONS = 5000  # of the residual, after which a fit is stopped and reported as capped; fits that converge take some hundreds
_STEP = 1e-6
"""Step of the central differences by which lmfit's covariance is transformed to the reported coordinates."""


class _Distances:
    """``n . p - d`` [m] of all points, or compressed to three rows for each scan, as a function of lmfit's parameters."""

    def __init__(self, how: Parameterisation, q: Array, measurement: Scans, points: str) -> None:
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


def calibrate_baseline(
    dataset: Dataset,
    *,
    reading: str = "clip",
    points: str = "all",
    max_nfev: int = MAX_EVALUATIONS,
    fixed: Sequence[str] | None = None,
    defaults: str = "now",
) -> Calibration:
    """Return the calibration of a dataset of line scans by the method of the original paper.

    ``summary["status"]`` says how the fit ended: ``converged``; ``capped``, at ``max_nfev``, with the parameters
    that were tried last; ``raised``, by lmfit at a NaN, with the parameters of the start; ``stopped``, when MINPACK gave up.

    Args:
        dataset: What was measured.
        reading: How the constraints' root is read, a key of ``READINGS``.
        points: ``all`` points, or the ``compressed`` rows that have the same sum of squares.
        max_nfev: The fit is capped after so many evaluations of the residual, those for derivatives included.
        fixed: Names of parameters to fix at their nominal values; if None, those that ``scalar.estimation.identifiability`` fixes.
        defaults: Version of lmfit's defaults, a key of ``DEFAULTS``.

    Raises:
        Undetermined: The data determine no first guess; or, with ``fixed`` None, they do not determine the model.
        ValueError: ``reading`` or ``points`` is unknown, or the dataset holds no line scans.
    """
    if reading not in READINGS or points not in POINTS:
        raise ValueError(
            f"reading must be one of {', '.join(READINGS)}, and points one of {', '.join(POINTS)}"
        )
    measurement = as_scans(measure(dataset))
    how = Parameterisation(dataset.robot, measurement.initial_target(dataset))
    gauge: tuple[dict[str, Any], ...] = ()
    if fixed is None:
        gauge = _gauge(dataset)
        fixed = [entry["held"] for entry in gauge]
    _check_fixed(how, fixed)
    T_start, origin = first_guess(dataset, measurement, how.planes)
    parameters = how.lmfit_parameters(how.values(T_start), fixed, reading)
    end = _run(_Distances(how, dataset.q, measurement, points), parameters, max_nfev, DEFAULTS[defaults])

    model = how.model(_values(end.parameters))
    free = candidate_mask(model, fixed)
    names = model.names
    return Calibration(
        model=model,
        sensor=sensor_mapping(dataset),
        free=tuple(name for name, is_free in zip(names, free, strict=True) if is_free),
        covariance=_covariance(how, end, free, len(dataset.points)),
        fixed={name: "fixed, as published" for name, is_free in zip(names, free, strict=True) if not is_free},
        gauge=gauge,
        residual_rms=Residuals.of(dataset, model).rms(model),
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
            MEASURED_RANGES: ranges_of_joints(dataset.q).tolist(),
        },
    )


def _gauge(dataset: Dataset) -> tuple[dict[str, Any], ...]:
    """Return the parameters that the proposed method fixes for the same poses, as ``Calibration.gauge`` lists them.

    Raises:
        Undetermined: The data do not determine the model.
    """
    identifiability = prepare(dataset).identifiability
    check_determined(identifiability)
    return tuple(
        {"held": one.name, "reason": one.reason, "moves_with": list(one.moves_with)}
        for one in identifiability.fixed
    )


@dataclass(frozen=True, eq=False)
class _End:
    """How lmfit ended, with the covariance ``(V, V)`` of the V varying parameters; None where lmfit computed none."""

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
    import lmfit  # slow to import, and not needed for a first guess

    minimiser = lmfit.Minimizer(distances, parameters, max_nfev=max_nfev, nan_policy="raise")
    varying = sum(parameter.vary for parameter in parameters.values())
    # lmfit changes NumPy's error state, and does not restore it when it raises.
    with np.errstate(all="ignore"):
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


def first_guess(dataset: Dataset, measurement: Scans, planes: Planes) -> tuple[Array, str]:
    """Return the scanner's linear first guess ``T_flange_sensor`` ``(4, 4)`` from the most level plane, or its nominal pose; and which of them it is.

    Raises:
        Undetermined: The scans of that plane do not determine the guess, and the dataset states no nominal pose.
    """
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


def _check_fixed(how: Parameterisation, fixed: Sequence[str]) -> None:
    without = [name for name in fixed if name not in how.names]
    if without:
        raise Undetermined(
            [f"{name} would have to be fixed, and the baseline has no such parameter" for name in without]
        )


def _covariance(how: Parameterisation, end: _End, free: Array, points: int) -> Array:
    """Return the covariance ``(F, F)`` of the F free coordinates after a fit to a number of points; NaN where lmfit computed none."""
    if end.covariance is None:
        return np.full((int(free.sum()),) * 2, np.nan)
    rows_to_points = max(end.rows - end.varying, 1) / max(points - end.varying, 1)
    return _reported(how, end.parameters, free, end.covariance * rows_to_points)


def _reported(how: Parameterisation, parameters: lmfit.Parameters, free: Array, covariance: Array) -> Array:
    """Return lmfit's covariance ``(V, V)`` transformed to the F free coordinates that are reported, ``(F, F)``."""
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
