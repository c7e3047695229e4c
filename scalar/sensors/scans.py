"""The part of the protocol for kinds that scan planes: points along lines, compressed to a few rows for each scan."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol, cast

from scalar.geometry.se3 import Array
from scalar.sensors.protocol import Measurement

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset


class Scans(Protocol):
    """The members that a kind that scans planes has in addition to ``Measurement``: points along lines, compressed to rows ``R c``.

    The contact vector c, and the functions of a point whose coefficients it contains, are those of ``scalar.sensors.profile``.
    """

    @property
    def points(self) -> Array:
        """x and z of every point in the sensor's frame ``(P, 2)`` [m]."""
        ...

    @property
    def starts(self) -> Array:
        """Where each scan's points begin ``(N + 1,)``."""
        ...

    @property
    def error_axis(self) -> str:
        """The direction of a point's error: ``ray`` (from the sensor's origin through the point) or ``z``."""
        ...

    @property
    def target_index(self) -> Array:
        """Which plane each pose measures ``(N,)``."""
        ...

    @property
    def sigma(self) -> float:
        """Standard deviation of a point along the error axis [m]."""
        ...

    @property
    def R(self) -> Array:
        """Whitened triangular factors ``(N, k, k)``."""
        ...

    @property
    def R_metric(self) -> Array:
        """Triangular factors with equal weights of all points, in metres ``(N, k, k)``."""
        ...

    def initial_target(self, dataset: Dataset) -> Any:
        """Return the planes at their initial guesses."""
        ...

    def fitted_target(self, T_base_sensor: Array, target: Any) -> Any:
        """Return the planes of least squared distance to the points."""
        ...


def as_scans(measurement: Measurement) -> Scans:
    """Return a measurement as scans of planes.

    Raises:
        ValueError: Its kind of sensor does not scan.
    """
    if not measurement.scans:
        raise ValueError(f"scans of planes are needed, and this is a {measurement.words}")
    return cast(Scans, measurement)
