"""The columns of a model's effects at given poses, sorted by the place where each effect acts.

An effect adds ``basis @ coefficients`` to joint angles, to link geometry, or to a small motion of the base or of the sensor.
The bases do not depend on the coefficients, so they are computed once and serve every step of a fit.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from scalar.data.poses import Poses
from scalar.effects import BaseEffect, Effect, JointEffect, LinkEffect, SingleJointEffect
from scalar.effects.checked_basis import checked_basis
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import Array


@dataclass(frozen=True, eq=False)
class JointBasis:
    """The columns of an effect on joints, kept only for the joints on which it acts: usually one.

    Attributes:
        n_columns: k.
        parts: (joint from 0, ``(N, k)`` [rad per unit]) for each joint that moves.
    """

    n_columns: int
    parts: tuple[tuple[int, Array], ...]

    @classmethod
    def of_effect(cls, effect: JointEffect, basis: Array) -> JointBasis:
        """Return the parts of an effect with the basis that ``checked_basis`` returns for it."""
        if isinstance(effect, SingleJointEffect):
            return cls(basis.shape[1], ((effect.joint - 1, basis),))
        return cls.of(basis)

    @classmethod
    def of(cls, basis: Array) -> JointBasis:
        """Return the parts of a basis ``(N, n, k)``."""
        acting = [j for j in range(basis.shape[1]) if basis[:, j].any()]
        return cls(basis.shape[2], tuple((j, basis[:, j].copy()) for j in acting))

    def added(self, q: Array, coefficients: Array) -> Array:
        """Return joint angles ``(N, n)`` [rad] with the effect added."""
        q = q.copy()
        for j, basis in self.parts:
            q[:, j] += basis @ coefficients
        return q

    def columns(self, by_angle: Array) -> Array:
        """Return the derivatives ``(N, m, k)`` of m quantities by the coefficients.

        Args:
            by_angle: ``(N, m, n)``, the derivatives of the same quantities by the joint angles [per rad].
        """
        columns = np.zeros((*by_angle.shape[:2], self.n_columns))
        for j, basis in self.parts:
            columns += by_angle[:, :, j, None] * basis[:, None, :]
        return columns


@dataclass(frozen=True, eq=False)
class EffectBases:
    """The columns of a model's effects at given poses, computed once with the nominal robot.

    Attributes:
        joints, links, base, sensor: (basis, slice of the effects' coefficients) for each effect that acts there.
    """

    joints: list[tuple[JointBasis, slice]]
    links: list[tuple[Array, slice]]
    base: list[tuple[Array, slice]]
    sensor: list[tuple[Array, slice]]

    @classmethod
    def of(cls, nominal: Robot, poses: Poses, effects: Sequence[Effect]) -> EffectBases:
        """Return the columns of the effects."""
        bases = cls([], [], [], [])
        start = 0
        for effect in effects:
            where = slice(start, start + len(effect.coefficients))
            start = where.stop
            basis = checked_basis(effect, nominal, poses)
            if basis is None:
                continue
            if isinstance(effect, JointEffect):
                bases.joints.append((JointBasis.of_effect(effect, basis), where))
            elif isinstance(effect, LinkEffect):
                bases.links.append((basis, where))
            elif isinstance(effect, BaseEffect):
                bases.base.append((basis, where))
            else:
                bases.sensor.append((basis, where))
        return bases

    @property
    def act(self) -> bool:
        """Return whether any coefficient moves the arm at any of the poses."""
        on_joints = any(column.any() for basis, _ in self.joints for _, column in basis.parts)
        return on_joints or any(basis.any() for basis, _ in (*self.links, *self.base, *self.sensor))
