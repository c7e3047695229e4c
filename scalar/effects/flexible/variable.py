"""The variable of a flexible term and its measured range: a joint's angle, the order or time of acquisition, or another column."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np

from scalar.data.poses import Poses, is_joint
from scalar.effects.effect import GRAVITY as GRAVITY
from scalar.geometry.se3 import Array

_UNITS: WeakKeyDictionary[Poses, dict[Variable, Array]] = WeakKeyDictionary()


@dataclass(frozen=True)
class Variable:
    """A variable and its measured range: ``u = (x - centre) / half``, clipped to -1..1.

    Attributes:
        name: ``q3``, ``order``, ``time`` or another column.
        centre, half: In the unit of the column.
    """

    name: str
    centre: float
    half: float

    @classmethod
    def observed(cls, name: str, values: Array) -> Variable:
        """Return the variable with the range of some values."""
        low, high = float(np.min(values)), float(np.max(values))
        return cls(name, (low + high) / 2, max((high - low) / 2, 1e-12))

    def values(self, poses: Poses) -> Array:
        """Return the variable at poses, ``(N,)``, as it stands in the table; an order that is not finite counts as the end of the acquisition."""
        if is_joint(self.name):
            return poses.q[:, int(self.name[1:]) - 1]
        x = poses.order if self.name == "order" else poses.column(self.name)
        return np.where(np.isfinite(x), x, self.centre + self.half)

    def unit(self, poses: Poses) -> Array:
        """Return u ``(N,)``, from -1 to 1; outside the measured range the value at the nearer end; read-only, since many terms share it."""
        known = _UNITS.setdefault(poses, {})
        if self not in known:
            known[self] = np.minimum(np.maximum((self.values(poses) - self.centre) / self.half, -1.0), 1.0)
            known[self].setflags(write=False)
        return known[self]

    def clipped(self, poses: Poses) -> Array:
        """Return the variable at poses ``(N,)`` in the unit of its column; outside the measured range the value at the nearer end."""
        return self.centre + self.half * self.unit(poses)

    def within(self, poses: Poses) -> Array:
        """Return which poses ``(N,)`` lie in the measured range; its upper end, which stands for every later pose, does not belong to it."""
        values, start = self.values(poses), self.centre - self.half
        return (values >= start) & (values < start + 2 * self.half)

    def to_mapping(self) -> dict[str, Any]:
        """Return name and range."""
        return {"name": self.name, "centre": self.centre, "half": self.half}

    @classmethod
    def from_mapping(cls, mapping: Mapping[str, Any]) -> Variable:
        """Return the variable of ``to_mapping``."""
        return cls(str(mapping["name"]), float(mapping["centre"]), float(mapping["half"]))
