"""How wrong an arm is all over its workspace: by its data sheet, and by a calibration, with the band that the covariance leaves.

At random poses within the joint limits, the position of the sensor's origin by a model is compared with that by the calibration:
``e = p_model - p_hat + D z``, where the columns of D are deviations of one standard deviation of the calibration and z is standard
normal. The place of the base and the place of the sensor on the flange are set once in every workcell, by measuring, so the motion
of the base and the shift of the sensor that fit best are removed from both terms. What is left is what no such setting mends.

The band is that of chance errors of the measurements. Of what the model lacks it knows only a distance, where one is given, by which the arm
is off at every pose.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from scalar.data.poses import Poses
from scalar.estimation.anywhere import limits_or_seen, poses_within_limits
from scalar.estimation.displacement import base_and_sensor, kinematics_at, without
from scalar.estimation.model import Model
from scalar.estimation.prediction_covariance import pose_deviations
from scalar.estimation.result import Calibration
from scalar.evaluate.pose_errors import best_rigid_motion
from scalar.geometry.se3 import Array

N_DRAWS = 200
NOMINAL = "data sheet"
"""The name of the arm as its maker describes it."""
_SEED = 20240
_MOST_POSES, _LEAST_POSES = 4000, 1000
# Of poses by parameters, 48 bytes each: there are fewer poses where a model has very many parameters.
_MOST_DERIVATIVES = 1_000_000
_ALIGNMENTS = (
    3  # steps of Gauss and Newton; each divides what is left by the size of the errors over that of the arm
)
_RANK_TOLERANCE = (
    1e-9  # of the largest singular value: an arm may have no base or sensor to set apart from another
)
BAND = (0.025, 0.975)
"""Quantiles that enclose the 95 % band."""


@dataclass(frozen=True, eq=False)
class WorkspaceErrors:
    """Position errors at random poses.

    Attributes:
        position: ``(N, 3)`` [m], of the sensor's origin in the base frame, as calibrated.
        errors: ``{state: (N, 3)}`` [m], the estimated error of each model.
        deviations: ``(N, 3, K)`` [m], independent deviations of that estimate, of one standard deviation each.
        lacking: Root mean square distance [m] by which the arm is off at every pose for what no model here holds.
    """

    position: Array
    errors: Mapping[str, Array]
    deviations: Array
    lacking: float = 0.0

    @cached_property
    def _chance(self) -> Array:
        """Draws ``(R, N, 3)`` [m] of the error of the estimate."""
        draws = np.random.default_rng(_SEED).standard_normal((N_DRAWS, self.deviations.shape[2]))
        return np.einsum("nik,rk->rni", self.deviations, draws, optimize=True)

    def sizes(self, state: str) -> Array:
        """Return draws ``(R, N)`` [m] of the size of the error of a model at every pose, as the covariance leaves it open."""
        return np.hypot(np.linalg.norm(self.errors[state] + self._chance, axis=2), self.lacking)


@dataclass(frozen=True)
class Banded:
    """A number with its 95 % band.

    Attributes:
        value, low, high: The median of the draws and the ends of the band.
    """

    value: float
    low: float
    high: float

    @classmethod
    def of(cls, draws: Array) -> Banded:
        """Return the number of which these are draws ``(R,)``."""
        low, value, high = np.quantile(draws, [BAND[0], 0.5, BAND[1]])
        return cls(float(value), float(low), float(high))


def errors_within_limits(
    estimate: Calibration, models: Mapping[str, Model], seen: Poses, lacking: float = 0.0
) -> WorkspaceErrors | None:
    """Return the position errors of the data sheet and of models at random poses within the joint limits; None without covariance.

    Args:
        estimate: The best calibration of the arm, with its covariance.
        models: The models that are judged in addition to the data sheet, by name.
        seen: The measured poses: ranges of joints without limits, and other columns, are theirs.
        lacking: As in ``WorkspaceErrors``.
    """
    robot = estimate.model.nominal
    count = int(np.clip(_MOST_DERIVATIVES // len(estimate.model.names), _LEAST_POSES, _MOST_POSES))
    anywhere = poses_within_limits(limits_or_seen(robot.limits, seen.q), seen, count, _SEED)
    nominal = replace(estimate.model, robot=robot, effects=())
    return workspace_errors(estimate, {NOMINAL: nominal, **models}, anywhere, lacking)


def workspace_errors(
    calibration: Calibration, models: Mapping[str, Model], poses: Poses, lacking: float = 0.0
) -> WorkspaceErrors | None:
    """Return the position errors of models, the calibration being the best estimate of the arm; None if it has no covariance.

    Args:
        calibration: The estimate, with its covariance.
        models: What is judged, by name.
        poses: Where.
        lacking: As in ``WorkspaceErrors``.
    """
    estimate = kinematics_at(calibration.model, poses)
    found = pose_deviations(calibration.model, estimate, calibration.free, calibration.covariance)
    if found is None:
        return None
    T = estimate.T_base_sensor
    deviations = without(base_and_sensor(T), found[:, :3].reshape(3 * len(T), -1), _RANK_TOLERANCE).reshape(
        len(T), 3, -1
    )
    errors = {
        name: aligned_errors(kinematics_at(model, poses).T_base_sensor, T) for name, model in models.items()
    }
    return WorkspaceErrors(T[:, :3, 3], errors, deviations, lacking)


def aligned_errors(T_model: Array, T_hat: Array) -> Array:
    """Return ``(N, 3)`` [m]: positions by a model less those estimated, after the best motion of the base and shift of the sensor."""
    T = np.array(T_model)
    for _ in range(_ALIGNMENTS):
        T = best_rigid_motion(T[:, :3, 3], T_hat[:, :3, 3]) @ T
        error = T[:, :3, 3] - T_hat[:, :3, 3]
        shift = np.linalg.lstsq(base_and_sensor(T), error.ravel(), rcond=_RANK_TOLERANCE)[0][6:]
        T[:, :3, 3] -= T[:, :3, :3] @ shift
    return (best_rigid_motion(T[:, :3, 3], T_hat[:, :3, 3]) @ T)[:, :3, 3] - T_hat[:, :3, 3]
