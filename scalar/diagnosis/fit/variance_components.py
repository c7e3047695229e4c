"""Variance components of whole poses: joints that do not repeat exactly, and scans with an error of their own.

Such errors have zero mean, so only the covariance of the residual shows them. Each component adds ``v K_i`` to the unit covariance of the whitened
rows of pose i, where v is its variance ([rad^2] or [m^2]) and ``K_i = D_i D_i'``. For a jitter of the joints, D_i has the rows' derivatives by the
joint angles; for a bias of the scans, those by an error common to the scan. v is found by maximum likelihood. The likelihoods distinguish the two,
because a jitter moves the sensor more in stretched poses than in folded ones and also turns the scanned lines, whereas a bias only shifts the lines.

If the order of the poses is known, a jitter may have a part along the last move. An arm that is measured before it stands still, at another moment
in each pose, errs in all joints at once, in proportion to their speeds. This part adds ``w u_i u_i'``, where u_i is the rows' derivative along the
speeds.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from scalar.data.moves import speeds
from scalar.diagnosis.fit.background import Background
from scalar.diagnosis.fit.component_likelihood import Spectrum, chance_of, of_one, of_two
from scalar.effects.acquisition import ENOUGH_MOVES
from scalar.estimation.model import Model
from scalar.estimation.residuals import Residuals
from scalar.geometry.se3 import Array
from scalar.sensors import NoiseComponent

JITTER = "pose_jitter"
NO_DERIVATIVE = 1e-9  # of the largest derivative of a row: a smaller one is a rounding error, as of a turn of a sensor that measures its own origin


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
        along_move: The part of ``std`` that lies along the last move [rad], zero if none does; the squares of both parts add up.
        along_move_error: Its standard error [rad].
    """

    name: str
    std: float
    std_error: float
    log_likelihood_gain: float
    p_value: float
    covariance: Array
    along_move: float = 0.0
    along_move_error: float = 0.0

    @property
    def kernel(self) -> Array:
        """Return what the component would add to the covariance ``(N, m, m)`` of each pose's whitened rows with a standard deviation of one."""
        return (self.covariance - np.eye(self.covariance.shape[1])) / self.std**2

    @property
    def repeatability(self) -> float:
        """Return the standard deviation of each joint angle without the part along the last move."""
        return float(np.sqrt(max(self.std**2 - self.along_move**2, 0.0)))

    def as_noise(self) -> NoiseComponent:
        """Return the component in the form in which calibration files list it."""
        unit = "rad" if self.name == JITTER else "m"
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
        spectrum = Spectrum.of(K)
        gain, v, v_std_error = of_one(rows, spectrum)
        p = chance_of(gain)
        component = None
        if name == JITTER:
            component = _along_moves(rows, K, spectrum, D, _speeds(residuals, model), gain, alpha)
        if component is None and p < alpha and v > 0:
            std = float(np.sqrt(v))
            covariance = np.eye(rows.shape[1]) + v * K
            component = VarianceComponent(name, std, float(v_std_error / (2 * std)), gain, p, covariance)
        if component is not None:
            found.append(component)
    return sorted(found, key=lambda s: -s.log_likelihood_gain)


