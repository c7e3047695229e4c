"""The model that is fitted: a robot, a sensor on its flange, a target, and effects; and its coordinates.

A point of the model's manifold is reached from a reference by a flat vector: the geometry as it is, the sensor's translation and
a rotation vector about its reference rotation, the target's coordinates, the effects' coefficients. One order of names serves
everywhere: ``a_1 .. beta_n, sensor_x .. sensor_rz, normal_<plane>_u .., <effect>.<coefficient>``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import accumulate

import numpy as np

from scalar.data.poses import Poses
from scalar.effects.effect import BaseEffect, Effect, JointEffect, LinkEffect, SensorEffect
from scalar.geometry.robot import GEOMETRY, LENGTHS, Robot
from scalar.geometry.se3 import Array, exp_screw, exp_so3, left_jacobian_so3, log_so3, skew, transform
from scalar.sensors.measurement import Target

SENSOR_PARAMETERS = ("sensor_x", "sensor_y", "sensor_z", "sensor_rx", "sensor_ry", "sensor_rz")


@dataclass(frozen=True)
class Anchor:
    """A parameter that the data determine no better than the data sheet does: one row ``(x - value) / std`` keeps it near.

    Attributes:
        name: Of the parameter.
        value: Where the data sheet has it [m or rad].
        std: How far it may plausibly be from there, in units in which the residual's misfit counts as noise.
        reason: A sentence.
    """

    name: str
    value: float
    std: float
    reason: str


@dataclass(frozen=True, eq=False)
class Model:
    """Robot, sensor, target and effects at one point of their manifold.

    Attributes:
        robot: The arm, its geometry as estimated.
        nominal: The arm as the data sheet has it; the effects' columns are taken there.
        reference_rotation: ``(3, 3)``, of the sensor on the flange.
        sensor: ``(6,)``, translation [m] and rotation vector [rad] about the reference: ``R = exp(r) R_reference``.
        target: Planes or tracker frames.
        effects: With their coefficients.
        anchors: What keeps parameters near the data sheet that the data hardly see.
    """

    robot: Robot
    nominal: Robot
    reference_rotation: Array
    sensor: Array
    target: Target
    effects: tuple[Effect, ...] = ()
    anchors: tuple[Anchor, ...] = ()

    @classmethod
    def at(
        cls, nominal: Robot, T_flange_sensor: Array, target: Target, effects: Sequence[Effect] = ()
    ) -> Model:
        """Return the model of a nominal robot with a sensor at ``T_flange_sensor`` ``(4, 4)``."""
        sensor = np.r_[T_flange_sensor[:3, 3], 0.0, 0.0, 0.0]
        return cls(nominal, nominal, T_flange_sensor[:3, :3].copy(), sensor, target, tuple(effects))

    @property
    def T_flange_sensor(self) -> Array:
        """Return the sensor's pose on the flange ``(4, 4)``."""
        return transform(exp_so3(self.sensor[3:]) @ self.reference_rotation, self.sensor[:3])

    @cached_property
    def names(self) -> list[str]:
        """Return the name of every coordinate."""
        effects = [name for effect in self.effects for name in effect.parameter_names]
        return [*self.robot.parameter_names, *SENSOR_PARAMETERS, *self.target.parameter_names, *effects]

    @cached_property
    def units(self) -> list[str]:
        """Return the unit of every coordinate."""
        n = self.robot.n_joints
        geometry = ["m" if kind in LENGTHS else "rad" for kind in GEOMETRY for _ in range(n)]
        effects = [unit for effect in self.effects for unit in effect.coefficient_units]
        return [*geometry, "m", "m", "m", "rad", "rad", "rad", *self.target.parameter_units, *effects]

    @cached_property
    def blocks(self) -> dict[str, slice]:
        """Return where ``geometry``, ``sensor``, ``target`` and ``effects`` stand in the vector."""
        coefficients = sum(len(effect.coefficients) for effect in self.effects)
        sizes = {
            "geometry": self.robot.geometry.size,
            "sensor": len(self.sensor),
            "target": len(self.target.vector),
            "effects": coefficients,
        }
        ends = accumulate(sizes.values())
        return {name: slice(end - sizes[name], end) for name, end in zip(sizes, ends, strict=True)}

    @property
    def vector(self) -> Array:
        """Return the coordinates ``(P,)``, in the order of the names."""
        effects = [effect.coefficients for effect in self.effects]
        return np.concatenate([self.robot.geometry.ravel(), self.sensor, self.target.vector, *effects])

    def with_vector(self, vector: Array) -> Model:
        """Return the model at other coordinates ``(P,)`` about the same references."""
        blocks = self.blocks
        rest = vector[blocks["effects"]]
        effects = []
        for effect in self.effects:
            k = len(effect.coefficients)
            effects.append(effect.with_coefficients(rest[:k]))
            rest = rest[k:]
        return replace(
            self,
            robot=self.robot.with_geometry(vector[blocks["geometry"]].reshape(len(GEOMETRY), -1)),
            sensor=np.array(vector[blocks["sensor"]]),
            target=self.target.with_vector(vector[blocks["target"]]),
            effects=tuple(effects),
        )

    def rebased(self) -> Model:
        """Return the same model with rotations and normals counted from where they are."""
        T = self.T_flange_sensor
        sensor = np.r_[self.sensor[:3], 0.0, 0.0, 0.0]
        return replace(self, reference_rotation=T[:3, :3], sensor=sensor, target=self.target.rebased())

    def sensor_rotation_vector(self) -> Array:
        """Return the absolute rotation vector ``(3,)`` [rad] of the sensor on the flange."""
        return log_so3(self.T_flange_sensor[:3, :3])


