"""Position errors of an arm over its whole workspace, by its data sheet and by other models, with 95 % bands from the covariance.

At random poses within the joint limits, the position of the sensor's origin by a model is compared with that by the calibration:
``e = p_model - p_hat + D z``, where the columns of D are independent deviations of ``p_hat``, of one standard deviation each, and z is
standard normal. Every workcell measures the place of its base and of the sensor on the flange anew, so the motion of the base and the
shift of the sensor that fit best are removed from both terms. The remaining errors are those that no such measurement corrects. Where the calibration
is used in the workcell in which it was measured, the shift of the sensor is known and stays in (``sensor_fitted``).

The band covers the random errors of the measurements, the error of the scale where no length is known (``unknown_scale``), and effects that the model
may lack, each as often as it is probable (``possible``). Its upper end allows besides for effects that every arm has, at the size that the
measurements leave open (``hidden``), and for a residual beyond the noise, as a normal shift of every pose, independent of the others, whose root mean
square is ``excess``. The latter may as well be noise that is larger than stated, which is no error of the arm: the number does not count it, and the
upper end does.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from scalar.data.poses import Poses
from scalar.estimation.displacement import base_and_sensor_columns, kinematics_at, projected_out
from scalar.estimation.model import Model
from scalar.estimation.prediction_covariance import pose_deviations
from scalar.estimation.random_poses import limits_or_measured_ranges, poses_within_limits
from scalar.estimation.result import Calibration
from scalar.estimation.unknown_scale import unknown_scale
from scalar.evaluate.model_discrepancy import NOTHING_LACKS, ModelDiscrepancy
from scalar.evaluate.pose_errors import best_rigid_motion
from scalar.geometry.se3 import Array

N_DRAWS = 200
NOMINAL = "data sheet"
"""The name of the arm as its maker describes it."""
_SEED = 20240
_MOST_POSES, _LEAST_POSES = 4000, 1000
# Poses times parameters, 48 bytes each: a model with very many parameters is evaluated at fewer poses.
_MOST_DERIVATIVES = 1_000_000
# Gauss-Newton steps. Each multiplies the distance from the best alignment by about the size of the errors over that of the arm.
_ALIGNMENTS = 3
# Of the largest singular value. With few joints, a motion of the base and a shift of the sensor can be the same displacement.
_RANK_TOLERANCE = 1e-9
MEAN_OVER_RMS = float(np.sqrt(8.0 / (3.0 * np.pi)))
"""Mean size of a normal shift with the same variance along each axis over its root mean square."""
BAND = (0.025, 0.975)
"""Quantiles that enclose the 95 % band."""


@dataclass(frozen=True, eq=False)
class WorkspaceErrors:
    """Position errors at random poses.

    Attributes:
        position: ``(N, 3)`` [m], the sensor's origin in the base frame, by the calibration.
        errors: ``{name of the model: (N, 3)}`` [m], the estimated error of each model in the base frame.
        deviations: ``(N, 3, K)`` [m], K independent deviations of these estimates, of one standard deviation each.
        excess: Root mean square distance [m] by which poses are off because of errors that the calibration's model lacks.
        hidden: ``(N, 3, L)`` [m], deviations like the others by effects that the model lacks and the measurements do not show.
        possible: ``(R, N, 3)`` [m], draws of what effects that the model may lack contribute, or nothing ``()``.
    """

    position: Array
    errors: Mapping[str, Array]
    deviations: Array
    excess: float = 0.0
    hidden: Array | None = None
    possible: Array = field(default_factory=lambda: np.zeros(()))

    @cached_property
    def _chance(self) -> Array:
        """Return R draws of the error of the estimate ``(R, N, 3)`` [m]."""
        return _drawn(self.deviations, _SEED) + self.possible

    @cached_property
    def _chance_and_hidden(self) -> Array:
        """Return R draws of the error of the estimate with what only the upper end of a band allows for ``(R, N, 3)`` [m]."""
        hidden = np.zeros(()) if self.hidden is None else _drawn(self.hidden, _SEED + 1)
        return self._chance + hidden + self._lacking

    @cached_property
    def _lacking(self) -> Array:
        """Return R draws ``(R, N, 3)`` [m] of what the model lacks, and of nothing ``()`` if it is not known to lack anything."""
        if not self.excess:
            return np.zeros(())
        rng = np.random.default_rng(_SEED + 2)
        return self.excess / np.sqrt(3.0) * rng.standard_normal((N_DRAWS, *self.position.shape))

    @cached_property
    def all_sizes(self) -> dict[str, Sizes]:
        """Return draws of the size of the error of each model at every pose, by its name."""
        return {model: self.sizes(model) for model in self.errors}

    def sizes(self, model: str) -> Sizes:
        """Return draws of the size of a model's error at every pose."""
        error = self.errors[model]
        found, more = (
            np.linalg.norm(error + chance, axis=2) for chance in (self._chance, self._chance_and_hidden)
        )
        return Sizes(found, more)


