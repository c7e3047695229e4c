"""A zero error of the laser."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from scalar.effects.effect import Effect
from scalar.effects.flexible.incidence import incidence
from scalar.effects.flexible.profile_bow import profile_bow
from scalar.effects.flexible.profile_width import profile_width
from scalar.effects.range_error import RangeError
from scalar.effects.sensor_map import SensorMap
from scalar.geometry.se3 import Array

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset


@dataclass(frozen=True, eq=False)
class RangeOffset(RangeError):
    """The measured range needs a constant: ``r -> r + o``."""

    name: ClassVar[str] = "range_offset"
    in_every_setup: ClassVar[bool] = True  # no scanner's zero is exact
    imitators_are_as_likely: ClassVar[bool] = True
    kind: ClassVar[str] = "range offset of the laser"
    sentence: ClassVar[str] = "the scanner measures all distances too long or too short by the same amount"
    natural: ClassVar[Mapping[str, float]] = {"m": 3e-4}
    natural_source: ClassVar[str] = (
        "assumed: the zero of a scanner is a point inside its housing, drawn to a few tenths of a millimetre"
    )
    remedy: ClassVar[str] = (
        "scans from near and from far, the scanner turned about its line of sight, would show it"
    )
    remedy_advice: ClassVar[str] = (
        "Scan the same target plane from near and from far, and with the scanner turned about its line of sight: while the incidence hardly "
        "varies, an error of the laser's zero cannot be distinguished from a shift of the scanner on the flange."
    )
    basis_names: ClassVar[tuple[str, ...]] = ("ux", "uz")

    def imitators(self, dataset: Dataset) -> list[Effect]:
        """Return a factor of the width of profiles, which an offset imitates where the range hardly varies, a bow, and an error by the incidence."""
        return [*profile_width(dataset), *profile_bow(dataset), *incidence(dataset)]

    def generalised(self, dataset: Dataset) -> Effect | None:
        """Return a map of the scanner's error over its profile, where it scans profiles."""
        return next(iter(SensorMap.candidates(dataset)), None)

    @property
    def coefficient_names(self) -> list[str]:
        """``offset_m``."""
        return ["offset_m"]

    @property
    def coefficient_units(self) -> list[str]:
        """Metres."""
        return ["m"]

    @property
    def clause(self) -> str:
        """Return what is off."""
        return "the laser's range has an error of its zero"

    @property
    def advice(self) -> list[str]:
        """Return what to do about it."""
        return [
            "Check the zero of the scanner against a known distance, or have its maker calibrate it: the arm is not at fault."
        ]

    def range_basis(self, reach: Array) -> Array:
        """Return the correction of the range by the coefficient ``(G, 1)``."""
        return np.ones((len(reach), 1))
