"""A curvature of the laser's range."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from scalar.data.poses import Poses
from scalar.effects.acquisition import range_middle
from scalar.effects.effect import Effect
from scalar.effects.flexible.incidence import incidence
from scalar.effects.flexible.profile_bow import profile_bow
from scalar.effects.picture import Map, Profile, View
from scalar.effects.range_error import RangeError, check_measures_range
from scalar.effects.sensor_map import SensorMap
from scalar.geometry.se3 import Array

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset

ZERO_STD = 2e-5  # m: what a parabola of 0.01 per metre adds to the zero if its middle is wrong by 0.045 m


@dataclass(frozen=True, eq=False)
class RangeDistortion(RangeError):
    """The measured range is curved: ``r -> r + k (r - m)^2 + s r + o``.

    k is the curvature, m the middle, s a gain and o a zero. Parabolas about different middles differ by a gain and a zero, so these two are fitted as
    well. Planes of unknown place do not determine the gain; it is then fixed, so that the slope of the range at ``middle`` is taken to be right. A
    wrong middle makes the arm too long or too short, and leaves no residual (``acquisition.range_middle`` says which middle is taken, and why).

    Attributes:
        middle: m [m].
    """

    middle: float = 0.0

    name: ClassVar[str] = "range_distortion"
    kind: ClassVar[str] = "range distortion of the laser"
    sentence: ClassVar[str] = (
        "the scanner's error is a curve over the distance that it measures: its linearity error"
    )
    natural: ClassVar[Mapping[str, float]] = {"1/m": 2e-2, "m/m": 1e-3, "m": 3e-4}
    natural_source: ClassVar[str] = (
        "a linearity of 0.1 % of the range (Keyence LJ-V7000, data sheet), taken to be curved: 0.1 mm, 70 mm from the middle"
    )
    basis_names: ClassVar[tuple[str, ...]] = ("dx", "dz", "rx", "rz", "ux", "uz")

    def imitators(self, dataset: Dataset) -> list[Effect]:
        """Return a bow of profiles, whose ends are farther away than their middle, and an error by the incidence."""
        return [*profile_bow(dataset), *incidence(dataset)]

    def generalised(self, dataset: Dataset) -> Effect | None:
        """Return a map of the scanner's error over its profile, where it scans profiles."""
        return next(iter(SensorMap.candidates(dataset)), None)

    @property
    def coefficient_names(self) -> list[str]:
        """Curvature, and the gain and zero that go with it."""
        return ["curvature_per_m", "gain_m_per_m", "offset_m"]

    @property
    def coefficient_units(self) -> list[str]:
        """One over metres, metres a metre, metres."""
        return ["1/m", "m/m", "m"]

    @property
    def prior_std(self) -> Array:
        """Return the usual prior standard deviations, but for the zero what a wrong middle adds to it: a larger zero is a ``range_offset``."""
        return np.array([*super().prior_std[:2], ZERO_STD])

    def contact_columns(
        self, poses: Poses, T_base_sensor: Array, planes: Any, plane_index: Array, contact: Array
    ) -> Array:
        """Return the normal along the sensor's x and z axes, for each of the three functions of the range."""
        G = np.zeros((len(contact), 6, 3))
        for k in range(3):
            G[:, 2 * k : 2 * k + 2, k] = contact[:, 1:]
        G[:, 2:4, 0] = -2.0 * self.middle * contact[:, 1:]
        G[:, 4:6, 0] = self.middle**2 * contact[:, 1:]
        return G

    def to_mapping(self) -> dict[str, Any]:
        """Return the middle."""
        return {"middle_m": self.middle}

    @classmethod
    def from_mapping(cls, mapping: Mapping[str, Any]) -> Self:
        """Return the effect of ``to_mapping``."""
        return cls(float(mapping.get("middle_m", 0.0)))

    @classmethod
    def parsed(cls, dataset: Dataset, words: Sequence[str]) -> list[Effect]:
        """Return a curvature about the middle of the extent of the measured ranges."""
        check_measures_range(dataset)
        return [cls(range_middle(dataset))]

    @property
    def clause(self) -> str:
        """Return what is curved."""
        return "the laser's range is not linear"

    @property
    def advice(self) -> list[str]:
        """Return what to do about it."""
        return [
            "Check the linearity of the scanner on a flat surface at known distances, or have its maker calibrate it: the arm is not at fault."
        ]

    def range_basis(self, reach: Array) -> Array:
        """Return the correction of the range by curvature, gain and zero ``(G, 3)``."""
        return np.column_stack([(reach - self.middle) ** 2, reach, np.ones_like(reach)])

    def pictures(self, view: View) -> list[Profile | Map]:
        """Return the curvature over the range, without a straight line: gain and zero are almost confounded with the geometry."""
        return [self._over_range(view, without_line=True)]
