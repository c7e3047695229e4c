"""A scanner that shows a flat surface as a bowed profile."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from scalar.data.poses import Poses
from scalar.effects.flexible.profile_error import UnattributedProfileError
from scalar.geometry.se3 import Array
from scalar.sensors import kind_of

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset

DEGREES = (2, 3)  # of x: a symmetric bow, and what makes it deeper on one side


@dataclass(frozen=True, eq=False)
class UnattributedProfileBow(UnattributedProfileError):
    """The measured range needs ``c_2 (x / half)^2 + c_3 (x / half)^3``.

    It is the rival of errors of the range's zero and of its linearity, which bend profiles as well, and of bowed planes. It is a large error, as of a
    lens that is out of place; ``SensorMap`` describes what remains after the maker's calibration, with a prior of a few hundredths of a millimetre.

    Attributes:
        half: Half the width of the measured part of the profile [m].
    """

    half: float

    place: ClassVar[str] = "profile_bow"
    basis_names: ClassVar[tuple[str, ...]] = tuple(f"u{axis}:{k}0" for k in DEGREES for axis in "xz")

    @property
    def depends_on(self) -> list[str]:
        """Return the place in the profile."""
        return ["profile_x"]

    @property
    def described_as(self) -> str:
        """Return that profiles of a flat surface are bowed, and how much."""
        edges = float(np.abs(np.array([[1.0, 1.0], [1.0, -1.0]]) @ self.coefficients).max())
        return f"a bow of the scanner's profiles by up to {1e3 * edges:.2g} mm at their ends, and not an error of the arm"

    @property
    def coefficient_names(self) -> list[str]:
        """The parts of the second and third degree at the ends of the profile."""
        return [f"x{k}_m" for k in DEGREES]

    @property
    def coefficient_units(self) -> list[str]:
        """Metres."""
        return ["m"] * len(DEGREES)

    def contact_columns(
        self, poses: Poses, T_base_sensor: Array, planes: Any, plane_index: Array, contact: Array
    ) -> Array:
        """Return the plane's normal along the sensor's x and z axes, for each power of x."""
        G = np.zeros((len(contact), 2 * len(DEGREES), len(DEGREES)))
        for column, degree in enumerate(DEGREES):
            G[:, 2 * column : 2 * column + 2, column] = contact[:, 1:] / self.half**degree
        return G

    @property
    def advice(self) -> list[str]:
        """Return what to do about it."""
        return [
            "Scan a surface that is known to be flat at several distances: if its profile is bowed, have the scanner calibrated by its maker. "
            "The arm is not at fault."
        ]

    def to_mapping(self) -> dict[str, Any]:
        """Return place and half width."""
        return {"place": self.place, "half_m": self.half}

    @classmethod
    def from_settings(cls, mapping: Mapping[str, Any]) -> Self:
        """Return the term of ``to_mapping``."""
        return cls(float(mapping["half_m"]))


def profile_bow(dataset: Dataset) -> list[UnattributedProfileBow]:
    """Return the term, where the sensor scans profiles."""
    if not kind_of(dataset).scans:
        return []
    return [UnattributedProfileBow(max(float(np.abs(dataset.points[:, 0]).max()), 1e-4))]
