"""A joint whose angle was not logged at the moment of the measurement, while the joint still moved: it errs with the last move of the arm."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from scalar.data.moves import passing_column, speeds, step_column
from scalar.data.poses import Poses
from scalar.effects.acquisition import moving_joints, steps_are_known
from scalar.effects.command_words import joints_named
from scalar.effects.effect import Effect
from scalar.effects.joint_pictures import joint_profile
from scalar.effects.picture import Axis, Map, Profile, View
from scalar.effects.places import OneAxis, SingleJointEffect
from scalar.effects.title import joints_in_words
from scalar.effects.wording import listed
from scalar.geometry.robot import BoolArray, Robot
from scalar.geometry.se3 import Array

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset


STEP, SPEED, PASSING = "step", "speed", "passing"
TERMS = (STEP, SPEED, PASSING)
"""What a lag may be in proportion to: the last step of the joint, its speed in the last move, or its velocity as it passes the pose."""


@dataclass(frozen=True, eq=False)
class PoseLag(OneAxis, SingleJointEffect):
    """Angle or travel was logged while the joint moved: ``dq_j = s d_j + v d_j / max_k |d_k| + t w_j``, d the last steps of the joints.

    The first term is the share of the step that is still to go. A joint that comes to rest exponentially with the time constant tau and is logged
    at the time t after the command's end has s = exp(-t / tau). The second is in proportion to the joint's speed. The joints of an industrial
    robot start and arrive together, so a joint's speed is its step over the duration of the move, and the joint that moves farthest, which
    has the speed 1, decides the duration. Encoders that are read a time t too early, or a servo that follows at the distance t times the
    speed, err by v = t times the speed of the fastest joint. (The joints of one kind, that turn or that slide, are compared with one another.)

    The third term is of an arm that is measured in passing: w_j is the velocity from the pose before to the pose after, and t the delay of the
    measurement behind the angles. It needs the times of the poses.

    Coefficients are positive if the joint moved on between logging and measuring, negative if the angle was logged after the measurement. If the
    step is not known, as for a pose that is predicted without its order, the arm is taken to be at rest.

    Attributes:
        joint: From 1.
        slides: Whether it is prismatic.
        terms: Some of ``TERMS``, in their order.
    """

    joint: int
    slides: bool = False
    terms: tuple[str, ...] = TERMS[:1]

    name: ClassVar[str] = "pose_lag"
    kind: ClassVar[str] = "lag"
    most_words: ClassVar[int] = 1 + len(TERMS)
    read_before_arrival: ClassVar[bool] = True
    sentence: ClassVar[str] = "the angle was logged before or after the joint had settled"
    natural: ClassVar[Mapping[str, float]] = {"rad/rad": 1e-3, "m/m": 1e-3, "rad": 5e-4, "m": 2e-4, "s": 2e-3}
    natural_source: ClassVar[str] = (
        "assumed: an exponential approach that is logged after seven of its time constants; or 0.2 ms at 3 rad/s or 1 m/s; or 2 ms "
        "in passing; "
        "no data sheet states it"
    )
    acts_on_arm: ClassVar[bool] = False  # it depends on when a campaign logged its angles
    acts_by_joint_angles: ClassVar[bool] = False

    @property
    def follows_order(self) -> bool:
        """Always true: the step is that from the pose before."""
        return True

    @property
    def coefficient_names(self) -> list[str]:
        """``share_rad_per_rad`` and ``at_full_speed_rad``, or the same in metres, and ``delay_s``."""
        unit = self.joint_unit
        names = {STEP: f"share_{unit}_per_{unit}", SPEED: f"at_full_speed_{unit}", PASSING: "delay_s"}
        return [names[term] for term in self.terms]

    @property
    def coefficient_units(self) -> list[str]:
        """Radians a radian and radians, or the same in metres, and seconds."""
        units = {STEP: f"{self.joint_unit}/{self.joint_unit}", SPEED: self.joint_unit, PASSING: "s"}
        return [units[term] for term in self.terms]

    def own_columns(self, robot: Robot, poses: Poses) -> Array:
        """Return the last step of the joint, its speed as a share of the fastest joint's, and its velocity in passing; all are zero at rest."""
        return np.stack([self._column(term, robot, poses) for term in self.terms], axis=1)

    def moves_unknown(self, poses: Poses) -> BoolArray:
        """Return where no joint is known to have moved to the pose, or through it."""
        found = np.zeros(len(poses), dtype=bool)
        for column_of in {passing_column if term == PASSING else step_column for term in self.terms}:
            names = [column_of(j + 1) for j in range(poses.q.shape[1])]
            found |= np.all([poses.columns.get(name, np.zeros(len(poses))) == 0.0 for name in names], axis=0)
        return found

    def _column(self, term: str, robot: Robot, poses: Poses) -> Array:
        """Return what the joint errs in proportion to by one of ``TERMS``, ``(N,)``."""
        if term == SPEED:
            return speeds(poses.columns, robot.slides, len(poses))[:, self.joint - 1]
        name = step_column(self.joint) if term == STEP else passing_column(self.joint)
        return poses.columns.get(name, np.zeros(len(poses)))

    @property
    def n_terms(self) -> int:
        """Return the number of terms."""
        return len(self.terms)

    def with_terms(self, chosen: Sequence[int]) -> Self:
        """Return some of the terms only."""
        return type(self)(self.joint, self.slides, tuple(self.terms[i] for i in sorted(chosen)))

    def merged_with(self, other: Effect) -> Effect | None:
        """Return the terms of both, if they are of one joint."""
        if not isinstance(other, PoseLag) or other.joint != self.joint:
            return None
        terms = tuple(term for term in TERMS if term in {*self.terms, *other.terms})
        return type(self)(self.joint, self.slides, terms).with_coefficients_of(self)

    def to_mapping(self) -> dict[str, Any]:
        """Return the joint, and the terms if they are not the step alone."""
        return super().to_mapping() | ({} if self.terms == (STEP,) else {"terms": list(self.terms)})

    @classmethod
    def from_mapping(cls, mapping: Mapping[str, Any]) -> Self:
        """Return the effect of ``to_mapping``."""
        terms = tuple(term for term in TERMS if term in mapping.get("terms", [STEP]))
        return cls(int(mapping["joint"]), bool(mapping.get("slides", False)), terms)

    @property
    def command_words(self) -> list[str]:
        """Return the terms, if they are not the step alone."""
        return [] if self.terms == (STEP,) else list(self.terms)

    @classmethod
    def parsed(cls, dataset: Dataset, words: Sequence[str]) -> list[Effect]:
        """Return the lag of a joint, or of every joint, with the terms that are named after the joint, or with its step.

        Raises:
            ValueError: The robot has no such joint, or a word is no term.
        """
        wrong = [word for word in words[1:] if word not in TERMS]
        if wrong:
            raise ValueError(
                f"'{wrong[0]}' is nothing that a lag is in proportion to; there are {listed(TERMS)}"
            )
        terms = tuple(term for term in TERMS if term in words[1:]) or (STEP,)
        return [cls(j, bool(dataset.robot.slides[j - 1]), terms) for j in joints_named(dataset, words[:1])]

    @classmethod
    def candidates(cls, dataset: Dataset) -> list[Effect]:
        """Return the lag of every joint that moves, where the order of poses tells their steps."""
        if not steps_are_known(dataset):
            return []
        terms = TERMS if "time" in dataset.poses else (STEP, SPEED)
        return [cls(j, bool(dataset.robot.slides[j - 1]), terms) for j in moving_joints(dataset)]

    @classmethod
    def together(cls, dataset: Dataset) -> list[list[Effect]]:
        """Return the lags of all joints that move: an arm that is measured before it stands still moves in all joints."""
        lags = cls.candidates(dataset)
        return [[lag.with_terms([k]) for lag in lags] for k in range(lags[0].n_terms)] if lags else []

    def not_transferable(self, dataset: Dataset) -> str | None:
        """Return that another campaign logs its angles at another time."""
        return "it depends on when that campaign logged its angles"

    @property
    def _when(self) -> str:
        """Return whether the joint was logged before or after it stood where it was measured."""
        # Terms may have opposite signs; the larger one, in sizes that real arms have, decides which way the joint errs.
        sizes = self.coefficients / self.natural_sizes
        return "before" if sizes[np.argmax(np.abs(sizes))] >= 0 else "after"

    @property
    def clause(self) -> str:
        """Return which joint was logged on its way."""
        grows = {
            STEP: "by a share of the last step",
            SPEED: "in proportion to its speed in the last move",
            PASSING: "in proportion to the velocity with which it passes the pose",
        }
        return (
            f"the {self.joint_position} of joint {self.joint} was logged {self._when} the joint stood where it was measured, "
            f"so it errs {' and '.join(grows[term] for term in self.terms)}"
        )

    @classmethod
    def clause_of(cls, effects: Sequence[Self]) -> str:
        """Return which joints were logged on their way; of several joints, not what each errs in proportion to."""
        if len(effects) == 1:
            return effects[0].clause
        joints = joints_in_words(sorted({effect.joint for effect in effects}))
        when = " or ".join(sorted({effect._when for effect in effects}, reverse=True))
        return f"{joints} were logged {when} they stood where they were measured, so they err with the move by which they arrive"

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
        """Return the error of the joint over its last step, or over its speed or velocity if it errs with that alone."""
        driver = self.terms[0] if len(self.terms) == 1 else STEP
        axis = {
            STEP: Axis(f"last step of joint {self.joint}", self.joint_unit),
            SPEED: Axis(f"speed of joint {self.joint}, as a share of the fastest joint's", "1"),
            PASSING: Axis(f"velocity of joint {self.joint} in passing", f"{self.joint_unit}/s"),
        }[driver]
        return [joint_profile(view, self, self.joint, axis, self._column(driver, view.nominal, view.poses))]
