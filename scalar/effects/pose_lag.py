"""A joint whose angle was not logged at the moment of the measurement, while the joint still moved: it errs by a share of the last step."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from scalar.data.moves import step_column
from scalar.data.poses import Poses
from scalar.effects.acquisition import moving_joints, steps_are_known
from scalar.effects.effect import Effect
from scalar.effects.joint_pictures import joint_profile
from scalar.effects.picture import Axis, Map, Profile, View
from scalar.effects.places import OneAxis, SingleJointEffect
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import Array

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset


@dataclass(frozen=True, eq=False)
class PoseLag(OneAxis, SingleJointEffect):
    """A joint's angle or travel was logged while the joint still moved: ``dq_j = s (q_j - q_j of the previous pose)``.

    The share s is positive if the joint moved on between logging and measuring, negative if the angle was logged after the measurement. A
    joint that comes to rest exponentially with the time constant tau and is logged at the time t after the command's end has s = exp(-t / tau). If
    the step is not known, as for a pose that is predicted without its order, the arm is taken to be at rest.

    Attributes:
        joint: From 1.
        slides: Whether it is prismatic.
    """

    joint: int
    slides: bool = False

    name: ClassVar[str] = "pose_lag"
    kind: ClassVar[str] = "lag"
    sentence: ClassVar[str] = "the angle was logged before or after the joint had settled"
    natural: ClassVar[Mapping[str, float]] = {"rad/rad": 1e-3, "m/m": 1e-3}
    natural_source: ClassVar[str] = (
        "assumed: an exponential approach that is logged after seven of its time constants; no data sheet states it"
    )
    acts_on_arm: ClassVar[bool] = False  # it depends on when a campaign logged its angles
    acts_by_joint_angles: ClassVar[bool] = False

    @property
    def coefficient_names(self) -> list[str]:
        """``share_rad_per_rad`` or ``share_m_per_m``."""
        return [f"share_{self.joint_unit}_per_{self.joint_unit}"]

    @property
    def coefficient_units(self) -> list[str]:
        """Radians a radian, or metres a metre."""
        return [f"{self.joint_unit}/{self.joint_unit}"]

    def own_columns(self, robot: Robot, poses: Poses) -> Array:
        """Return the last step of the joint, zero at rest."""
        return self._steps(poses)[:, None]

    def _steps(self, poses: Poses) -> Array:
        return poses.columns.get(step_column(self.joint), np.zeros(len(poses)))

    @classmethod
    def candidates(cls, dataset: Dataset) -> list[Effect]:
        """Return the lag of every joint that moves, where the order of poses tells their steps."""
        return [cls.of(dataset, j) for j in moving_joints(dataset)] if steps_are_known(dataset) else []

    def not_transferable(self, dataset: Dataset) -> str | None:
        """Return that another campaign logs its angles at another time."""
        return "it depends on when that campaign logged its angles"

    @property
    def clause(self) -> str:
        """Return which joint was logged on its way."""
        when = "before" if self.coefficients[0] >= 0 else "after"
        return (
            f"the {self.joint_position} of joint {self.joint} was logged {when} the joint stood where it was measured, "
            "so it errs by a share of the last step"
        )

    @property
    def advice(self) -> list[str]:
        """Return to wait before angles are logged."""
        return [
            "Wait until the arm has settled, then log the angles and measure; or log the angles at the moment of the measurement.",
            "The lag belongs to this campaign: predictions are made for an arm at rest.",
        ]

    @property
    def how_to_measure(self) -> str:
        """Return how to see it directly."""
        return f"To see it directly, stop joint {self.joint} after a large step, and log its angle and the position of the flange for some seconds."

    @property
    def in_controller(self) -> str:
        """Return what changes in the controller."""
        return "In the controller, let a pose count as reached only when the joints have settled: a narrower window of position, or a wait."

    def pictures(self, view: View) -> list[Profile | Map]:
        """Return the error of the joint over its last step."""
        axis = Axis(f"last step of joint {self.joint}", self.joint_unit)
        return [joint_profile(view, self, self.joint, axis, self._steps(view.poses))]
