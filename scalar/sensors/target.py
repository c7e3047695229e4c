"""What a sensor measures against: planes, the frame of a tracker, points with known places; and a first guess of where the sensor sits."""

from __future__ import annotations

from typing import Any, NamedTuple, Protocol

from scalar.geometry.se3 import Array


class Target(Protocol):
    """What a sensor measures against: some items (planes, frames), each with the same number of free coordinates, maybe none."""

    @property
    def parameter_names(self) -> list[str]:
        """Names of all coordinates, item by item."""
        ...

    @property
    def parameter_units(self) -> list[str]:
        """Units of all coordinates."""
        ...

    @property
    def vector(self) -> Array:
        """All coordinates."""
        ...

    def with_vector(self, vector: Array) -> Any:
        """Return the target at other coordinates."""
        ...

    def rebased(self) -> Any:
        """Return the same target with its coordinates counted from where it is."""
        ...

    def expressed_about(self, guess: Any) -> Any:
        """Return the same target in the coordinates that are reported."""
        ...


class Guess(NamedTuple):
    """A first guess of the sensor's pose on the flange.

    Attributes:
        T_flange_sensor: ``(4, 4)``.
        refits_target: Whether the target is to be fitted to it before the fit of both; else it stays as guessed.
    """

    T_flange_sensor: Array
    refits_target: bool
