"""The target that a sensor measures (planes, the frame of a tracker, points with known positions), and first guesses of the sensor's pose."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any, NamedTuple, Protocol

import numpy as np

from scalar.geometry.se3 import Array


class Target(Protocol):
    """The target of a sensor: items such as planes or frames, each with the same number of free coordinates, which may be zero.

    Behind the coordinates of its items, a target may have further ones that all items share; their number is then its attribute ``common``.
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
        """Return the same target with its current state as the reference of its coordinates."""
        ...

    def expressed_about(self, guess: Any) -> Any:
        """Return the same target in the coordinates that are reported."""
        ...


def on_flange(target: Target) -> Any:
    """Return the several targets on the flange that were measured, with their ``names``; None for a kind of target that has no such part."""
    return getattr(target, "targets", None)


def is_stated(target: Target) -> bool:
    """Return whether a dataset states where targets of this kind are: planes have initial guesses, the place of a tracker is fitted alone."""
    return bool(getattr(target, "is_stated", False))


def held_as_guessed(target: Any, guess: Any, held: Collection[str]) -> Any:
    """Return a target of which the coordinates named in ``held`` have their values of the initial guess."""
    names = guess.parameter_names
    if set(names).isdisjoint(held):
        return target
    about_guess = target.expressed_about(guess)
    is_held = np.isin(names, list(held))
    return about_guess.with_vector(np.where(is_held, guess.rebased().vector, about_guess.vector))


def by_coordinates(target: Target, by_item: Array, index: Array) -> Array:
    """Return derivatives by all coordinates of a target ``(N, m, T)``.

    Args:
        target: The target; its last ``common`` coordinates, if it has that attribute, belong to all items.
        by_item: ``(N, m, t + common)``, derivatives by the coordinates of the pose's own item, then by the common ones.
        index: ``(N,)``, the item of each pose.
    """
    N, m, width = by_item.shape
    common = int(getattr(target, "common", 0))
    own = width - common
    count = (len(target.vector) - common) // own
    found = np.zeros((N, m, count * own + common))
    of_items = found[:, :, : count * own].reshape(N, m, count, own)  # a view
    of_items[np.arange(N), :, index] = by_item[:, :, :own]
    found[:, :, count * own :] = by_item[:, :, own:]
    return found


class Guess(NamedTuple):
    """A first guess of the sensor's pose on the flange.

    Attributes:
        T_flange_sensor: ``(4, 4)``.
        refits_target: Whether the target is fitted to this pose before both are fitted together; else it stays at its initial guess.
    """

    T_flange_sensor: Array
    refits_target: bool
