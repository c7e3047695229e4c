"""An instrument that stands apart from the arm and distorts the space in which it measures: its error is a smooth function of the position."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from scalar.data.poses import Poses
from scalar.effects.effect import Effect
from scalar.effects.flexible.unattributed import NAME, Unattributed
from scalar.effects.picture import Map, Profile, View
from scalar.effects.places import PointEffect
from scalar.effects.remedies import NOTHING_FOR_THE_INSTRUMENT
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import Array

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset

# Symmetric strains without a trace (3, 3), orthogonal and of equal norm. A trace, a factor on all lengths, cannot be distinguished from a larger arm.
_STRAINS = np.zeros((5, 3, 3))
_STRAINS[0, [0, 1], [0, 1]] = 1.0, -1.0
_STRAINS[1, [0, 1, 2], [0, 1, 2]] = np.array([1.0, 1.0, -2.0]) / np.sqrt(3)
for _k, (_i, _j) in enumerate(((0, 1), (0, 2), (1, 2))):
    _STRAINS[2 + _k, [_i, _j], [_j, _i]] = 1.0
_STRAIN_NAMES = ["xx_yy_m_per_m", "zz_m_per_m", "xy_m_per_m", "xz_m_per_m", "yz_m_per_m"]
_SQUARES = tuple((i, j) for i in range(3) for j in range(i, 3))
# Prior standard deviations [1 and rad], so large that they hardly change what is fitted.
_MOST_STRAIN, _MOST_ANGLE = 3e-3, 1e-3
# Beyond these sizes no instrument errs that is in use: photogrammetry errs by 0.1 mm/m and less (data sheets), encoders of trackers by a few seconds
# of arc. On a measured iiwa, waves of 120 to 380 seconds and strains of 0.6 mm/m had taken the place of its compliance.
_LARGEST_STRAIN, _LARGEST_ANGLE = 4e-4, 2e-4  # [m/m], [rad]
# Periods in a turn: the disk of an encoder is off its centre; it is oval, or read by two heads.
ENCODER_ORDERS = 1, 2


@dataclass(frozen=True, eq=False)
class UnattributedSpace(Unattributed, PointEffect):
    """The instrument's positions y err by a smooth function of y: ``y = x + D(y) c`` with the true position x.

    It is the rival of errors of an arm that vary smoothly with the pose: of compliances, and of harmonics of the first joint. A factor on all lengths
    is left out, since it cannot be distinguished from a larger arm; so are shifts and turns, which move the instrument's frame. Measured orientations
    are assumed to be right.

    - ``strain``: ``D c = E (y - centre)``, E symmetric without a trace: axes of different scales, or not at right angles (photogrammetry).
    - ``quadratic``: the strain, and all products of two coordinates.
    - ``azimuth``: ``D c = (c_1 cos(k a) + c_2 sin(k a)) z x y``, a the azimuth of y about the z axis of the instrument's frame, k the order.
    - ``elevation``: the same for the elevation, the angle between y and the plane perpendicular to z, whose change moves y along a meridian.

    Waves of the first and second order are the errors of encoders in the models of laser trackers (Muralikrishnan, Phillips and Sawyer, Laser
    trackers for large-scale dimensional metrology: a review, Precision Engineering 44, 2016). They need positions in the instrument's own frame.

    Attributes:
        shape: ``strain``, ``quadratic``, ``azimuth`` or ``elevation``.
        order: Number of periods in a turn of an error of the azimuth or elevation; 0 for the other shapes.
        centre: Of the measured positions ``(3,)`` [m].
        half: Half their largest extent [m].
    """

    shape: str
    order: int = 0
    centre: tuple[float, float, float] = (0.0, 0.0, 0.0)
    half: float = 1.0

    kind: ClassVar[str] = "distortion of the measured space"
    reported_with: ClassVar[str] = "measured_space"
    of_instrument: ClassVar[bool] = True
    place: ClassVar[str] = "measured_space"
    basis_names: ClassVar[tuple[str, ...]] = ()

    @property
    def depends_on(self) -> list[str]:
        """Return the measured position."""
        return ["measured_position"]

    @property
    def described_as(self) -> str:
        """Return that the instrument errs, and in what."""
        if self.order:
            how = f"like a periodic error of its {self.shape} encoder"
        else:
            size = 1e3 * float(np.abs(np.linalg.eigvalsh(self._strain())).max())
            how = f"which is stretched by up to {size:.2g} mm per m{' and bent' if self.shape == 'quadratic' else ''}"
        return (
            f"a distortion of the space in which the instrument measures, and not an error of the arm, {how}"
        )

    @classmethod
    def clause_of(cls, effects: Sequence[Effect]) -> str:
        """Return that it is the instrument that errs."""
        return (
            "the measuring instrument distorts the space in which it measures, which is no error of the arm"
        )

    def _strain(self) -> Array:
        """Return E ``(3, 3)`` [m/m]."""
        return np.einsum("k,kij->ij", self.coefficients[:5], _STRAINS)

    def is_impossible(self, robot: Robot, poses: Poses) -> bool:
        """Return whether it is larger than errors of instruments are."""
        if self.order:
            return bool(np.hypot(*self.coefficients) > _LARGEST_ANGLE)
        bends = np.abs(self.coefficients[5:]).max(initial=0.0)
        strain = float(np.abs(np.linalg.eigvalsh(self._strain())).max())
        return strain > _LARGEST_STRAIN or bends > _LARGEST_STRAIN * self.half

    @property
    def key(self) -> str:
        """Name, shape and order."""
        return f"{NAME}_{self.place}_{self.shape}{self.order or ''}"

    @property
    def coefficient_names(self) -> list[str]:
        """Strains, bends at the edge of the measured space, or the two parts of a wave."""
        if self.order:
            return ["cos_rad", "sin_rad"]
        bends = [f"{'xyz'[k]}_by_{'xyz'[i]}{'xyz'[j]}_m" for k in range(3) for i, j in _SQUARES]
        return _STRAIN_NAMES + (bends if self.shape == "quadratic" else [])

    @property
    def coefficient_units(self) -> list[str]:
        """Metres a metre and metres, or radians."""
        if self.order:
            return ["rad", "rad"]
        return ["m/m"] * 5 + ["m"] * (len(self.coefficient_names) - 5)

    @property
    def prior_std(self) -> Array:
        """Return several times what instruments err by."""
        of_unit = {"m/m": _MOST_STRAIN, "m": _MOST_STRAIN * self.half, "rad": _MOST_ANGLE}
        return np.array([of_unit[unit] for unit in self.coefficient_units])

    def contact_columns(
        self, poses: Poses, T_base_sensor: Array, planes: Any, plane_index: Array, contact: Array
    ) -> Array:
        """Return the error ``(N, 3 K, k)`` of measured positions ``(N, 3 K)`` [m]."""
        y = contact.reshape(-1, 3)
        return self.distortion(y).reshape(*contact.shape, len(self.coefficient_names))

    def distortion(self, y: Array) -> Array:
        """Return D ``(P, 3, k)`` [m per unit] at measured positions ``(P, 3)`` [m]."""
        if self.order:
            azimuth = np.arctan2(y[:, 1], y[:, 0])
            across = np.stack([-np.sin(azimuth), np.cos(azimuth), np.zeros(len(y))], axis=1)
            level = np.hypot(y[:, 0], y[:, 1])
            if self.shape == "azimuth":
                angle, moved = azimuth, level[:, None] * across
            else:
                angle = np.arctan2(y[:, 2], level)
                moved = np.stack([-y[:, 2] * np.cos(azimuth), -y[:, 2] * np.sin(azimuth), level], axis=1)
            waves = np.stack([np.cos(self.order * angle), np.sin(self.order * angle)], axis=1)
            return moved[:, :, None] * waves[:, None, :]
        u = (y - np.array(self.centre)) / self.half
        found = [np.einsum("kij,pj->pik", _STRAINS, y - np.array(self.centre))]
        if self.shape == "quadratic":
            squares = np.stack([u[:, i] * u[:, j] for i, j in _SQUARES], axis=1)
            found += [np.einsum("ik,ps->piks", np.eye(3), squares).reshape(len(y), 3, -1)]
        return np.concatenate(found, axis=2)

    @property
    def advice(self) -> list[str]:
        """Return that the instrument should be checked."""
        return [
            "Check the measuring instrument before the arm: measure a bar of known length along several directions and at several distances, or the "
            "same fixed points from two places of the instrument, and have it calibrated if the lengths differ. Then measure the arm again."
        ]

    @property
    def how_to_measure(self) -> str:
        """Return how to see it directly."""
        return "To see it directly, move the instrument to the other side of the arm and repeat some poses: an error of the instrument moves with it."

    @property
    def in_controller(self) -> str:
        """Return that nothing changes in the controller."""
        return NOTHING_FOR_THE_INSTRUMENT

    def not_transferable(self, dataset: Dataset) -> str | None:
        """Return that another campaign sets the instrument up anew."""
        return "it is an error of the instrument in one place"

    def pictures(self, view: View) -> list[Profile | Map]:
        """Return the residual's shift over the predicted one."""
        return [view.added_variable(self)]

    def to_mapping(self) -> dict[str, Any]:
        """Return place, shape, order, centre and half extent."""
        return {
            "place": self.place, "shape": self.shape, "order": self.order, "centre_m": list(self.centre), "half_m": self.half,
        }  # fmt: skip

    @classmethod
    def from_settings(cls, mapping: Mapping[str, Any]) -> Self:
        """Return the term of ``to_mapping``."""
        x, y, z = (float(v) for v in mapping["centre_m"])
        return cls(str(mapping["shape"]), int(mapping["order"]), (x, y, z), float(mapping["half_m"]))
