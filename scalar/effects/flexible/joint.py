"""A joint's angle that errs smoothly with one or two variables."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np
from numpy.polynomial import legendre

from scalar.data.poses import Poses, is_joint
from scalar.effects.flexible.unattributed import NAME, Unattributed
from scalar.effects.flexible.variable import Variable
from scalar.effects.joint_pictures import joint_curve, joint_profile
from scalar.effects.picture import CURVE_POINTS, Map, Profile, View, variable_axis
from scalar.effects.places import SingleJointEffect
from scalar.effects.wording import columns_in_words
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import Array

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset

SINGLE_DEGREE = 6  # degree of the polynomials in one variable
PAIR_DEGREE = 3  # degree of the polynomials in each of two variables
# Chosen [rad or m]: the prior standard deviation of each function of two variables in a final fit. The functions resemble one another, so that
# without it large ones of opposite sign cancel where poses are: 0.2 rad beyond the measured range, errors of 0.3 mm had been corrected to 0.9 mm.
FINAL_STD = 1e-4
# A pose whose standard error is more than this many times the median is not drawn in a map.
LARGEST_DRAWN_STD = 3.0


def single_functions(variable: Variable, poses: Poses, degree: int = SINGLE_DEGREE) -> Array:
    """Return Legendre polynomials 1..degree, and for a joint its absolute value and sign, ``(N, k)``."""
    u = variable.unit(poses)
    columns = [legendre.legvander(u, degree)[:, 1:]]
    if variable.name.startswith("q"):
        x = variable.clipped(poses)
        columns.append(np.column_stack([np.abs(x) / variable.half, np.sign(x)]))
    return np.concatenate(columns, axis=1)


def pair_functions(a: Variable, b: Variable, poses: Poses) -> Array:
    """Return products of Legendre polynomials and of sines and cosines of two variables, ``(N, k)``.

    Outside the measured range of a variable they keep their values at its nearer end. A fit may use large waves and polynomials of opposite sign,
    which cancel within the range; beyond it their sum would grow to many times its size.
    """
    P, Q = (legendre.legvander(v.unit(poses), PAIR_DEGREE)[:, 1:] for v in (a, b))
    products = (P[:, :, None] * Q[:, None, :]).reshape(len(P), -1)
    trig = [np.column_stack([np.sin(v.clipped(poses)), np.cos(v.clipped(poses))]) for v in (a, b)]
    waves = (trig[0][:, :, None] * trig[1][:, None, :]).reshape(len(P), -1)
    return np.concatenate([products, waves], axis=1)


@dataclass(frozen=True, eq=False)
class UnattributedJoint(Unattributed, SingleJointEffect):
    """A joint's angle, or the travel of one that slides, errs smoothly with one or two variables.

    Attributes:
        joint: From 1.
        variables: One or two.
        slides: Whether the joint slides.
        is_final: Whether the effects are known, and the term is fitted for the last time (``for_final_fit``).
    """

    joint: int
    variables: tuple[Variable, ...]
    slides: bool = field(default=False, kw_only=True)
    is_final: bool = field(default=False, kw_only=True)

    place: ClassVar[str] = "joint"

    @property
    def prior_std(self) -> Array:
        """Return the usual prior standard deviations, or those of a final fit."""
        return np.full(len(self.coefficients), FINAL_STD) if self.is_final else super().prior_std

    def for_final_fit(self) -> Self:
        """Return a term of two variables with ``FINAL_STD``, so that it is small where few poses show what it is: near the ends of both ranges."""
        return replace(self, is_final=True) if len(self.variables) > 1 else self

    @property
    def depends_on(self) -> list[str]:
        """Return the names of the variables."""
        return [v.name for v in self.variables]

    @property
    def described_as(self) -> str:
        """Return that it is an error of the joint's angle or travel, and its shape."""
        what = "travel" if self.slides else "angle"
        return f"an error of the {what} of joint {self.joint} that {self._shape_in_words}"

    @property
    def _shape_in_words(self) -> str:
        return f"varies smoothly with {columns_in_words(self.depends_on)}"

    @property
    def key(self) -> str:
        """Name, joint and variables."""
        return "_".join([NAME, f"joint{self.joint}", *self.depends_on])

    @property
    def coefficient_names(self) -> list[str]:
        """Numbered functions."""
        if len(self.variables) == 1:
            count = SINGLE_DEGREE + (2 if self.variables[0].name.startswith("q") else 0)
        else:
            count = PAIR_DEGREE**2 + 4
        return [f"f{k + 1}_{self.joint_unit}" for k in range(count)]

    @property
    def coefficient_units(self) -> list[str]:
        """Radians, or metres."""
        return [self.joint_unit] * len(self.coefficient_names)

    def own_columns(self, robot: Robot, poses: Poses) -> Array:
        """Return the functions of the variables as errors of the joint."""
        if len(self.variables) == 1:
            return single_functions(self.variables[0], poses)
        return pair_functions(self.variables[0], self.variables[1], poses)

    def to_mapping(self) -> dict[str, Any]:
        """Return place, joint and variables."""
        return {
            "place": self.place,
            "joint": self.joint,
            "variables": [v.to_mapping() for v in self.variables],
            **({"slides": True} if self.slides else {}),
        }

    @classmethod
    def from_settings(cls, mapping: Mapping[str, Any]) -> Self:
        """Return the term of ``to_mapping``."""
        variables = tuple(Variable.from_mapping(v) for v in mapping["variables"])
        return cls(int(mapping["joint"]), variables, slides=bool(mapping.get("slides", False)))

    @property
    def own_angle_joint(self) -> int | None:
        """The joint, where its own angle is all that the error depends on."""
        return self.joint if self.depends_on == [f"q{self.joint}"] else None

    def not_transferable(self, dataset: Dataset) -> str | None:
        """Return that a dependence on anything but joint angles belongs to one campaign."""
        foreign = [name for name in self.depends_on if not is_joint(name)]
        return f"its dependence on {', '.join(foreign)} is that of one campaign" if foreign else None

    def pictures(self, view: View) -> list[Profile | Map]:
        """Return the error of the joint over its one or two variables."""
        first = self.variables[0]
        axis, values = variable_axis(first.name, view.nominal), first.values(view.poses)
        if len(self.variables) == 1:
            x = np.linspace(first.centre - first.half, first.centre + first.half, CURVE_POINTS)
            q = np.zeros((len(x), view.poses.q.shape[1]))
            if is_joint(first.name):
                q[:, int(first.name[1:]) - 1] = x
            curve = joint_curve(view, self, self.joint, x, Poses(q, x, {first.name: x}))
            return [joint_profile(view, self, self.joint, axis, values, curve=curve)]
        second = self.variables[1]
        along = joint_profile(view, self, self.joint, axis, values)
        sure = along.std < LARGEST_DRAWN_STD * np.nanmedian(along.std)
        return [
            Map(
                axis,
                variable_axis(second.name, view.nominal),
                along.y_axis,
                along.x[sure],
                second.values(view.poses)[sure],
                along.y[sure],
                along.rest[sure],
                np.flatnonzero(sure),
            )
        ]
