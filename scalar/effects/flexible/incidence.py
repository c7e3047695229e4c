"""A scanner whose range errs with the angle at which its light falls on the surface."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from scalar.data.poses import Poses
from scalar.effects.flexible.profile_error import UnattributedProfileError
from scalar.effects.range_error import LEAST_INCIDENCE
from scalar.effects.wording import length
from scalar.geometry.se3 import Array
from scalar.sensors import kind_of

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset

_USUAL = 5e-5  # m, chosen: a tenth of the width of a laser's line


@dataclass(frozen=True, eq=False)
class UnattributedIncidence(UnattributedProfileError):
    """The correction ``c (1 / cos^2 b - 1)`` [m] of the measured range, b being the angle between a point's ray and the plane's normal.

    The spot of a laser on an inclined surface is an ellipse whose brightest part is not its middle, so a scanner by triangulation measures inclined
    surfaces too near or too far. Because b varies within a scan, the measured line tilts and bends. Errors of the range's zero, scale and linearity
    tilt and bend lines as well, and this term is their rival. Its size is c at 45 degrees. On a plane, ``1 / cos^2 b - 1`` is a polynomial of the
    second degree in x, the coordinate of a point across the profile: with the scanner h over the plane, ``cos b = h / |p|`` and z is linear in x.
    """

    place: ClassVar[str] = "incidence"
    basis_names: ClassVar[tuple[str, ...]] = ("ux", "uz", "ux:10", "uz:10", "ux:20", "uz:20")

    @property
    def depends_on(self) -> list[str]:
        """Return the angle of incidence."""
        return ["incidence"]

    @property
    def described_as(self) -> str:
        """Return that the range errs with the incidence, and how much at 45 degrees."""
        size = length(float(abs(self.coefficients[0])))
        return f"an error of the scanner's range that grows with the incidence, {size} at 45°, and not an error of the arm"

    @property
    def coefficient_names(self) -> list[str]:
        """``at_45_degrees_m``."""
        return ["at_45_degrees_m"]

    @property
    def coefficient_units(self) -> list[str]:
        """Metres."""
        return ["m"]

    @property
    def prior_std(self) -> Array:
        """Return the size ``(1,)`` [m] that it has in scanners, so that it does not imitate a zero that is off by tenths of a millimetre."""
        return np.array([_USUAL])

    def contact_columns(
        self, poses: Poses, T_base_sensor: Array, planes: Any, plane_index: Array, contact: Array
    ) -> Array:
        """Return G ``(N, 6, 1)``: the plane's normal along the sensor's x and z axes, times each coefficient [1, 1/m, 1/m^2] of the polynomial in x.

        Near grazing incidence the normal's part along z counts as ``LEAST_INCIDENCE`` at least. Other arguments as in ``PointEffect``.
        """
        across, along = contact[:, 1], contact[:, 2]
        along = np.copysign(np.maximum(np.abs(along), LEAST_INCIDENCE), along)
        distance = -contact[:, 0] / along  # of the plane from the scanner, along the z axis [m]
        slope, straight = across / along, 1.0 / along**2
        powers = (
            straight - 1.0,
            -2.0 * slope * straight / distance,
            (1.0 + slope**2) * straight / distance**2,
        )
        return np.concatenate([contact[:, 1:] * power[:, None] for power in powers], axis=1)[:, :, None]

    @property
    def advice(self) -> list[str]:
        """Return what to do about it."""
        return [
            "Scan the same flat surface at several angles: if its distance changes with the angle, keep to one incidence in measurements, or have "
            "the scanner's maker look at it. The arm is not at fault."
        ]


def incidence(dataset: Dataset) -> list[UnattributedIncidence]:
    """Return the term, where the sensor scans profiles."""
    return [UnattributedIncidence()] if kind_of(dataset).scans else []
