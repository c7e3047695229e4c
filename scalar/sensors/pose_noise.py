"""The noise within the measurement of a pose: the covariance of its rows, and how it is reported.

A sensor that measures many points at each pose observes its own noise, since an error of the arm moves all points of a pose together. Other
code estimates this noise by ``Measurement.noise_within_poses`` and applies it by ``Measurement.given_noise``, without knowing the kind of
sensor.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from scalar.geometry.se3 import Array

ROTATION_NOISE = "rotation_noise"
"""Name of the component for measured orientations [rad]."""

POSITION_NOISE = "position_noise"
"""Name of the component for positions or contacts whose noise is estimated from the residual [m]."""


@dataclass(frozen=True)
class NoiseComponent:
    """A component of the sensor's own noise, as diagnosis and calibration files list it.

    Attributes:
        name: ``scan_level``, ``scan_correlation``, ``surface_waviness``, ``rotation_noise`` or ``position_noise``.
        target: What distinguishes it from others of its name; keys of lengths name their unit.
        value: Its size, or its exponent for a ``scan_level`` by range or incidence.
        std: Standard error of the value.
        unit: Of value and std.
        sentence: The same as a sentence.
    """

    name: str
    target: Mapping[str, Any]
    value: float
    std: float
    unit: str
    sentence: str

    def to_mapping(self) -> dict[str, Any]:
        """Return the entry of a file."""
        return {
            "name": self.name,
            "target": dict(self.target),
            "value": self.value,
            "std": self.std,
            "unit": self.unit,
        }


@dataclass(frozen=True, eq=False)
class Autocorrelation:
    """The autocorrelation of the errors of successive points within measurements.

    Attributes:
        measured: ``(L,)``, correlation at lags of 1 to L points.
        band: ``(L,)``, its standard error for white noise.
    """

    measured: Array
    band: Array


@dataclass(frozen=True, eq=False)
class PoseNoise:
    """The noise within the N poses of a dataset, if it is not white and of one size.

    Attributes:
        sigma: Typical standard deviation of a point [m].
        level: ``(N,)``, each pose's standard deviation in units of sigma.
        whitening: ``(N, m, m)``, inverse lower Cholesky factors of the covariance of the rows that ``profiles`` gives with this sigma.
            They are lower triangular, so that the first row (the shift of the pose) is only divided by its standard deviation.
        components: The components of the noise, as files list them.
        autocorrelation: The autocorrelation of successive points within poses.
    """

    sigma: float
    level: Array
    whitening: Array
    components: tuple[NoiseComponent, ...]
    autocorrelation: Autocorrelation
