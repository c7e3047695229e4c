"""The numbers of a picture: what poses ask of an effect along one variable or over two; a state ready to
be asked."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from scalar.data.poses import Poses, is_joint
from scalar.diagnosis.fitted_state import FittedState
from scalar.effects.effect import Effect
from scalar.estimation.kinematics import Kinematics
from scalar.geometry.se3 import Array


@dataclass(frozen=True)
class Axis:
    """What a number of a picture is; its unit: ``rad``, ``m``, ``m/m``, ``1``, ``s``, ``degC`` or empty."""

    label: str
    unit: str


@dataclass(frozen=True, eq=False)
class Profile:
    """What each pose asks of an effect, along one variable.

    Attributes:
        x_axis, y_axis: What x and y are.
        x: ``(N,)``.
        y: ``(N,)``, partial residuals: with the effect taken away.
        rest: ``(N,)``, what remains with the effect.
        std: ``(N,)``, standard error of each from the noise of its pose.
        fitted: ``(N,)``, what the effect says.
        curve: ``(3, G)``, x, the effect and its standard error, or None where it is no function of x alone.
        side: ``(N,)``, -1 or 1, or None: two kinds of pose.
        mark: A value of x to be marked: a moment of change.
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
    """What is asked of an effect over two variables.

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


@dataclass(frozen=True, eq=False)
class View:
    """A state with what its pictures need, taken once.

    Attributes:
        state: With all effects.
        covariance: ``(F, F)`` of the parameters named ``free``, for the error of curves.
        kinematics: At the state.
        residual: ``(N, m)``, whitened: model less measurement.
        wrench: ``(N, m, 6)``, its derivative by a screw of the sensor in the base frame.
    """

    state: FittedState
    free: tuple[str, ...]
    covariance: Array
    kinematics: Kinematics = field(repr=False)
    residual: Array = field(repr=False)
    wrench: Array = field(repr=False)

    @cached_property
    def gram(self) -> Array:
        """Return the Gram matrix ``(F, F)`` of the whitened columns of all that is free."""
        jacobian = self.state.linearised()[1]
        return jacobian.T @ jacobian

    @classmethod
    def of(cls, state: FittedState, free: tuple[str, ...], covariance: Array) -> View:
        """Return the view of a state, with the covariance of what its final fit has free."""
        kinematics = state.residuals.kinematics(state.model)
        T, effects = kinematics.T_base_sensor, state.residuals.point_effects(state.model)
        rows = state.residuals.measurement.rows(T, state.model.target, effects)
        return cls(state, free, covariance, kinematics, rows.residual, rows.wrench)

    @property
    def poses(self) -> Poses:
        """Return what is known of each pose."""
        return self.state.residuals.poses

    def asked(self, screws: Array) -> tuple[Array, Array]:
        """Return what each pose asks of a motion beyond the model, with standard errors, ``(N,)`` each.

        Args:
            screws: ``(N, 6)`` in the base frame, a unit.
        """
        g = np.einsum("nmi,ni->nm", self.wrench, screws)
        squared = np.sum(g * g, axis=1)
        seen = squared > 1e-12 * max(float(np.max(squared, initial=0.0)), 1e-300)
        safe = np.where(seen, squared, 1.0)
        rest = np.where(seen, -np.sum(g * self.residual, axis=1) / safe, np.nan)
        return rest, np.where(seen, 1.0 / np.sqrt(safe), np.nan)

    def error_of(self, effect: Effect, basis: Array) -> Array:
        """Return the standard error ``(G,)`` of ``basis @ coefficients``, basis ``(G, k)``."""
        k = len(effect.coefficients)
        C = np.zeros((k, k))
        at = {name: i for i, name in enumerate(self.free)}
        known = [(i, at[name]) for i, name in enumerate(effect.parameter_names) if name in at]
        if known:
            mine, all_ = np.array(known).T
            C[np.ix_(mine, mine)] = self.covariance[np.ix_(all_, all_)]
        return np.sqrt(np.maximum(np.einsum("gi,ij,gj->g", basis, C, basis), 0.0))


def angle_axis(joint: int) -> Axis:
    """Return the axis of a joint's angle."""
    return Axis(f"angle of joint {joint}", "rad")


def variable_axis(name: str) -> Axis:
    """Return the axis of a column of poses.csv."""
    if is_joint(name):
        return angle_axis(int(name[1:]))
    unit = {"time": "s", "temperature": "degC"}.get(name, "")
    return Axis("order of acquisition" if name == "order" else name, unit)