def rms_over_poses(draws: Array) -> Array:
    """Return the root mean square size ``(R,)`` [m] over the poses of each draw ``(R, N)``."""
    return np.sqrt(np.mean(draws * draws, axis=1))


def mean_over_poses(draws: Array) -> Array:
    """Return the mean size ``(R,)`` [m] over the poses of each draw ``(R, N)``."""
    return draws.mean(axis=1)


def _drawn(deviations: Array, seed: int) -> Array:
    """Return R sums of independent deviations ``(N, 3, K)`` [m], each times a standard normal number: ``(R, N, 3)`` [m]."""
    draws = np.random.default_rng(seed).standard_normal((N_DRAWS, deviations.shape[2]))
    return np.einsum("nik,rk->rni", deviations, draws, optimize=True)


@dataclass(frozen=True, eq=False)
class Sizes:
    """R draws of the size of an error at N poses.

    Attributes:
        found: ``(R, N)`` [m], they vary as the covariance of the calibration and the effects that its model may lack say.
        with_hidden: ``(R, N)`` [m], the same with what only the upper end of a band allows for.
    """

    found: Array
    with_hidden: Array

    def banded(self, statistic: Callable[[Array], Array]) -> Banded:
        """Return a number with its band.

        Args:
            statistic: Returns the number ``(R,)`` of each draw, from draws ``(R, N)``.
        """
        return self.each_banded(lambda draws: statistic(draws)[:, None])[0]

    def each_banded(self, statistic: Callable[[Array], Array]) -> list[Banded]:
        """Return C numbers with their bands.

        Args:
            statistic: Returns the numbers ``(R, C)`` of each draw, from draws ``(R, N)``.
        """
        found, with_hidden = (statistic(draws).T for draws in (self.found, self.with_hidden))
        return [
            replace(band, high=max(band.high, Banded.of(draws).high))
            for band, draws in zip(map(Banded.of, found), with_hidden, strict=True)
        ]


@dataclass(frozen=True)
class Banded:
    """A number with its 95 % band, in the unit of the draws [m].

    Attributes:
        value: The median of the draws.
        low, high: The ends of the band.
    """

    value: float
    low: float
    high: float

    @classmethod
    def of(cls, draws: Array) -> Banded:
        """Return median and band of draws ``(R,)``."""
        low, value, high = np.quantile(draws, [BAND[0], 0.5, BAND[1]])
        return cls(float(value), float(low), float(high))


