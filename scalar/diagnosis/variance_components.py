"""Variance components of whole poses: joints that do not repeat exactly, and scans with an error of their own.

They shift no mean and show in the covariance. Each adds ``v K_i`` to the unit covariance of a pose's whitened rows: ``K = D D'`` with D the rows'
derivatives by the joint angles for a jitter, by an error common to the scan for a bias. v is found by maximum likelihood. The likelihoods distinguish
the two: a jitter moves stretched poses more than near ones and also turns the scanned lines, whereas a bias only shifts them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.optimize import minimize_scalar
from scipy.stats import chi2

from scalar.diagnosis.score_test import Background
from scalar.estimation.model import Model
from scalar.estimation.residuals import Residuals
from scalar.geometry.se3 import Array
from scalar.sensors import Measurement, NoiseComponent, Rows, Target


@dataclass(frozen=True, eq=False)
class VarianceComponent:
    """A random error that is common to all rows of a pose.

    Attributes:
        name: ``pose_jitter`` or ``scan_bias``.
        std: Of the joints [rad], or of a scan's common error [m].
        std_error: Standard error of std.
        log_likelihood_gain: Over the noise within scans alone.
        p_value: Of the likelihood ratio.
        covariance: ``(N, m, m)``, of each pose's whitened rows.
    """

    name: str
    std: float
    std_error: float
    log_likelihood_gain: float
    p_value: float
    covariance: Array

    def as_noise(self) -> NoiseComponent:
        """Return the component as calibration files list it."""
        unit = "rad" if self.name == "pose_jitter" else "m"
        return NoiseComponent(self.name, {}, self.std, self.std_error, unit, "")


def variance_components(
    background: Background, residuals: Residuals, model: Model, alpha: float
) -> list[VarianceComponent]:
    """Return the significant variance components, the likeliest first; none if the noise within scans explains the residual.

    Args:
        background: Of the model's rows, whitened for the noise within scans alone.
        residuals: Of the dataset.
        model: At the optimum.
        alpha: Significance level of each component.
    """
    rows = background.residual
    # The fit absorbs a share of the variance; without this factor the estimate would be too small by that share.
    live = background.freedom + background.Q.shape[1]
    rows = rows * np.sqrt(live / background.freedom)
    found = []
    for name, D in directions(residuals, model):
        K = D @ np.swapaxes(D, 1, 2)
        gain, v, curvature = _maximum_likelihood(rows, K)
        p = float(0.5 * chi2.sf(2 * gain, 1)) if gain > 0 else 1.0
        if p < alpha and v > 0:
            std = float(np.sqrt(v))
            found.append(
                VarianceComponent(
                    name, std, float(curvature / (2 * std)), gain, p, np.eye(rows.shape[1]) + v * K
                )
            )
    return sorted(found, key=lambda s: -s.log_likelihood_gain)


def directions(residuals: Residuals, model: Model) -> list[tuple[str, Array]]:
    """Return the rows' derivatives ``(N, m, k)`` by every joint angle, and by an error common to the pose's measurement."""
    kinematics = residuals.kinematics(model)
    turning = ~model.robot.slides  # a travel has another unit, and a slide repeats otherwise than a gear
    by_angle = kinematics.screws()[:, :, model.robot.by_joint][:, :, turning]
    rows = residuals.measurement.rows(kinematics.T_base_sensor, model.target)
    jitter = rows.wrench @ by_angle
    bias = residuals.measurement.common_error(kinematics.T_base_sensor, model.target)
    return [*([("pose_jitter", jitter)] if turning.any() else []), ("scan_bias", bias)]


def columns_by_place(residuals: Residuals, model: Model) -> list[tuple[str, Array]]:
    """Return the rows' derivatives ``(N, m)`` by what may err at one place: ``q4``, ``sensor.0`` or ``base.5``; none that move no row."""
    kinematics = residuals.kinematics(model)
    by_angle = kinematics.screws()[:, :, model.robot.by_joint]
    rows = residuals.measurement.rows(kinematics.T_base_sensor, model.target).wrench
    N, m, _ = rows.shape
    sensor = residuals.linearise_measured(model)[1][:, model.blocks["sensor"]].reshape(N, m, -1)
    found = [(f"q{j + 1}", column) for j, column in enumerate(np.moveaxis(rows @ by_angle, 2, 0))]
    found += [(f"sensor.{k}", column) for k, column in enumerate(np.moveaxis(sensor, 2, 0))]
    found += [(f"base.{k}", column) for k, column in enumerate(np.moveaxis(rows, 2, 0))]
    return [(place, column) for place, column in found if column.any()]


def _maximum_likelihood(rows: Array, K: Array) -> tuple[float, float, float]:
    """Return the gain of log likelihood over v = 0, v itself and its standard error."""
    values, vectors = np.linalg.eigh(K)
    values = np.maximum(values, 0.0)
    squares = np.einsum("nij,ni->nj", vectors, rows) ** 2
    typical = 1.0 / max(float(np.median(values[:, -1])), 1e-300)

    def cost(log_v: float) -> float:
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
        inner: The rows.
        whitening: ``(N, m, m)``, inverse square roots of the covariances.
        component: What it is whitened for.
    """

    inner: Any
    whitening: Array
    component: NoiseComponent

    def __getattr__(self, name: str) -> Any:
        """Return what the inner measurement has."""
        return getattr(self.inner, name)

    @property
    def target_index(self) -> Array:  # type: ignore[override]
        """Return which item each pose measures."""
        return self.inner.target_index

    @property
    def sigma(self) -> float:  # type: ignore[override]
        """Return the standard deviation within scans."""
        return self.inner.sigma

    @property
    def noise_components(self) -> tuple[NoiseComponent, ...]:
        """Return those of the inner measurement, and the one that it is whitened for here."""
        return (*self.inner.noise_components, self.component)

    @property
    def estimated_noise(self) -> tuple[NoiseComponent, ...]:
        """Return that of the inner measurement."""
        return self.inner.estimated_noise

    @property
    def rows_per_pose(self) -> int:  # type: ignore[override]
        """Return the rows of the inner measurement."""
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
        """Return whether the noise within scans is stated; the variance component itself is estimated apart from the fit."""
        return self.inner.sigma_stated

    def initial_target(self, dataset: Any) -> Target:
        """Return the inner measurement's."""
        return self.inner.initial_target(dataset)

    def fitted_target(self, T_base_sensor: Array, target: Target) -> Target:
        """Return the inner measurement's."""
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
        """Return the inner measurement's."""
        return self.inner.perfect_rows(T_base_sensor, target, index)


def whitening_for(component: VarianceComponent) -> Array:
    """Return the inverse square roots ``(N, m, m)`` of a variance component's covariances."""
    values, vectors = np.linalg.eigh(component.covariance)
    return (vectors / np.sqrt(values)[:, None, :]) @ np.swapaxes(vectors, 1, 2)
