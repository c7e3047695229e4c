"""Where the sensor is in each pose under a model, and how it moves with every parameter of the model."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from scalar import kernels
from scalar.data.poses import Poses
from scalar.estimation.effect_bases import EffectBases
from scalar.estimation.model import Model
from scalar.geometry.screws import change_frame, exp_screw, exp_screw_derivative, rotations_about
from scalar.geometry.se3 import Array, left_jacobian_so3
from scalar.kernels.chain import ends

_MOST_KEPT = 4_000_000  # bytes of screws that are kept; those of thousands of poses are computed anew


@dataclass(frozen=True, eq=False)
class Kinematics:
    """Where the sensor is in N poses, and how it moves with every coordinate of the model.

    Attributes:
        model: The model at which everything below is computed.
        bases: The columns of the model's effects at these poses.
        q: ``(N, n)`` [rad], joint angles with what effects add to them.
        geometry_offsets: ``(N, 5, n)`` [m, rad] or None: what effects add to ``Robot.geometry``.
        T_base_tilted: ``(N, 4, 4)`` or None: the motion of the base that effects cause.
        T_base_mount: ``(N, 4, 4)``: where the sensor would be without effects on the sensor.
        T_base_sensor: ``(N, 4, 4)``.
    """

    model: Model
    bases: EffectBases
    q: Array
    geometry_offsets: Array | None
    T_base_tilted: Array | None
    T_base_mount: Array
    T_base_sensor: Array
    _kept: list[Array] = field(default_factory=list, init=False, repr=False)

    @classmethod
    def of(cls, model: Model, poses: Poses, bases: EffectBases) -> Kinematics:
        """Return the kinematics of a model at N poses.

        Args:
            model: Robot, sensor and effects.
            poses: With joint angles ``(N, n)`` [rad].
            bases: The columns of the model's effects at these poses.
        """
        c = np.concatenate([np.zeros(0), *(effect.coefficients for effect in model.effects)])
        q = poses.q
        for basis, where in bases.joints:
            q = basis.added(q, c[where])
        offsets = None
        for basis, where in bases.links:
            step = basis @ c[where]
            offsets = step if offsets is None else offsets + step
        robot, T_n_sensor = model.robot, model.robot.T_n_flange @ model.T_flange_sensor
        frames: Array | None = None
        if kernels.LIBRARY is None or bases.joints or bases.links or robot.prismatic:
            frames = robot.frames(q, offsets)
            T = frames[:, -1] @ T_n_sensor
        else:
            T = ends(poses.turned, robot.geometry, robot.T_base_0, T_n_sensor)
        T_tilted = None
        for basis, where in bases.base:
            step = exp_screw(basis @ c[where])
            T_tilted = step if T_tilted is None else T_tilted @ step
        if T_tilted is not None:
            T = T_tilted @ T
        T_mount = T
        for basis, where in bases.sensor:
            T = T @ exp_screw(basis @ c[where])
        found = cls(model, bases, q, offsets, T_tilted, T_mount, T)
        if frames is not None:
            vars(found)["frames"] = frames  # in the place of the cached property
        return found

    @cached_property
    def frames(self) -> Array:
        """Return the frames of the base and of every link ``(N, n + 1, 4, 4)``, in the base frame before effects move the base."""
        return self.model.robot.frames(self.q, self.geometry_offsets)

    def screws(self, *, joint_effects: bool = True) -> Array:
        """Return the derivative of the sensor's pose by every coordinate of robot, sensor and effects, as a screw in the base frame.

        Args:
            joint_effects: Whether to compute the columns of effects on joints; else they are zero.

        Returns:
            ``(N, 6, P)``, rotation then translation at the base origin, in the order of ``Model.names``; zero for the target's coordinates
            and for effects on points. Without joint effects the array is read-only, since it is kept for the next caller unless it is large.
        """
        if joint_effects:
            return self._screws(joint_effects=True)
        if self._kept:
            return self._kept[0]
        found = self._screws(joint_effects=False)
        found.flags.writeable = False
        if found.nbytes <= _MOST_KEPT:
            self._kept.append(found)
        return found

    def _screws(self, *, joint_effects: bool) -> Array:
        """Return what ``screws`` returns, computed anew."""
        model, blocks = self.model, self.model.blocks
        N, size = len(self.frames), model.robot.geometry.size
        screws = model.robot.screws(self.frames, self.geometry_offsets, blocks["effects"].stop - size)
        geometry = screws[:, :, blocks["geometry"]]
        flange_R = self.frames[:, -1, :3, :3] @ model.robot.T_n_flange[:3, :3]
        if self.T_base_tilted is not None:
            geometry[:] = change_frame(self.T_base_tilted, geometry)
            flange_R = self.T_base_tilted[:, :3, :3] @ flange_R
        at = blocks["sensor"].start
        screws[:, 3:, at : at + 3] = flange_R
        turns = flange_R @ left_jacobian_so3(model.sensor[3:])
        screws[:, :, at + 3 : at + 6] = rotations_about(turns, self.T_base_mount[:, :3, 3])
        start = blocks["effects"].start
        by_joint = geometry[:, :, model.robot.joint_columns]
        for basis, where in self.bases.joints if joint_effects else []:
            screws[:, :, start + where.start : start + where.stop] = basis.columns(by_joint)
        for basis, where in self.bases.links:
            flat = basis.reshape(N, -1, basis.shape[-1])
            screws[:, :, start + where.start : start + where.stop] = geometry @ flat
        c = model.vector[blocks["effects"]]
        for places, T in ((self.bases.base, None), (self.bases.sensor, self.T_base_mount)):
            for basis, where in places:
                step = basis @ c[where]
                by_coefficient = exp_screw_derivative(step, basis)
                screws[:, :, start + where.start : start + where.stop] = (
                    by_coefficient if T is None else change_frame(T, by_coefficient)
                )
                if len(places) > 1:  # the next effect at this place acts on the frame that this one has moved
                    T = exp_screw(step) if T is None else T @ exp_screw(step)
        return screws
