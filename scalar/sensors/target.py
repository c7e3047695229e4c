"""What a sensor measures against: planes, the frame of a tracker, points with known places; and a first guess of where the sensor sits."""

from __future__ import annotations

from typing import Any, NamedTuple, Protocol

import numpy as np

from scalar.geometry.se3 import Array


class Target(Protocol):
    """What a sensor measures against: some items (planes, frames), each with the same number of free coordinates, maybe none.

    A target may have coordinates after these that all its items share; it then says how many as an attribute ``common``.
    """

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


def on_flange(target: Target) -> Any:
    """Return the targets that were measured beside one another on the flange, with their ``names``, or None for a target that has none such."""
    return getattr(target, "targets", None)


def by_coordinates(target: Target, by_item: Array, index: Array) -> Array:
    """Return derivatives by all coordinates of a target ``(N, m, T)``.

    Args:
        target: Its last ``common`` coordinates belong to all its items; a target without that attribute has none such.
        by_item: ``(N, m, t + common)``, derivatives by the coordinates of each row's own item, then by those in common.
        index: ``(N,)``, the item of each pose.
    """
    N, m, width = by_item.shape
    common = int(getattr(target, "common", 0))
    own, size = width - common, len(target.vector)
    items = np.zeros((N, m, (size - common) // own, own))
    items[np.arange(N), :, index] = by_item[:, :, :own]
    return np.concatenate([items.reshape(N, m, -1), by_item[:, :, own:]], axis=2)


class Guess(NamedTuple):
    """A first guess of the sensor's pose on the flange.

    Attributes:
        T_flange_sensor: ``(4, 4)``.
        refits_target: Whether the target is to be fitted to it before the fit of both; else it stays as guessed.
    """

    T_flange_sensor: Array
    refits_target: bool
