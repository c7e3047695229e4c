"""Where effects act: on the joints' angles, the links' geometry, the base, the sensor on the flange, or the measured points.

The place decides how an effect's columns enter the model. An effect changes a joint angle, a geometric parameter or the pose of base or sensor by
``columns @ coefficients``; the model applies this change exactly, and its derivative is the screw of what is changed times the column.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from scalar.data.poses import Poses
from scalar.effects.command_words import joints_named
from scalar.effects.effect import Effect
from scalar.effects.joint_pictures import along_joint
from scalar.effects.picture import Map, Profile, View
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import Array

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset


class OneJoint(Effect):
    """An effect whose target is one joint and nothing else: a dataclass field ``joint``, counted from 1."""

    joint: int

    @property
    def target(self) -> dict[str, Any]:
        """Return the joint."""
        return {"joint": self.joint}

    def to_mapping(self) -> dict[str, Any]:
        """Return the joint."""
        return {"joint": self.joint}

    @classmethod
    def from_mapping(cls, mapping: Mapping[str, Any]) -> Self:
        """Return the effect of ``to_mapping``."""
        return cls(joint=int(mapping["joint"]))  # type: ignore[call-arg]

    @classmethod
    def parsed(cls, dataset: Dataset, words: Sequence[str]) -> list[Effect]:
        """Return the effect of the joint that is named, or of every joint."""
        return [cls(joint=j) for j in joints_named(dataset, words)]  # type: ignore[call-arg]


class OneAxis(OneJoint):
    """An effect of one joint, which may turn or slide: a further dataclass field ``slides`` says which."""

    slides: bool

    def to_mapping(self) -> dict[str, Any]:
        """Return the joint, and that it slides if it does."""
        return super().to_mapping() | ({"slides": True} if self.slides else {})

    @classmethod
    def from_mapping(cls, mapping: Mapping[str, Any]) -> Self:
        """Return the effect of ``to_mapping``."""
        return cls(joint=int(mapping["joint"]), slides=bool(mapping.get("slides", False)))  # type: ignore[call-arg]

    @classmethod
    def of(cls, dataset: Dataset, joint: int) -> Self:
        """Return the effect of a joint of a dataset, from 1."""
        return cls(joint=joint, slides=bool(dataset.robot.slides[joint - 1]))  # type: ignore[call-arg]

    @classmethod
    def parsed(cls, dataset: Dataset, words: Sequence[str]) -> list[Effect]:
        """Return the effect of the joint that is named, or of every joint."""
        return [cls.of(dataset, j) for j in joints_named(dataset, words)]


class JointEffect(Effect):
    """An error of the joint angles, ``dq = B c``: the arm stands at ``q + dq`` where the encoders read q.

    A class whose joint may slide has a field ``slides``; its error is then one of the joint's travel.
    """

    acts_on_arm: ClassVar[bool] = True

    @abstractmethod
    def joint_basis(self, robot: Robot, poses: Poses) -> Array:
        """Return B ``(N, n, k)`` [rad per unit; m per unit of a travel]; ``robot`` is the nominal one."""

    @property
    def joint_unit(self) -> str:
        """Return the unit of the joint's position, ``rad`` or ``m``."""
        return "m" if getattr(self, "slides", False) else "rad"

    @property
    def joint_position(self) -> str:
        """Return what the joint's position is called: its angle, or its travel."""
        return "travel" if getattr(self, "slides", False) else "angle"

    @property
    def erring_joint(self) -> int | None:
        """Return the joint whose angle or travel errs, from 1; None for an effect of several joints."""
        return getattr(self, "joint", None)

    def pictures(self, view: View) -> list[Profile | Map]:
        """Return the error of the joint over its own angle where it is a function of that, else the added-variable plot."""
        if self.own_angle_joint is None:
            return super().pictures(view)
        return [along_joint(view, self, self.own_angle_joint, self.own_angle_joint)]


class SingleJointEffect(JointEffect):
    """An error of the position of one joint alone, ``joint`` from 1: its columns are those of that joint, so that no others need be stored."""

    joint: int

    @abstractmethod
    def own_columns(self, robot: Robot, poses: Poses) -> Array:
        """Return the columns ``(N, k)`` [rad per unit; m per unit of a travel] of the joint; ``robot`` is the nominal one."""

    def joint_basis(self, robot: Robot, poses: Poses) -> Array:
        """Return the joint's columns among those of all joints."""
        own = self.own_columns(robot, poses)
        B = np.zeros((len(poses), robot.n_joints, own.shape[1]))
        B[:, self.joint - 1] = own
        return B


class LinkEffect(Effect):
    """A change of the geometric parameters, pose by pose."""

    acts_on_arm: ClassVar[bool] = True

    def constant_and_shares(self, poses: Poses) -> tuple[LinkEffect, Array] | None:
        """Return an effect that acts alike at all poses and the shares of it ``(N,)`` that act at each, if this effect is their product; else None.

        Many candidates may be shares of effects with the same ``key``, whose columns are then computed once.
        """
        return None

    @abstractmethod
    def geometry_basis(self, robot: Robot, poses: Poses) -> Array:
        """Return the change ``(N, 5, n, k)`` of ``Robot.geometry`` [m or rad per unit]."""


class BaseEffect(Effect):
    """A motion of the whole arm: its transform is the leftmost, ``T_base_sensor = T_effect T_base_flange T_flange_sensor``."""

    acts_on_arm: ClassVar[bool] = True

    @abstractmethod
    def base_screws(self, robot: Robot, poses: Poses) -> Array:
        """Return screws ``(N, 6, k)`` in the base frame [rad, m per unit]."""


class SensorEffect(Effect):
    """A motion of the sensor on the flange: its transform is the rightmost, ``T_base_sensor = T_base_flange T_flange_sensor T_effect``."""

    @abstractmethod
    def sensor_screws(self, robot: Robot, poses: Poses) -> Array:
        """Return screws ``(N, 6, k)`` in the sensor's frame [rad, m per unit]."""


class PointEffect(Effect):
    """An error of the measured points or of the surface: it adds functions of the points to the residual.

    ``f_i += sum_b basis_b(p_i) (G c)_b`` for point p_i, with coefficients c and the functions that ``scalar.sensors.profile.point_basis`` knows by
    the names in ``basis_names``. Predicted poses do not depend on such an effect.
    """

    acts_by_joint_angles: ClassVar[bool] = False
    basis_names: ClassVar[tuple[str, ...]]

    def constant_and_shares(self, poses: Poses) -> tuple[PointEffect, Array] | None:
        """Return an effect that acts alike at all poses and the shares of it ``(N,)`` that act at each, if this effect is their product; else None.

        Many candidates may be shares of the same effect, whose columns are then computed once.
        """
        return None

    @abstractmethod
    def contact_columns(
        self, poses: Poses, T_base_sensor: Array, planes: Any, plane_index: Array, contact: Array
    ) -> Array:
        """Return G ``(N, len(basis_names), k)`` [m per unit of the coefficients, for the functions of the basis].

        Args:
            poses: What is known of each pose.
            T_base_sensor: ``(N, 4, 4)``.
            planes: The target planes, ``scalar.geometry.planes.Planes``.
            plane_index: ``(N,)``, which plane each pose measures.
            contact: ``(N, 3)``, the height of the sensor's origin over its plane [m], and the plane's normal along the sensor's x and z axes;
                ``(N, 1)``, the height alone, for a probe. For an instrument that measures positions, ``(N, 3 K)``, those of K targets in its frame
                [m]; G is then ``(N, 3 K, k)``, the error of these positions, and there are neither planes nor a basis.
        """