def errors_within_limits(
    estimate: Calibration,
    models: Mapping[str, Model],
    measured_poses: Poses,
    discrepancy: ModelDiscrepancy = NOTHING_LACKS,
) -> WorkspaceErrors | None:
    """Return the position errors of the data sheet and of models at random poses within the joint limits.

    None is returned where ``estimate`` has no covariance.

    Args:
        estimate: The best calibration of the arm, with its covariance.
        models: The models that are judged in addition to the data sheet, by name.
        measured_poses: The poses with what was recorded of them. A joint without limits keeps to the range that it has in them; other columns, such
            as the temperature, take values from them.
        discrepancy: What the model of ``estimate`` may lack.
    """
    robot = estimate.model.nominal
    count = int(np.clip(_MOST_DERIVATIVES // len(estimate.model.names), _LEAST_POSES, _MOST_POSES))
    poses = poses_within_limits(
        limits_or_measured_ranges(robot.limits, measured_poses.q), measured_poses, count, _SEED
    )
    nominal = replace(estimate.model, robot=robot, effects=())
    return workspace_errors(estimate, {NOMINAL: nominal, **models}, poses, discrepancy)


def workspace_errors(
    calibration: Calibration,
    models: Mapping[str, Model],
    poses: Poses,
    discrepancy: ModelDiscrepancy = NOTHING_LACKS,
    *,
    sensor_fitted: bool = True,
) -> WorkspaceErrors | None:
    """Return the position errors of models against a calibration as the best estimate of the arm; None if it has no covariance.

    Args:
        calibration: The estimate, with its covariance.
        models: The models to judge, by name.
        poses: The poses at which they are compared.
        discrepancy: What the model of ``calibration`` may lack.
        sensor_fitted: Whether the shift of the sensor that fits best is removed besides the motion of the base; the errors of ``models`` are always
            those with both.
    """
    estimate = kinematics_at(calibration.model, poses)
    of_poses = pose_deviations(calibration.model, estimate, calibration.free, calibration.covariance)
    if of_poses is None:
        return None
    T = estimate.T_base_sensor
    of_positions = of_poses[:, :3].reshape(3 * len(T), -1)
    if (scale := unknown_scale(calibration)) is not None:
        stretched = scale.relative * (T[:, :3, 3] - calibration.model.nominal.T_base_0[:3, 3])
        of_positions = np.column_stack([of_positions, stretched.ravel()])
    moved_alike = base_and_sensor_columns(T)[:, : 9 if sensor_fitted else 6]

    def apart(columns: Array) -> Array:
        """Return displacements ``(N, 3, K)`` less what the place of the base, or of the sensor, takes up of each."""
        return projected_out(moved_alike, columns, _RANK_TOLERANCE).reshape(len(T), 3, -1)

    errors = {
        name: aligned_errors(kinematics_at(model, poses).T_base_sensor, T) for name, model in models.items()
    }
    hidden, possible = discrepancy.hidden, discrepancy.possible
    return WorkspaceErrors(
        T[:, :3, 3],
        errors,
        apart(of_positions),
        discrepancy.excess,
        None if hidden is None else apart(hidden(poses)),
        np.zeros(()) if possible is None else np.moveaxis(apart(possible(poses, N_DRAWS, _SEED + 3)), 2, 0),
    )


def aligned_errors(T_model: Array, T_hat: Array) -> Array:
    """Return the positions by a model less the estimated ones ``(N, 3)`` [m], after the best motion of the base and shift of the sensor.

    Args:
        T_model: ``(N, 4, 4)``, the sensor in the base frame by the model.
        T_hat: ``(N, 4, 4)``, the same by the estimate.
    """
    T = np.array(T_model)
    for _ in range(_ALIGNMENTS):
        T = best_rigid_motion(T[:, :3, 3], T_hat[:, :3, 3]) @ T
        error = T[:, :3, 3] - T_hat[:, :3, 3]
        shift = np.linalg.lstsq(base_and_sensor_columns(T), error.ravel(), rcond=_RANK_TOLERANCE)[0][6:]
        T[:, :3, 3] -= T[:, :3, :3] @ shift
    return (best_rigid_motion(T[:, :3, 3], T_hat[:, :3, 3]) @ T)[:, :3, 3] - T_hat[:, :3, 3]
