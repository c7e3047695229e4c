"""The rows to which a dataset is compressed; all refits share them.

Effects on points need functions of the points (of the range, for example), which compression has to keep. The dataset is compressed once for each set
of such functions. The rows are weighted for the noise within poses as far as it is known, so that tests and standard errors agree with it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeVar

import numpy as np

from scalar.data.dataset import Dataset
from scalar.diagnosis.fit.lately_fitted import LatelyFitted
from scalar.estimation.model import Model
from scalar.estimation.residuals import Residuals
from scalar.estimation.settings import WithinScanNoiseSettings
from scalar.geometry.se3 import Array
from scalar.sensors import Measurement, PoseNoise, measure

_Result = TypeVar("_Result")
# Relative change of an estimated noise that is smaller than its standard error with a hundred measurements.
_NEGLIGIBLE_CHANGE = 0.1


class MeasuredRows:
    """The rows of a dataset, compressed when they are first used.

    Attributes:
        noise: The noise within its poses; None if it is white and the same for all points.
        fitted: The states that were fitted to the rows last.
    """

    def __init__(
        self, dataset: Dataset, noise: PoseNoise | None = None, like: Measurement | None = None
    ) -> None:
        """Compress nothing yet.

        Args:
            dataset: Must not change afterwards.
            noise: The noise within its poses; None if it is white and the same for all points.
            like: A measurement of the same dataset, whose weights the rows take over; None for the usual weights.
        """
        self._dataset = dataset
        self._like = like
        self.noise = noise
        self._known: dict[tuple[str, ...], Measurement] = {}
        self._derivatives: Array | None = None
        self._results: dict[tuple[Any, ...], Any] = {}
        self.fitted: LatelyFitted[Any] = LatelyFitted()

    def once(self, key: tuple[Any, ...], compute: Callable[[], _Result]) -> _Result:
        """Return a result that all models of these rows share; it is computed when first asked for.

        Args:
            key: The name of the result and what it depends on besides the dataset.
            compute: Computes it.
        """
        if key not in self._results:
            self._results[key] = compute()
        return self._results[key]

    def with_functions(self, extra_basis: Sequence[str]) -> Measurement:
        """Return the measurement with the functions ``extra_basis`` of a point kept by the compression (``scalar.sensors.measure``)."""
        names = tuple(extra_basis)
        if names not in self._known:
            rows = measure(self._dataset, names).given_noise(self.noise)
            self._known[names] = rows if self._like is None else rows.weighted_like(self._like)
        return self._known[names]

    def derivatives_by_joint(self, residuals: Residuals, model: Model) -> Array:
        """Return the size of the derivative of the rows by each joint ``(n,)``, root mean square over the poses, as a share of the largest.

        It is computed once, for the first model, so that the same poses are held out from all models of one selection.

        Args:
            residuals: The residuals of the same dataset.
            model: The model near its optimum.
        """
        known = self._derivatives
        if known is None:
            jacobian = residuals.linearise_measured(model)[1]
            by_joint = jacobian[:, model.blocks["geometry"]][:, model.robot.joint_columns]
            sizes = np.linalg.norm(by_joint, axis=0)
            known = self._derivatives = sizes / max(float(sizes.max()), 1e-300)
        return known

    def reweighted(self, residuals: Residuals, model: Model) -> MeasuredRows | None:
        """Return the rows with weights estimated anew from the residual of a model; None if no weight is estimated, or none changes noticeably.

        Args:
            residuals: The residuals of the same dataset.
            model: The model at its optimum.
        """
        if (
            self._like is None or self._like.scans
        ):  # the noise of scans is estimated from their own points, whatever the model
            return None
        T_base_sensor = residuals.kinematics(model).T_base_sensor
        coefficients = sum(len(effect.coefficients) for effect in model.effects)
        like = measure(self._dataset).counting(coefficients).reweighted(T_base_sensor, model.target)
        old, new = ({n.name: n.value for n in m.estimated_noise} for m in (self._like, like))
        if old.keys() == new.keys() and all(
            abs(new[name] / old[name] - 1.0) < _NEGLIGIBLE_CHANGE for name in new
        ):
            return None
        return MeasuredRows(self._dataset, self.noise, like)


def rows_given_own_noise(dataset: Dataset, model: Model, settings: WithinScanNoiseSettings) -> MeasuredRows:
    """Return the rows of a dataset, weighted for the noise within poses that is estimated from the points themselves.

    Args:
        dataset: Without gross errors.
        model: The model near its optimum; the distances of a scan's points from their own line hardly depend on it.
        settings: Thresholds.
    """
    residuals = Residuals.of(dataset, model).reweighted(model)
    T_base_sensor = residuals.kinematics(model).T_base_sensor
    return MeasuredRows(
        dataset,
        residuals.measurement.noise_within_poses(T_base_sensor, model.target, settings),
        residuals.measurement,
    )


def profile_measurement(measurement: Measurement, model: Model, residuals: Residuals) -> Measurement:
    """Return a dataset's profile rows (a few numbers for each scan), whitened for the sensor poses of a model.

    Args:
        measurement: The compressed dataset.
        model: Gives the pose of the sensor at every pose of the arm.
        residuals: The residuals of the same dataset; they have the standard deviation of the noise within scans.
    """
    T = residuals.kinematics(model).T_base_sensor
    return measurement.profiles(T, model.target, residuals.measurement.sigma)
