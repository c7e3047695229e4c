"""A scanner whose profiles are too wide or too narrow by one factor."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from scalar.data.poses import Poses
from scalar.effects.flexible.profile_error import UnattributedProfileError
from scalar.geometry.se3 import Array
from scalar.sensors import kind_of

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset


@dataclass(frozen=True, eq=False)
class UnattributedProfileWidth(UnattributedProfileError):
    """The measured x of each point needs a factor, ``x -> x (1 + s)``, while z is right.

    It is the rival of an error of the range's zero: at a distance r, that widens profiles by its share of r, and only its change with the distance
    distinguishes the two. Without a known length, a factor of z cannot be distinguished from this one, because a common factor of x and z only
    changes all lengths.
    """

    place: ClassVar[str] = "profile_width"
    basis_names: ClassVar[tuple[str, ...]] = ("x",)

    @property
    def depends_on(self) -> list[str]:
        """Return the place in the profile."""
        return ["profile_x"]

    @property
    def described_as(self) -> str:
        """Return that the width of profiles is off."""
        gain = 1e3 * float(self.coefficients[0])
        return f"an error of the width of the scanner's profiles by {gain:.2g} mm per m, or of their height by the opposite"

    @property
    def coefficient_names(self) -> list[str]:
        """``gain_m_per_m``."""
        return ["gain_m_per_m"]

    @property
    def coefficient_units(self) -> list[str]:
        """Metres a metre."""
        return ["m/m"]

    def contact_columns(
        self, poses: Poses, T_base_sensor: Array, planes: Any, plane_index: Array, contact: Array
    ) -> Array:
        """Return the plane's normal along the sensor's x axis, the derivative of a point's height over the plane by its x."""
        return contact[:, 1:2, None]

    @property
    def advice(self) -> list[str]:
        """Return what to do about it."""
        return [
            "Check the width of the scanner's profiles and its distances against an artefact of known size, or have its maker calibrate it: "
            "the arm is not at fault."
        ]


def profile_width(dataset: Dataset) -> list[UnattributedProfileWidth]:
    """Return the term, where the sensor scans profiles."""
    return [UnattributedProfileWidth()] if kind_of(dataset).scans else []
