"""A gain error of the laser."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from scalar.effects.effect import Effect
from scalar.effects.flexible.incidence import incidence
from scalar.effects.range_error import RangeError
from scalar.effects.sensor_map import SensorMap
from scalar.effects.wording import KNOWN_LENGTH, KNOWN_LENGTH_ADVICE
from scalar.geometry.se3 import Array

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset


@dataclass(frozen=True, eq=False)
class RangeScale(RangeError):
    """The measured range needs to be stretched: ``r -> (1 + s) r``."""

    name: ClassVar[str] = "range_scale"
    stretches_lengths: ClassVar[bool] = True
    imitators_are_as_likely: ClassVar[bool] = True
    kind: ClassVar[str] = "range scale of the laser"
    sentence: ClassVar[str] = (
        "the scanner measures all distances too long or too short in the same proportion"
    )
    natural: ClassVar[Mapping[str, float]] = {"m/m": 1e-3}
    natural_source: ClassVar[str] = (
        "line scanners are sold with a linearity of 0.1 % of the range (Keyence LJ-V7000, data sheet)"
    )
    remedy: ClassVar[str] = KNOWN_LENGTH
    remedy_advice: ClassVar[str] = KNOWN_LENGTH_ADVICE
    basis_names: ClassVar[tuple[str, ...]] = ("rx", "rz")

    def imitators(self, dataset: Dataset) -> list[Effect]:
        """Return an error by the incidence: scans from afar are often those that look at a plane from the side."""
        return [*incidence(dataset)]

    def generalised(self, dataset: Dataset) -> Effect | None:
        """Return a map of the scanner's error over its profile, where it scans profiles."""
        return next(iter(SensorMap.candidates(dataset)), None)

    @property
    def coefficient_names(self) -> list[str]:
        """``gain_m_per_m``."""
        return ["gain_m_per_m"]

    @property
    def coefficient_units(self) -> list[str]:
        """Metres of error per metre of range."""
        return ["m/m"]

    @property
    def clause(self) -> str:
        """Return what is off."""
        return "the laser's range has an error of scale"

    @property
    def advice(self) -> list[str]:
        """Return what to do about it."""
        return [
            "Check the scale of the scanner against a known length, or have its maker calibrate it: the arm is not at fault."
        ]

    def range_basis(self, reach: Array) -> Array:
        """Return the correction of the range by the coefficient ``(G, 1)``."""
        return reach[:, None]
