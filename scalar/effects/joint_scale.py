"""A joint whose angle errs in proportion to itself."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from scalar.data.poses import Poses
from scalar.effects.acquisition import moving_joints, swept_joints
from scalar.effects.effect import Effect
from scalar.effects.joint_harmonic import JointHarmonic
from scalar.effects.places import OneAxis, SingleJointEffect
from scalar.effects.title import joints_in_words
from scalar.effects.wording import angle
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import Array

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset


@dataclass(frozen=True, eq=False)
class JointScale(OneAxis, SingleJointEffect):
    """A joint's angle, or its travel, errs in proportion to itself: ``dq_j = s q_j``.

    Attributes:
        joint: From 1.
        slides: Whether it is prismatic.
    """

    joint: int
    slides: bool = False

    name: ClassVar[str] = "joint_scale"
    kind: ClassVar[str] = "scale error"
    sentence: ClassVar[str] = (
        "the joint's angle errs in proportion to itself, as a wrong gear ratio makes it err"
    )
    natural: ClassVar[Mapping[str, float]] = {"rad/rad": 1e-3, "m/m": 1.7e-4}
    natural_source: ClassVar[str] = (
        "assumed: a gear ratio that is rounded to three digits; no data sheet states it. Of a travel: a ball screw of class 7 may err "
        "by 52 micrometres in 300 mm (ISO 3408-3)"
    )
    remedy: ClassVar[str] = (
        "poses in which the joint moves further may show it; for a joint that slides, a known length does"
    )

    @property
    def coefficient_names(self) -> list[str]:
        """``scale_rad_per_rad`` or ``scale_m_per_m``."""
        return [f"scale_{self.joint_unit}_per_{self.joint_unit}"]

    @property
    def coefficient_units(self) -> list[str]:
        """Radians a radian, or metres a metre."""
        return [f"{self.joint_unit}/{self.joint_unit}"]

    def own_columns(self, robot: Robot, poses: Poses) -> Array:
        """Return the angle or travel itself."""
        return poses.q[:, self.joint - 1, None]

    @classmethod
    def candidates(cls, dataset: Dataset) -> list[Effect]:
        """Return the scale error of every joint that moves."""
        return [cls.of(dataset, j) for j in moving_joints(dataset)]

    @classmethod
    def in_many_arms(cls, dataset: Dataset) -> list[Effect]:
        """Return all candidates."""
        return cls.candidates(dataset)

    def alike_at_few_positions(self, dataset: Dataset) -> list[Effect]:
        """Return an error once a turn if the joint takes so few positions that no harmonics are looked for."""
        return [] if self.slides or self.joint in swept_joints(dataset) else [JointHarmonic(self.joint, (1,))]

    @property
    def own_angle_joint(self) -> int | None:
        """The joint."""
        return self.joint

    @property
    def clause(self) -> str:
        """Return which joint errs."""
        return f"joint {self.joint} errs in proportion to its {self.joint_position}"

    @classmethod
    def clause_of(cls, effects: Sequence[Effect]) -> str:
        """Return which joints err."""
        if len(effects) == 1:
            return effects[0].clause
        what = "positions" if any(getattr(effect, "slides", False) for effect in effects) else "angles"
        return f"{joints_in_words(sorted({effect.erring_joint or 0 for effect in effects}))} err in proportion to their {what}"

    @property
    def advice(self) -> list[str]:
        """Return where to correct it."""
        if self.slides:
            return [
                f"Compare the pitch of the screw or rack of joint {self.joint} in the controller with its data sheet, and correct it there."
            ]
        return [
            f"Compare the gear ratio of joint {self.joint} in the controller with the arm's data sheet, and correct it there."
        ]

    @property
    def how_to_measure(self) -> str:
        """Return how to see it directly."""
        return (
            f"To see it directly, turn joint {self.joint} alone by a large angle that an angle standard or a tracker measures: in every 90° that the "
            f"controller counts, the arm turns by {angle(abs(float(self.coefficients[0])) * np.pi / 2)} "
            f"{'more' if self.coefficients[0] > 0 else 'less'}."
        )

    @property
    def in_controller(self) -> str:
        """Return what changes in the controller."""
        return (
            f"Divide the gear ratio of joint {self.joint} in the controller, the turns of its motor for one of the joint, by "
            f"{1.0 + float(self.coefficients[0]):.6f}."
        )
