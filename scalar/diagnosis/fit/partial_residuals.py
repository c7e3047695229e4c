"""Partial residuals of a fitted model: the size of one effect that each pose shows, for the picture of that effect.

Let r be a pose's whitened residual, and g its derivative by a quantity that an effect changes (a joint's angle, the growth of all lengths, the height
of a plane). The change of that quantity that fits the pose best is ``-g . r / g . g``, with the standard error ``1 / |g|``. Its sum with the change
that the effect predicts at that pose is the partial residual: the change that the pose would show if only this effect were missing from the model.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from scalar.data.poses import Poses
from scalar.diagnosis.fit.added_variable import added_variable, share_left
from scalar.diagnosis.fit.fitted_state import FittedState
from scalar.diagnosis.fit.scan_residuals import pieces
from scalar.effects import Effect
from scalar.effects.picture import Profile
from scalar.estimation.kinematics import Kinematics
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import Array
from scalar.sensors import Pieces


@dataclass(frozen=True, eq=False)
class FittedView:
    """A state with what pictures of its effects need, computed once; it fulfils the protocol ``scalar.effects.picture.View``.

    Attributes:
        state: The state with all effects.
        free: Names of the F free parameters of the final fit.
        covariance: ``(F, F)``, their covariance, from which the error bands of curves follow.
        kinematics: Kinematics of the state's model at the poses.
        residual: ``(N, m)``, whitened.
        wrench: ``(N, m, 6)``, derivatives of the residual by a screw of the sensor in the base frame.
    """

    state: FittedState
    free: tuple[str, ...]
    covariance: Array
    kinematics: Kinematics = field(repr=False)
    residual: Array = field(repr=False)
    wrench: Array = field(repr=False)

    @classmethod
    def of(cls, state: FittedState, free: tuple[str, ...], covariance: Array) -> FittedView:
        """Return the view of a state, with the covariance of the free parameters of its final fit."""
        kinematics = state.residuals.kinematics(state.model)
        T, effects = kinematics.T_base_sensor, state.residuals.point_effects(state.model)
        rows = state.residuals.measurement.rows(T, state.model.target, effects)
        return cls(state, free, covariance, kinematics, rows.residual, rows.wrench)

    @cached_property
    def gram(self) -> Array:
        """Return the Gram matrix ``(F, F)`` of the whitened columns of all that is free."""
        jacobian = self.state.linearised()[1]
        return jacobian.T @ jacobian

    @cached_property
    def _screws(self) -> Array:
        return self.kinematics.screws()

    @property
    def poses(self) -> Poses:
        """Return what is known of each pose."""
        return self.state.residuals.poses

    @property
    def nominal(self) -> Robot:
        """Return the nominal robot."""
        return self.state.model.nominal

    @property
    def T_base_sensor(self) -> Array:
        """Return the fitted pose of the sensor in the base frame at every pose ``(N, 4, 4)``."""
        return self.kinematics.T_base_sensor

    def joint_screws(self, joint: int) -> Array:
        """Return the screw of the sensor in the base frame ``(N, 6)`` per unit of a joint's angle, as of its theta; joints count from 1."""
        return self._screws[:, :, 3 * self.state.model.robot.n_joints + joint - 1]

    def geometry_screws(self) -> Array:
        """Return the screws of the sensor in the base frame ``(N, 6, 5 n)`` per unit of every geometric parameter."""
        return self._screws[:, :, : self.nominal.geometry.size]

    def estimated_along(self, screws: Array) -> tuple[Array, Array]:
        """Return the multiple of a motion of the sensor that fits each pose best, and its standard error, ``(N,)`` each; NaN if it changes no row.

        Args:
            screws: ``(N, 6)``, the motion at each pose as a screw in the base frame.
        """
        g = np.einsum("nmi,ni->nm", self.wrench, screws)
        squared_lengths = np.sum(g * g, axis=1)
        seen = squared_lengths > 1e-12 * max(float(np.max(squared_lengths, initial=0.0)), 1e-300)
        safe = np.where(seen, squared_lengths, 1.0)
        rest = np.where(seen, -np.sum(g * self.residual, axis=1) / safe, np.nan)
        return rest, np.where(seen, 1.0 / np.sqrt(safe), np.nan)

    def error_of(self, effect: Effect, basis: Array) -> Array:
        """Return the standard error ``(G,)`` of ``basis @ coefficients``, basis ``(G, k)``."""
        k = len(effect.coefficients)
        C = np.zeros((k, k))
        at = {name: i for i, name in enumerate(self.free)}
        known = [(i, at[name]) for i, name in enumerate(self._names_of(effect)) if name in at]
        if known:
            mine, all_ = np.array(known).T
            C[np.ix_(mine, mine)] = self.covariance[np.ix_(all_, all_)]
        return np.sqrt(np.maximum(np.einsum("gi,ij,gj->g", basis, C, basis), 0.0))

    def _names_of(self, effect: Effect) -> tuple[str, ...]:
        """Return the names of an effect's coefficients in the calibration; an empty tuple for an effect that the state does not have."""
        names = self.state.model.effect_names
        return next((names[i] for i, own in enumerate(self.state.effects) if own is effect), ())

    def pieces(self, effect: Effect) -> Pieces:
        """Return the measured heights over the planes, and what one of the state's effects on points adds to them."""
        return pieces(self.state, effect)

    def on_plane(self, plane: str) -> Array:
        """Return which poses measure a plane, ``(N,)`` bool."""
        dataset = self.state.dataset
        return dataset.plane_index == [guess.name for guess in dataset.planes].index(plane)

    def normal_of(self, plane: str) -> Array:
        """Return the unit normal of a plane as fitted ``(3,)``; of the first session where there are several."""
        planes: Any = self.state.model.target
        k = next(i for i, name in enumerate(planes.names) if plane in (name, name.split("@")[0]))
        return planes.normals[k]

    def added_variable(self, effect: Effect) -> Profile:
        """Return the added-variable plot of one of the state's effects."""
        return added_variable(self.state, self._index(effect), self.residual)

    def share_left(self, effect: Effect) -> float:
        """Return the share, 0 to 1, of the signal of one of the state's effects that no other parameter can absorb."""
        return share_left(self.state, self._index(effect), self.gram)

    def _index(self, effect: Effect) -> int:
        """Return the index of one of the state's effects, which must be the same object."""
        return next(i for i, own in enumerate(self.state.effects) if own is effect)
