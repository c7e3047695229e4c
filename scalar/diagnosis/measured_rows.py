"""The rows to which a dataset is compressed, once for each set of functions of the points that effects need; all refits share them.

The rows carry what is known of the noise within poses, so that weights, tests and standard errors follow it.
"""

from __future__ import annotations

from collections.abc import Sequence

from scalar.data.dataset import Dataset
from scalar.estimation.model import Model
from scalar.estimation.residuals import Residuals
from scalar.estimation.settings import WithinScanNoiseSettings
from scalar.sensors import Measurement, PoseNoise, measure


class MeasuredRows:
    """The rows of a dataset, compressed when they are first used."""

    def __init__(self, dataset: Dataset, noise: PoseNoise | None = None) -> None:
        """Take the dataset, which must not change, and the noise within its poses where it is not white and of one size."""
        self._dataset = dataset
        self.noise = noise
        self._known: dict[tuple[str, ...], Measurement] = {}

    def keeping(self, extra_basis: Sequence[str]) -> Measurement:
        """Return the rows with some functions of a point kept, as ``scalar.sensors.measure`` gives them."""
        names = tuple(extra_basis)
        if names not in self._known:
            self._known[names] = measure(self._dataset, names).given_noise(self.noise)
        return self._known[names]


def rows_given_own_noise(dataset: Dataset, model: Model, settings: WithinScanNoiseSettings) -> MeasuredRows:
    """Return the rows of a dataset with the noise that its own points show within poses.

    Args:
        dataset: Cleaned.
        model: Near the optimum; a pose's points about their own line do not depend on it.
        settings: Thresholds.
    """
    residuals = Residuals.of(dataset, model).reweighted(model)
    T_base_sensor = residuals.kinematics(model).T_base_sensor
    return MeasuredRows(
        dataset, residuals.measurement.noise_within_poses(T_base_sensor, model.target, settings)
    )
