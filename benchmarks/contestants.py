"""Ways to fit the same model from the same start: by lmfit, by SciPy and by ``scalar``.

They differ in whether points are compressed and whether the Jacobian is analytic. All minimise the
same weighted sum of squares over the same free coordinates (normals on the sphere, rotation vectors), but for
the published one, which has its own parameters and weights all points alike.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace

import lmfit
import numpy as np
from scipy.optimize import least_squares

from scalar import kernels
from scalar.baseline.fit import calibrate_baseline
from scalar.data.dataset import Dataset
from scalar.estimation import residuals as residuals_module
from scalar.estimation.calibrate import calibrate
from scalar.estimation.least_squares import TOLERANCE, Fit, covariance_and_step, fit
from scalar.estimation.lmfit_fit import fit_with_lmfit
from scalar.estimation.lmfit_parameters import from_lmfit, to_lmfit
from scalar.estimation.model import Model
from scalar.estimation.prepare import Prepared, prepare
from scalar.estimation.residuals import Residuals
from scalar.estimation.result import Calibration
from scalar.sensors.profile import contact


@contextmanager
def numpy_alone() -> Iterator[None]:
    """Work without the compiled kernels within the block, as if the installation had found no C compiler."""
    modules = (kernels, residuals_module)
    library = kernels.LIBRARY
    try:
        for module in modules:
            module.LIBRARY = None
        yield
    finally:
        for module in modules:
            module.LIBRARY = library


@dataclass(frozen=True, eq=False)
class Result:
    """The free parameters of the arm ``(G,)`` [m, rad], the same in all ways; their standard errors; the number of evaluations."""

    values: np.ndarray
    std: np.ndarray
    evaluations: int


class Contest:
    """A dataset, the start of its fit, and a method for each way to fit."""

    def __init__(self, dataset: Dataset) -> None:
        self.dataset = dataset
        self.prepared: Prepared = prepare(dataset)
        self.model: Model = self.prepared.initial.model
        self.free = np.flatnonzero(self.prepared.free)
        self.arm = self.free[self.free < dataset.robot.geometry.size]
        self.pose = np.repeat(np.arange(dataset.n_poses), np.diff(dataset.starts))
        self.plane = self.prepared.residuals.measurement.target_index[self.pose]
        self.x, self.z = np.ascontiguousarray(dataset.points.T)
        self.weights = self._weights()

    def _weights(self) -> np.ndarray:
        """Return the weight of every point ``(P,)`` [1/m]: range noise seen along the normal."""
        laser = self.prepared.residuals.measurement
        T = self.prepared.residuals.kinematics(self.model).T_base_sensor
        c = contact(T, self.model.target, laser.target_index)[0][self.pose]
        along_ray = np.abs(c[:, 1] * self.x + c[:, 2] * self.z) / np.hypot(self.x, self.z)
        return 1.0 / (laser.sigma * np.maximum(along_ray, 0.05))

    def compressed_residuals(self) -> Residuals:
        """Return all points, weighted for the start and compressed to three rows a scan."""
        return self.prepared.residuals.reweighted(self.model)

    def fit_proposed(self, residuals: Residuals) -> Result:
        """Compressed rows, analytic Jacobian, our standard errors."""
        found: Fit = fit(residuals, self.model, self.prepared.free)
        return self._result(found.model.vector, found.covariance, found.evaluations)

    def proposed(self) -> Result:
        """Return the same, the compression included."""
        return self.fit_proposed(self.compressed_residuals())

    def proposed_in_numpy(self) -> Result:
        """Return the same without the compiled kernels."""
        with numpy_alone():
            return self.proposed()

    def calibrate_in_numpy(self) -> Calibration:
        """Return the whole calibration without the compiled kernels."""
        with numpy_alone():
            return calibrate(replace(self.dataset))

    def proposed_through_lmfit(self) -> Result:
        """Compressed rows and analytic Jacobian handed to lmfit, its report written."""
        found, result = fit_with_lmfit(self.compressed_residuals(), self.model, self.prepared.free)
        lmfit.fit_report(result)
        return self._result(found.model.vector, found.covariance, found.evaluations)

    def all_points_finite_differences(self) -> Result:
        """Every point a residual, lmfit as it comes."""
        return self._lmfit(self._all_points)

    def factored_finite_differences(self) -> Result:
        """Every point a residual, what the points of a scan share computed once; lmfit as it comes."""
        return self._lmfit(self._all_points_factored)

    def compressed_finite_differences(self) -> Result:
        """Three rows a scan, lmfit as it comes; the compression included."""
        return self._lmfit(self.compressed_residuals().residual)

    def scipy_all_points(self) -> Result:
        """Every point a residual, SciPy's trust region with finite differences."""
        return self._scipy(self._all_points, "2-point")

    def scipy_compressed_analytic(self) -> Result:
        """Three rows a scan, our Jacobian, SciPy's trust region; the compression included."""
        residuals = self.compressed_residuals()
        return self._scipy(residuals.residual, lambda model: residuals.linearise(model)[1][:, self.free])

    def published(self) -> Result:
        """As printed: 43 parameters, every point, finite differences, ``clip``; from the paper's start."""
        fixed = self.prepared.identifiability.fixed_names
        found = calibrate_baseline(self.dataset, reading="clip", points="all", fixed=fixed)
        return self._result(found.model.vector, found.covariance, int(found.summary["evaluations"]))

    def _all_points(self, model: Model) -> np.ndarray:
        """Return ``n . p - d`` of every point p, moved into the base frame, weighted."""
        T = (model.robot.flange(self.dataset.q) @ model.T_flange_sensor)[self.pose]
        p = T[:, :3, 0] * self.x[:, None] + T[:, :3, 2] * self.z[:, None] + T[:, :3, 3]
        f = np.sum(model.target.normals[self.plane] * p, axis=1) - model.target.distances[self.plane]
        return f * self.weights

    def _all_points_factored(self, model: Model) -> np.ndarray:
        """Return the same from ``n . X``, ``n . Z`` and ``n . o - d`` of every pose: a third of the work."""
        T = model.robot.flange(self.dataset.q) @ model.T_flange_sensor
        index = self.prepared.residuals.measurement.target_index
        along = np.einsum("nx,nxk->kn", model.target.normals[index], T[:, :3, [0, 2, 3]])
        along_x, along_z, offset = along[0], along[1], along[2] - model.target.distances[index]
        return (along_x[self.pose] * self.x + along_z[self.pose] * self.z + offset[self.pose]) * self.weights

    def _lmfit(self, residual) -> Result:
        start = self.model.vector

        def of_parameters(parameters: lmfit.Parameters) -> np.ndarray:
            vector = start.copy()
            vector[self.free] = from_lmfit(parameters)
            return residual(self.model.with_vector(vector))

        parameters = lmfit.Parameters()
        parameters.add_many(*to_lmfit([self.model.names[i] for i in self.free], start[self.free]))
        found = lmfit.minimize(of_parameters, parameters, scale_covar=False)
        vector = start.copy()
        vector[self.free] = from_lmfit(found.params)
        return self._result(vector, found.covar, int(found.nfev))

    def _scipy(self, residual, jacobian) -> Result:
        start = self.model.vector

        def at(x: np.ndarray) -> Model:
            vector = start.copy()
            vector[self.free] = x
            return self.model.with_vector(vector)

        found = least_squares(
            lambda x: residual(at(x)),
            start[self.free],
            jac=jacobian if isinstance(jacobian, str) else lambda x: jacobian(at(x)),
            x_scale="jac",
            ftol=TOLERANCE,
            xtol=TOLERANCE,
            gtol=None,
        )
        covariance, _ = covariance_and_step(found.jac, found.fun)
        return self._result(at(found.x).vector, covariance, int(found.nfev))

    def _result(self, vector: np.ndarray, covariance: np.ndarray, evaluations: int) -> Result:
        return Result(vector[self.arm], np.sqrt(np.diag(covariance))[: len(self.arm)], evaluations)