@dataclass(frozen=True, eq=False)
class JointBasis:
    """The columns of an effect on joints, of the joints that it acts on alone: most act on one of many.

    Attributes:
        n_columns: k.
        parts: (joint from 0, ``(N, k)`` [rad per unit]) for each joint that moves.
    """

    n_columns: int
    parts: tuple[tuple[int, Array], ...]

    @classmethod
    def of(cls, basis: Array) -> JointBasis:
        """Return the parts of a basis ``(N, n, k)``."""
        acting = np.flatnonzero(np.any(basis != 0, axis=(0, 2)))
        return cls(basis.shape[2], tuple((int(j), basis[:, j].copy()) for j in acting))

    def added(self, q: Array, coefficients: Array) -> Array:
        """Return joint angles ``(N, n)`` [rad] with the effect's."""
        q = q.copy()
        for j, basis in self.parts:
            q[:, j] += basis @ coefficients
        return q

    def columns(self, by_angle: Array) -> Array:
        """Return the derivatives ``(N, m, k)`` by the coefficients, where those by the angles are ``by_angle`` ``(N, m, n)``."""
        columns = np.zeros((*by_angle.shape[:2], self.n_columns))
        for j, basis in self.parts:
            columns += by_angle[:, :, j, None] * basis[:, None, :]
        return columns