def _along_moves(
    rows: Array,
    K: Array,
    spectrum: Spectrum,
    by_angle: Array,
    speeds: Array,
    gain_without: float,
    alpha: float,
) -> VarianceComponent | None:
    """Return the jitter with a part along the last move, or None if this part is not significant.

    Args:
        rows: ``(N, m)``, residual, whitened for the noise within scans.
        K, spectrum: ``(N, m, m)``, what a jitter of unit variance adds to the covariance of each pose's rows, and its spectrum.
        by_angle: ``(N, m, k)``, derivatives of the rows by the angles of the revolute joints [1/rad].
        speeds: ``(N, k)``, their speeds as shares of the fastest joint's.
        gain_without: Log likelihood of a jitter without that part, less that of none [nats].
        alpha: Significance level.
    """
    if np.mean(speeds.any(axis=1)) < ENOUGH_MOVES:
        return None
    u = np.einsum("nmk,nk->nm", by_angle, speeds)
    both = of_two(rows, spectrum, u)
    if chance_of(both.gain - gain_without) >= alpha:
        return None
    v, w = both.variances
    weights = np.array([1.0, float(np.mean(speeds**2))])
    std, along = float(np.sqrt(weights @ both.variances)), float(np.sqrt(weights[1] * w))
    std_error = float(np.sqrt(weights @ both.covariance @ weights) / (2 * std))
    covariance = np.eye(rows.shape[1]) + v * K + w * u[:, :, None] * u[:, None, :]
    along_error = float(weights[1] * np.sqrt(both.covariance[1, 1]) / (2 * along))
    return VarianceComponent(
        JITTER, std, std_error, both.gain, chance_of(both.gain), covariance, along, along_error
    )


def _speeds(residuals: Residuals, model: Model) -> Array:
    """Return the speeds ``(N, k)`` of the k revolute joints in the last moves, as shares of the fastest one's."""
    found = speeds(residuals.poses.columns, model.robot.slides, len(residuals.poses))
    return found[:, ~model.robot.slides]


def directions(residuals: Residuals, model: Model) -> list[tuple[str, Array]]:
    """Return the name of each component and the derivatives ``(N, m, k)`` of the whitened rows by the k errors of which it consists.

    Those of ``pose_jitter`` are errors of the angles of all revolute joints [1/rad]; it is absent if there are none. Those of ``scan_bias`` are
    errors that are common to all points of a pose [1/m].
    """
    kinematics = residuals.kinematics(model)
    # A slide's position is in metres, and its repeatability differs from that of a gear.
    revolute = ~model.robot.slides
    by_angle = kinematics.screws(joint_effects=False)[:, :, model.robot.joint_columns][:, :, revolute]
    rows = residuals.measurement.rows(kinematics.T_base_sensor, model.target)
    jitter = rows.wrench @ by_angle
    bias = residuals.measurement.common_error(kinematics.T_base_sensor, model.target)
    return [*([(JITTER, jitter)] if revolute.any() else []), ("scan_bias", bias)]


def columns_by_place(residuals: Residuals, model: Model) -> list[tuple[str, Array]]:
    """Return the name of each coordinate of a place that may err, and the derivatives ``(N, m)`` of the whitened rows by it.

    Names are ``q4`` (a joint), ``sensor.0`` (a coordinate of the sensor on the flange) and ``base.5`` (a component of the base's rigid motion).
    Coordinates that change no row are left out.
    """
    kinematics = residuals.kinematics(model)
    by_joint = kinematics.screws(joint_effects=False)[:, :, model.robot.joint_columns]
    wrench = residuals.measurement.rows(kinematics.T_base_sensor, model.target).wrench
    N, m, _ = wrench.shape
    sensor = residuals.linearise_measured(model)[1][:, model.blocks["sensor"]].reshape(N, m, -1)
    found = [(f"q{j + 1}", column) for j, column in enumerate(np.moveaxis(wrench @ by_joint, 2, 0))]
    found += [(f"sensor.{k}", column) for k, column in enumerate(np.moveaxis(sensor, 2, 0))]
    found += [(f"base.{k}", column) for k, column in enumerate(np.moveaxis(wrench, 2, 0))]
    sizes = np.array([np.linalg.norm(column) for _, column in found])
    return [found[k] for k in np.flatnonzero(sizes > NO_DERIVATIVE * sizes.max())]


def whitening_for(component: VarianceComponent) -> Array:
    """Return the symmetric inverse square roots ``(N, m, m)`` of the covariances of the poses' rows with a variance component."""
    values, vectors = np.linalg.eigh(component.covariance)
    return (vectors / np.sqrt(values)[:, None, :]) @ np.swapaxes(vectors, 1, 2)
