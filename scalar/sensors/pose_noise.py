"""What is known of the noise within a pose's measurement: how its rows vary together, and how that is reported.

A kind of sensor that measures many points a pose can see its own noise, since an arm that errs moves a measurement as a whole. Whatever else
uses the noise asks the measurement for it (``Measurement.noise_within_poses``) and hands it back (``Measurement.given_noise``); it never
asks which kind of sensor it is.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from scalar.geometry.se3 import Array

ROTATION_NOISE = "rotation_noise"
"""The component of measured orientations [rad]."""


@dataclass(frozen=True)
class NoiseComponent:
    """A component of the sensor's own noise, as diagnosis and calibration files list it.

    Attributes:
        name: ``scan_level``, ``scan_correlation``, ``surface_waviness``.
        target: What tells it from others of its name; lengths with their unit in the key.
        value: Its size.
        std: Standard error of the value.
        unit: Of value and std.
        sentence: The same for people.
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
    """How much alike points of one measurement err, by how many points they are apart.

    Attributes:
        measured: ``(L,)``, correlation at lags 1 to L.
        band: ``(L,)``, its standard error where the noise is white.
    """

    measured: Array
    band: Array


@dataclass(frozen=True, eq=False)
class PoseNoise:
    """The noise within the N poses of a dataset, where it is not white and of one size.

    Attributes:
        sigma: Typical standard deviation of a point [m].
        level: ``(N,)``, each pose's standard deviation in units of sigma.
        whitening: ``(N, m, m)``, inverse lower Cholesky factors of the covariance of the rows that ``profiles`` gives with this sigma.
            They are lower triangular, so that the first row stays what it was, divided by its standard deviation.
        components: What it consists of.
        autocorrelation: Along the measurement.
    """

    sigma: float
    level: Array
    whitening: Array
    components: tuple[NoiseComponent, ...]
    autocorrelation: Autocorrelation
