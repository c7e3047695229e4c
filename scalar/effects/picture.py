"""What a picture of an effect holds, and what a fitted model provides so that an effect can draw it.

An effect says over which axis it is drawn; a fitted model, seen through a ``View``, gives the *partial residuals*: the residual that every pose
would have if this effect alone were taken out of the fitted model (Larsen and McCleary, Technometrics 14, 1972). Report and studies draw them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from scalar.data.poses import Poses, is_joint
from scalar.effects.wording import angle, length, number
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import Array
from scalar.sensors import Pieces
from scalar.units import MM

CURVE_POINTS = 361  # points of a fitted curve: one for each degree of a full turn
# Quantile that is taken for the largest value of a map, so that a single outlying pose does not decide it.
_TYPICAL_LARGEST = 0.98


@dataclass(frozen=True)
class Axis:
    """The label of an axis, and its unit: ``rad``, ``m``, ``m/m``, ``1``, ``s``, ``N m``, ``degC`` or empty."""

    label: str
    unit: str


@dataclass(frozen=True, eq=False)
class Profile:
    """Partial residuals of an effect along one variable.

    Attributes:
        x_axis, y_axis: What x and y are.
        x: ``(N,)``.
        y: ``(N,)``, partial residuals: without the effect, in the unit of ``y_axis`` like all that follow.
        rest: ``(N,)``, residuals with the effect.
        std: ``(N,)``, standard error of each from the noise of its pose.
        fitted: ``(N,)``, what the effect predicts.
        curve: ``(3, G)``, x, the effect and its standard error, or None where it is no function of x alone.
        side: ``(N,)``, -1 or 1: the side of its play on which the joint rests; None where an effect has no sides.
        mark: A value of x to be marked: where a change begins.
        pose: ``(N,)``, which pose of the dataset each value belongs to, counted from 0; None: one value
            a pose, in the order of the dataset.
        note: A sentence on what is shown.
    """

    x_axis: Axis
    y_axis: Axis
    x: Array
    y: Array
    rest: Array
    std: Array
    fitted: Array
    curve: Array | None = None
    side: Array | None = None
    mark: float | None = None
    pose: Array | None = None
    note: str = ""


@dataclass(frozen=True, eq=False)
class Map:
    """Partial residuals of an effect over two variables.

    Attributes:
        u_axis, v_axis, y_axis: What u, v and y are.
        u, v: ``(K,)``.
        y, rest: ``(K,)``, without and with the effect.
        pose: ``(K,)``, which pose of the dataset each value belongs to, counted from 0.
        note: A sentence on what is shown.
    """

    u_axis: Axis
    v_axis: Axis
    y_axis: Axis
    u: Array
    v: Array
    y: Array
    rest: Array
    pose: Array
    note: str = ""


class View(Protocol):
    """What a picture of an effect needs of the fitted model."""

    @property
    def poses(self) -> Poses:
        """Return what is known of each of the N poses."""
        ...

    @property
    def nominal(self) -> Robot:
        """Return the nominal robot, for which the columns of effects are computed."""
        ...

    @property
    def T_base_sensor(self) -> Array:
        """Return the fitted pose of the sensor in the base frame at every pose ``(N, 4, 4)``."""
        ...

    def joint_screws(self, joint: int) -> Array:
        """Return how the sensor moves with a joint's angle ``(N, 6)``, base frame; the joint counts from 1."""
        ...

    def geometry_screws(self) -> Array:
        """Return how the sensor moves with every parameter of ``Robot.geometry``, row by row, ``(N, 6, 5 n)``."""
        ...

    def estimated_along(self, screws: Array) -> tuple[Array, Array]:
        """Return how large a motion of the sensor would have to be to remove each pose's residual, and its standard error, ``(N,)`` each.

        Args:
            screws: ``(N, 6)``, the motion of size one at each pose, a screw in the base frame.
        """
        ...

    def error_of(self, effect: Any, basis: Array) -> Array:
        """Return the standard error ``(G,)`` of ``basis @ coefficients``, basis ``(G, k)``."""
        ...

    def pieces(self, effect: Any) -> Pieces:
        """Return the measured heights over the planes, with what one effect on points adds to them."""
        ...

    def on_plane(self, plane: str) -> Array:
        """Return which poses measure a plane, ``(N,)`` bool."""
        ...

    def normal_of(self, plane: str) -> Array:
        """Return the unit normal of a plane as fitted ``(3,)``."""
        ...

    def added_variable(self, effect: Any) -> Profile:
        """Return the added-variable plot: partial residuals over the effect's prediction, both without the part that other parameters can fit."""
        ...


def angle_axis(joint: int, unit: str = "rad") -> Axis:
    """Return the axis of a joint's angle, or of its travel where the unit is ``m``."""
    return Axis(f"{'travel' if unit == 'm' else 'angle'} of joint {joint}", unit)


def joint_axis(robot: Robot, joint: int) -> Axis:
    """Return the axis of the angle or travel of a joint of a robot, from 1."""
    return angle_axis(joint, "m" if robot.slides[joint - 1] else "rad")


def variable_axis(name: str, robot: Robot) -> Axis:
    """Return the axis of a column of poses.csv."""
    if is_joint(name):
        return joint_axis(robot, int(name[1:]))
    unit = {"time": "s", "temperature": "degC"}.get(name, "")
    return Axis("order of acquisition" if name == "order" else name, unit)


def largest(pictures: Sequence[Profile | Map], opening: str = "up to ") -> str:
    """Return how large an effect is at the poses that were measured, in words with its unit; empty where nothing is drawn."""
    if not pictures:
        return ""
    first = pictures[0]
    if isinstance(first, Map):
        value, opening = float(np.nanquantile(np.abs(first.y), _TYPICAL_LARGEST)), "about "
    else:
        value = max(float(np.nanmax(np.abs(p.fitted))) for p in pictures if isinstance(p, Profile))
        opening = "± " if first.side is not None else opening
    unit = first.y_axis.unit
    if unit == "rad":
        return f"{opening}{angle(value)}"
    if unit == "m":
        return f"{opening}{length(value)}"
    return f"{opening}{number(value / MM, 2)} mm per m" if unit == "m/m" else ""
