"""A joint's angle that errs in one simple way: a bump, a step, a kink, a power."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Self

import numpy as np

from scalar.data.poses import Poses, is_joint
from scalar.effects.flexible.joint import UnattributedJoint
from scalar.effects.flexible.variable import Variable
from scalar.effects.wording import angle, columns_in_words, length, number
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import Array

PLATEAU_FLANK = 3.0  # steepness of its flanks, in units of half its width


@dataclass(frozen=True, eq=False)
class UnattributedShape(UnattributedJoint):
    """A joint's angle errs in one simple way: a bump, a step or a kink at some value of a variable, a power of it, a product of two.

    With one coefficient it describes a few worn teeth, or an encoder that lost a count, which a sum of several harmonics would imitate. A bend has
    two. It describes a spring that pushes on a part of the range alone, which a scale error and a harmonic would imitate.

    Attributes:
        variables: One, or the two of a product.
        shape: ``bump`` (Gaussian), ``plateau`` (one with a flat top), ``step`` (a hyperbolic tangent), ``bend`` (two straight lines that meet),
            ``kink`` (an absolute value, in older files), ``line``, ``square``, ``cube`` or ``product``.
        at, width: Place and width of a bump, a plateau, a step or a bend, in units of half the measured range of the variable.
    """

    shape: str
    at: float = 0.0
    width: float = 1.0

    place: ClassVar[str] = "shape"

    @property
    def _shape_in_words(self) -> str:
        """Return how the error varies, as the end of a sentence: ``is proportional to the angle of joint 2``."""
        along = columns_in_words(self.depends_on)
        words = {
            "line": "is proportional to",
            "square": "varies with the square of",
            "cube": "varies with the cube of",
        }
        if self.shape in words:
            return f"{words[self.shape]} {along}"
        if self.shape == "product":
            return f"is proportional to the product of {along}"
        if self.shape == "bend":
            return f"changes its slope over {along} near {self._place_in_words}"
        return f"has a {self.shape} near {self._place_in_words}"

    @property
    def _place_in_words(self) -> str:
        """Return where the shape has its middle, with its unit: an angle, a travel, an order, or the value of another column."""
        variable = self.variables[0]
        at = variable.centre + self.at * variable.half
        if is_joint(variable.name):
            return length(at) if self.slides else angle(at, 3)
        return f"order {at:.0f}" if variable.name == "order" else f"{variable.name} {number(at)}"

    @property
    def key(self) -> str:
        """Name, joint, variable and shape with its place."""
        return f"{super().key}_{self.shape}_{self.at:.3f}"

    @property
    def coefficient_names(self) -> list[str]:
        """The height; of a bend the two slopes, each over a width."""
        sides = ("_below", "_above") if self.shape == "bend" else ("",)
        return [f"size{side}_{self.joint_unit}" for side in sides]

    @property
    def coefficient_units(self) -> list[str]:
        """Radians, or metres."""
        return [self.joint_unit] * len(self.coefficient_names)

    def own_columns(self, robot: Robot, poses: Poses) -> Array:
        """Return the shape, of height one, as an error of the joint."""
        u, *others = (variable.unit(poses) for variable in self.variables)
        s = (u - self.at) / self.width
        values = {
            "bump": lambda: np.exp(-(s**2) / 2),
            "plateau": lambda: (np.tanh(PLATEAU_FLANK * (s + 1)) - np.tanh(PLATEAU_FLANK * (s - 1))) / 2,
            "step": lambda: (np.tanh(s) + 1) / 2,
            "kink": lambda: np.abs(s),
            "bend": lambda: np.stack([np.minimum(s, 0.0), np.maximum(s, 0.0)], axis=1),
            "line": lambda: u,
            "square": lambda: u**2,
            "cube": lambda: u**3,
            "product": lambda: u * others[0],
        }[self.shape]()
        return values.reshape(len(s), -1)

    def since(self, poses: Poses) -> Array | None:
        """Return at which poses a bump, a plateau or a step in time has begun ``(N,)``; None for other shapes and variables."""
        if self.shape not in ("bump", "plateau", "step") or self.variables[0].name not in ("time", "order"):
            return None
        return self.variables[0].unit(poses) >= self.at - self.width

    def variations(self, scale: float) -> list[Self]:
        """Return the shape moved by parts of its width, wider and narrower."""
        if self.shape not in ("bump", "plateau", "step", "kink", "bend"):
            return [self]
        return [
            replace(self, at=self.at + a * scale * self.width, width=self.width * 2.0 ** (b * scale))
            for a in (-1.0, -0.5, 0.0, 0.5, 1.0)
            for b in ((0.0,) if self.shape in ("kink", "bend") else (-1.0, 0.0, 1.0))
        ]

    def to_mapping(self) -> dict[str, Any]:
        """Return place, joint, variable and shape."""
        return super().to_mapping() | {
            "place": self.place,
            "shape": self.shape,
            "at": self.at,
            "width": self.width,
        }

    @classmethod
    def from_settings(cls, mapping: Mapping[str, Any]) -> Self:
        """Return the term of ``to_mapping``."""
        variables = tuple(Variable.from_mapping(v) for v in mapping["variables"])
        shape, at, width = str(mapping["shape"]), float(mapping["at"]), float(mapping["width"])
        slides = bool(mapping.get("slides", False))
        return cls(int(mapping["joint"]), variables, shape, at, width, slides=slides)