@dataclass(frozen=True, eq=False)
class EffectBases:
    """The columns of a model's effects at given poses, taken at the nominal robot once and for all.

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
            if isinstance(effect, JointEffect):
                bases.joints.append((JointBasis.of(effect.joint_basis(nominal, poses)), where))
            elif isinstance(effect, LinkEffect):
                bases.links.append((effect.geometry_basis(nominal, poses), where))
            elif isinstance(effect, BaseEffect):
                bases.base.append((effect.base_screws(nominal, poses), where))
            elif isinstance(effect, SensorEffect):
                bases.sensor.append((effect.sensor_screws(nominal, poses), where))
        return bases


@dataclass(frozen=True, eq=False)
class Kinematics:
    """Where the sensor is in N poses, and how it moves with every coordinate of the model.

    Attributes:
        model: At which all was taken.
        frames: ``(N, n + 1, 4, 4)``.
        geometry_offsets: ``(N, 5, n)`` or None.
        T_base_tilted: ``(N, 4, 4)`` or None: the motion of the base by effects.
        T_base_held: ``(N, 4, 4)``: where the sensor would be if it had not moved on the flange.
        T_base_sensor: ``(N, 4, 4)``.
    """

    model: Model
    bases: EffectBases
    frames: Array
    geometry_offsets: Array | None
    T_base_tilted: Array | None
    T_base_held: Array
    T_base_sensor: Array

    @classmethod
    def of(cls, model: Model, poses: Poses, bases: EffectBases) -> Kinematics:
        """Return the kinematics of a model at poses."""
        c = np.concatenate([np.zeros(0), *(effect.coefficients for effect in model.effects)])
        q = poses.q
        for basis, where in bases.joints:
            q = basis.added(q, c[where])
        offsets = None
        for basis, where in bases.links:
            step = basis @ c[where]
            offsets = step if offsets is None else offsets + step
        frames = model.robot.frames(q, offsets)
        T = frames[:, -1] @ (model.robot.T_n_flange @ model.T_flange_sensor)
        T_tilted = None
        for basis, where in bases.base:
            step = exp_screw(basis @ c[where])
            T_tilted = step if T_tilted is None else T_tilted @ step
        if T_tilted is not None:
            T = T_tilted @ T
        T_held = T
        for basis, where in bases.sensor:
            T = T @ exp_screw(basis @ c[where])
        return cls(model, bases, frames, offsets, T_tilted, T_held, T)

    def screws(self, *, joint_effects: bool = True) -> Array:
        """Return the screw of the sensor, in the base frame, by every coordinate of robot, sensor and effects.

        Args:
            joint_effects: Whether those by effects on joints are wanted; else they are left zero.

        Returns:
            ``(N, 6, P)`` in the order of ``Model.names``; zero for the target's coordinates and for effects on points.
        """
        model, blocks = self.model, self.model.blocks
        N = len(self.frames)
        screws = np.zeros((N, 6, blocks["effects"].stop))
        geometry = model.robot.screws(self.frames, self.geometry_offsets)
        flange_R = self.frames[:, -1, :3, :3] @ model.robot.T_n_flange[:3, :3]
        if self.T_base_tilted is not None:
            geometry = moved(self.T_base_tilted, geometry)
            flange_R = self.T_base_tilted[:, :3, :3] @ flange_R
        screws[:, :, blocks["geometry"]] = geometry
        at = blocks["sensor"].start
        screws[:, 3:, at : at + 3] = flange_R
        turns = flange_R @ left_jacobian_so3(model.sensor[3:])
        screws[:, :, at + 3 : at + 6] = rotations_about(turns, self.T_base_held[:, :3, 3])
        start, n = blocks["effects"].start, model.robot.n_joints
        by_angle = geometry[:, :, 3 * n : 4 * n]
        for basis, where in self.bases.joints if joint_effects else []:
            screws[:, :, start + where.start : start + where.stop] = basis.columns(by_angle)
        for basis, where in self.bases.links:
            flat = basis.reshape(N, -1, basis.shape[-1])
            screws[:, :, start + where.start : start + where.stop] = geometry @ flat
        c = model.vector[blocks["effects"]]
        for places, T in ((self.bases.base, None), (self.bases.sensor, self.T_base_held)):
            for basis, where in places:
                step = basis @ c[where]
                by_coefficient = derived(step, basis)
                screws[:, :, start + where.start : start + where.stop] = (
                    by_coefficient if T is None else moved(T, by_coefficient)
                )
                if len(places) > 1:  # the next of the same place acts where this one has brought it
                    T = exp_screw(step) if T is None else T @ exp_screw(step)
        return screws


def derived(screw: Array, by_parameter: Array) -> Array:
    """Return the screws ``(N, 6, k)`` by which ``exp_screw`` of ``screw`` ``(N, 6)`` moves with what the screw depends on.

    A point stands at ``p = exp(w) p_0 + v``, so ``dp = (J_l dw) x (p - v) + dv``.

    Args:
        screw: (w, v) as it is.
        by_parameter: ``(N, 6, k)``, its derivatives.
    """
    if not screw.any():
        return by_parameter
    w = left_jacobian_so3(screw[:, :3]) @ by_parameter[:, :3]
    return np.concatenate([w, by_parameter[:, 3:] + skew(screw[:, 3:]) @ w], axis=1)


def moved(T: Array, screws: Array) -> Array:
    """Return screws ``(N, 6, k)`` given in frame b, in frame a, where ``T_a_b`` is ``(N, 4, 4)``: the adjoint action."""
    R, t = T[:, :3, :3], T[:, :3, 3]
    w = R @ screws[:, :3]
    v = R @ screws[:, 3:]
    return np.concatenate([w, v + skew(t) @ w], axis=1)


def rotations_about(axes: Array, points: Array) -> Array:
    """Return the screws ``(N, 6, k)`` of rotations about ``axes`` ``(N, 3, k)`` through ``points`` ``(N, 3)``."""
    return np.concatenate([axes, skew(points) @ axes], axis=1)
