"""Variance components of whole poses: joints that do not repeat exactly, and scans with an error of their own.

Such errors have zero mean, so only the covariance of the residual shows them. Each component adds ``v K_i`` to the unit covariance of the whitened
rows of pose i, where v is its variance ([rad^2] or [m^2]) and ``K_i = D_i D_i'``. For a jitter of the joints, D_i has the rows' derivatives by the
joint angles; for a bias of the scans, those by an error common to the scan. v is found by maximum likelihood. The likelihoods distinguish the two,
because a jitter moves the sensor more in stretched poses than in folded ones and also turns the scanned lines, whereas a bias only shifts the lines.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.optimize import minimize_scalar
from scipy.stats import chi2

from scalar.diagnosis.background import Background
from scalar.estimation.model import Model
from scalar.estimation.residuals import Residuals
from scalar.geometry.se3 import Array
from scalar.sensors import Measurement, NoiseComponent, Rows, Target


@dataclass(frozen=True, eq=False)
class VarianceComponent:
    """A random error that is common to all rows of a pose.

    Attributes:
        name: ``pose_jitter`` or ``scan_bias``.
        std: Standard deviation of each joint angle [rad], or of the error that is common to a scan [m].
        std_error: Standard error of ``std``, in the same unit.
        log_likelihood_gain: Log likelihood with the component less that with the noise within scans alone [nats].
        p_value: Probability of at least so large a gain if there is no such component.
        covariance: ``(N, m, m)``, covariance of each pose's whitened rows, the noise within scans included.
    """

    name: str
    std: float
    std_error: float
    log_likelihood_gain: float
    p_value: float
    covariance: Array

    def as_noise(self) -> NoiseComponent:
        """Return the component in the form in which calibration files list it."""
        unit = "rad" if self.name == "pose_jitter" else "m"
        return NoiseComponent(self.name, {}, self.std, self.std_error, unit, "")


def variance_components(
    background: Background, residuals: Residuals, model: Model, alpha: float
) -> list[VarianceComponent]:
    """Return the significant variance components, the likeliest first; none if the noise within scans explains the residual.

    Args:
        background: The residual and what the model explains, whitened for the noise within scans alone.
        residuals: The residuals of the dataset.
        model: The fitted model.
        alpha: Significance level of each component.
    """
    rows = background.residual
    # The fit absorbs a share of the variance; without this factor the estimate would be too small by that share.
    rows = rows * np.sqrt(background.n_live / background.degrees_of_freedom)
    found = []
    for name, D in directions(residuals, model):
        K = D @ np.swapaxes(D, 1, 2)
        gain, v, v_std_error = _maximum_likelihood(rows, K)
        # Half of a chi-squared distribution, because a variance cannot be negative (Self and Liang, JASA 82, 1987).
        p = float(0.5 * chi2.sf(2 * gain, 1)) if gain > 0 else 1.0
        if p < alpha and v > 0:
            std = float(np.sqrt(v))
            found.append(
                VarianceComponent(
                    name, std, float(v_std_error / (2 * std)), gain, p, np.eye(rows.shape[1]) + v * K
                )
            )
    return sorted(found, key=lambda s: -s.log_likelihood_gain)


def directions(residuals: Residuals, model: Model) -> list[tuple[str, Array]]:
    """Return the name of each component and the derivatives ``(N, m, k)`` of the whitened rows by the k errors of which it consists.

    Those of ``pose_jitter`` are errors of the angles of all revolute joints [1/rad]; it is absent if there are none. Those of ``scan_bias`` are
    errors that are common to all points of a pose [1/m].
    """
    kinematics = residuals.kinematics(model)
    revolute = (
        ~model.robot.slides
    )  # a slide's position is in metres, and its repeatability differs from that of a gear
    by_angle = kinematics.screws()[:, :, model.robot.joint_columns][:, :, revolute]
    rows = residuals.measurement.rows(kinematics.T_base_sensor, model.target)
    jitter = rows.wrench @ by_angle
    bias = residuals.measurement.common_error(kinematics.T_base_sensor, model.target)
    return [*([("pose_jitter", jitter)] if revolute.any() else []), ("scan_bias", bias)]


def columns_by_place(residuals: Residuals, model: Model) -> list[tuple[str, Array]]:
    """Return the name of each coordinate of a place that may err, and the derivatives ``(N, m)`` of the whitened rows by it.

    Names are ``q4`` (a joint), ``sensor.0`` (a coordinate of the sensor on the flange) and ``base.5`` (a component of the base's rigid motion).
    Coordinates that change no row are left out.
    """
    kinematics = residuals.kinematics(model)
    by_joint = kinematics.screws()[:, :, model.robot.joint_columns]
    wrench = residuals.measurement.rows(kinematics.T_base_sensor, model.target).wrench
    N, m, _ = wrench.shape
    sensor = residuals.linearise_measured(model)[1][:, model.blocks["sensor"]].reshape(N, m, -1)
    found = [(f"q{j + 1}", column) for j, column in enumerate(np.moveaxis(wrench @ by_joint, 2, 0))]
    found += [(f"sensor.{k}", column) for k, column in enumerate(np.moveaxis(sensor, 2, 0))]
    found += [(f"base.{k}", column) for k, column in enumerate(np.moveaxis(wrench, 2, 0))]
    return [(place, column) for place, column in found if column.any()]


def _maximum_likelihood(rows: Array, K: Array) -> tuple[float, float, float]:
    """Return the gain of log likelihood over v = 0 [nats], the variance v of greatest likelihood, and the standard error of v.

    Args:
        rows: ``(N, m)``, residual, whitened for the noise within scans.
        K: ``(N, m, m)``, what a component of unit variance adds to the covariance of each pose's rows.
    """
    values, vectors = np.linalg.eigh(K)
    values = np.maximum(values, 0.0)
    squares = np.einsum("nij,ni->nj", vectors, rows) ** 2
    # The variance at which the component is as large as the noise; v is sought from exp(-16) to exp(24) times it.
    typical = 1.0 / max(float(np.median(values[:, -1])), 1e-300)

    def cost(log_v: float) -> float:
        """Return minus the log likelihood, less a constant."""
        variance = 1.0 + np.exp(log_v) * values
        return 0.5 * float(np.sum(np.log(variance) + squares / variance))

    start = np.log(typical)
    result: Any = minimize_scalar(
        cost, bounds=(start - 16, start + 24), method="bounded", options={"xatol": 1e-4}
    )
    v = float(np.exp(result.x))
    variance = 1.0 + v * values
    information = 0.5 * float(np.sum((values / variance) ** 2))
    return 0.5 * float(np.sum(squares)) - float(result.fun), v, 1.0 / np.sqrt(max(information, 1e-300))


@dataclass(frozen=True, eq=False)
class WhitenedMeasurement(Measurement):
    """A measurement whose rows are whitened for noise common to a pose.

    Attributes:
        inner: The measurement whose rows are whitened.
        whitening: ``(N, m, m)``, inverse square roots of the covariances of its rows.
        component: The variance component for which they are whitened.
    """

    inner: Any
    whitening: Array
    component: NoiseComponent

    def __getattr__(self, name: str) -> Any:
        """Return an attribute of the inner measurement that this class does not define."""
        return getattr(self.inner, name)

    @property
    def target_index(self) -> Array:  # type: ignore[override]
        """Return the index of the item of the target (a plane, for example) that each pose measures, ``(N,)``."""
        return self.inner.target_index

    @property
    def sigma(self) -> float:  # type: ignore[override]
        """Return the standard deviation within scans."""
        return self.inner.sigma

    @property
    def noise_components(self) -> tuple[NoiseComponent, ...]:
        """Return the components of the inner measurement, and the one for which its rows are whitened here."""
        return (*self.inner.noise_components, self.component)

    @property
    def estimated_noise(self) -> tuple[NoiseComponent, ...]:
        """Return the estimated noise of the inner measurement."""
        return self.inner.estimated_noise

    @property
    def ratio_to_stated(self) -> float | None:
        """Return that of the inner measurement."""
        return self.inner.ratio_to_stated

    @property
    def rows_per_pose(self) -> int:  # type: ignore[override]
        """Return the number of rows of each pose."""
        return self.inner.rows_per_pose

    @classmethod
    def of(cls, dataset: Any) -> Measurement:
        """Refuse: a whitened measurement is made from another measurement."""
        raise NotImplementedError

    @classmethod
    def target_to_mapping(cls, target: Target, std: Any) -> dict[str, Any]:
        """Refuse: the kind of the inner measurement saves the target."""
        raise NotImplementedError

    @classmethod
    def target_from_mapping(cls, mapping: Any) -> Target:
        """Refuse: the kind of the inner measurement loads the target."""
        raise NotImplementedError

    @property
    def sigma_known(self) -> bool:
        """Return whether the noise within scans is stated; the variance component is estimated separately and not by the fit."""
        return self.inner.sigma_stated

    def initial_target(self, dataset: Any) -> Target:
        """Return the initial target of the inner measurement."""
        return self.inner.initial_target(dataset)

    def fitted_target(self, T_base_sensor: Array, target: Target) -> Target:
        """Return the fitted target of the inner measurement."""
        return self.inner.fitted_target(T_base_sensor, target)

    def rows(self, T_base_sensor: Array, target: Target, point_effects: Sequence[Any] = ()) -> Rows:
        """Return the inner rows, whitened."""
        rows = self.inner.rows(T_base_sensor, target, point_effects)
        residual = np.einsum("nij,nj->ni", self.whitening, rows.residual)
        return Rows(
            residual, self.whitening @ rows.wrench, self.whitening @ rows.target, self.whitening @ rows.extra
        )

    def reweighted(self, T_base_sensor: Array, target: Target) -> Measurement:
        """Return the inner measurement reweighted, whitened as before."""
        return replace(self, inner=self.inner.reweighted(T_base_sensor, target))

    def distances(
        self, T_base_sensor: Array, target: Target, point_effects: Sequence[Any] = ()
    ) -> tuple[Array, Array]:
        """Return the inner distances."""
        return self.inner.distances(T_base_sensor, target, point_effects)

    def perfect_rows(self, T_base_sensor: Array, target: Target, index: Array) -> tuple[Array, Array, Array]:
        """Return the perfect rows of the inner measurement, which are not whitened here."""
        return self.inner.perfect_rows(T_base_sensor, target, index)


def whitening_for(component: VarianceComponent) -> Array:
    """Return the symmetric inverse square roots ``(N, m, m)`` of the covariances of the poses' rows with a variance component."""
    values, vectors = np.linalg.eigh(component.covariance)
    return (vectors / np.sqrt(values)[:, None, :]) @ np.swapaxes(vectors, 1, 2)
