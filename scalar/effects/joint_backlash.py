"""A joint with play, which rests on one side of it or on the other."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from scalar.data.moves import side_column
from scalar.data.poses import Poses
from scalar.effects.acquisition import missing_column, moving_joints, steps_are_known, turning_joints
from scalar.effects.command_words import joints_named
from scalar.effects.effect import Effect
from scalar.effects.flexible.tilt import tilts
from scalar.effects.flexible.wind_up import wind_ups
from scalar.effects.gravity import assumed_torque, typical_masses, typical_torque
from scalar.effects.joint_pictures import joint_profile
from scalar.effects.picture import Axis, Map, Profile, View, angle_axis
from scalar.effects.places import OneAxis, SingleJointEffect
from scalar.effects.sides_of_play import told_by, unknown_side
from scalar.effects.title import joints_in_words
from scalar.effects.wording import angle, length, side_of_travel
from scalar.geometry.robot import BoolArray, Robot
from scalar.geometry.se3 import Array

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset

LEAST_TORQUE = 0.01  # share of the most loaded joint's torque: the sign of a smaller torque does not tell on which side a joint rests

_NEEDS = {
    "approach": "; 'scalar correct' needs the direction of approach of each pose (column approach{})",
    "moves": "; 'scalar correct' needs the poses in their order (column order) or the direction of approach of each (column approach{}), and leaves "
    "the play out without them",
    "torque": "",
}
"""What 'scalar correct' needs to know of the poses, for each value of ``by``."""


@dataclass(frozen=True, eq=False)
class JointBacklash(OneAxis, SingleJointEffect):
    """A joint rests on one side of its play or on the other: ``dq_j = b s``, s the direction of approach or the torque's sign.

    If the direction of approach is not recorded, it may be taken from the order of the poses, assuming that the arm moves directly from each pose to
    the next; a joint that stands still keeps the side of its last move. If the last move is unknown too, as for a pose that is predicted without
    its order and direction of approach, s = 0.

    Attributes:
        joint: From 1.
        by: What determines the side: ``approach``, the recorded direction, or ``moves``, the last move by the order of the poses, if no direction is
            recorded; or ``torque``, the sign of the gravity torque.
        masses: First moments of mass in the frames from the joint on, x and y of each in turn, in any unit: only
            the sign of the torque matters. If empty, those of an arm with equal masses at the ends of its links.
        slides: Whether the joint is prismatic; its side is then never determined by a torque.
    """

    joint: int
    by: str
    masses: tuple[float, ...] = ()
    slides: bool = False

    name: ClassVar[str] = "joint_backlash"
    imitators_are_as_likely: ClassVar[bool] = True
    usual_odds: ClassVar[float] = 10.0  # wrong in 3 of 7 with less, in 1 of 796 with more
    kind: ClassVar[str] = "backlash"
    sentence: ClassVar[str] = "the joint has play and rests on one side of it or on the other"
    most_words: ClassVar[int] = 2
    natural: ClassVar[Mapping[str, float]] = {"rad": 3e-4, "m": 5e-5}
    natural_source: ClassVar[str] = (
        "half of 2 arc minutes, twice the play with which new gears are sold (Nabtesco RV-E, catalogue: 1 arc minute); "
        "of a travel assumed: a rack and pinion that is set without play is not sold"
    )

    @property
    def coefficient_names(self) -> list[str]:
        """``half_width_rad`` or ``half_width_m``."""
        return [f"half_width_{self.joint_unit}"]

    @property
    def coefficient_units(self) -> list[str]:
        """Radians, or metres."""
        return [self.joint_unit]

    @property
    def sign_in_words(self) -> str:
        """Return on which side of its reading the joint rests."""
        b = float(self.coefficients[0])
        if self.by != "torque":
            return side_of_travel([b])
        side = "beyond" if b > 0 else "short of"
        return f"the joint stands {side} its reading where the gravity torque on it is positive" if b else ""

    def torque(self, robot: Robot, q: Array) -> Array:
        """Return the torque ``(N,)`` whose sign says on which side the joint rests, in any unit."""
        return assumed_torque(robot, q, self.joint, self.masses)

    def own_columns(self, robot: Robot, poses: Poses) -> Array:
        """Return the side on which the joint rests, -1 or 1."""
        if self.by == "approach":
            side = poses.column(f"approach{self.joint}")
        elif self.by == "moves":
            side = self._last_move(poses)
        else:
            side = np.sign(self.torque(robot, poses.q))
        return side[:, None]

    @property
    def moves_from(self) -> tuple[str, ...]:
        """Return the order and the direction of approach, if the side follows from the moves."""
        return ("order", f"approach{self.joint}") if self.by == "moves" else ()

    def moves_unknown(self, poses: Poses) -> BoolArray:
        """Return where no move of the joint is known yet, if the side follows from the moves."""
        return self._last_move(poses) == 0.0 if self.by == "moves" else super().moves_unknown(poses)

    def against_its_load(self, robot: Robot, poses: Poses) -> bool:
        """Return whether the joint rests on the upper side of its play, where its load would have to lift it.

        The load is that of ``typical_torque``: `masses` may have been refined, and if all of them changed their sign, so would the coefficient.
        """
        if self.by != "torque":
            return False
        side = np.sign(self.torque(robot, poses.q))
        return float(self.coefficients[0]) * float(side @ typical_torque(robot, poses.q, self.joint)) < 0

    def is_impossible(self, robot: Robot, poses: Poses) -> bool:
        """Return whether the load would have to lift the joint; fitted masses may only describe where the sides change, and are allowed to."""
        return not self.masses and self.against_its_load(robot, poses)

    def _last_move(self, poses: Poses) -> Array:
        """Return the direction ``(N,)`` in which the joint moved last before each pose: 1, -1, or 0 where it is not known."""
        for column in (f"approach{self.joint}", side_column(self.joint)):
            if column in poses.columns:
                return np.sign(poses.columns[column])
        return np.zeros(len(poses))

    def to_mapping(self) -> dict[str, Any]:
        """Return the joint, what determines the side, and the first moments of mass if there are any."""
        own = {"masses": list(self.masses)} if self.masses else {}
        return {**super().to_mapping(), "by": self.by, **own}

    @classmethod
    def from_mapping(cls, mapping: Mapping[str, Any]) -> Self:
        """Return the effect of ``to_mapping``."""
        masses = tuple(float(m) for m in mapping.get("masses", ()))
        return cls(int(mapping["joint"]), str(mapping["by"]), masses, bool(mapping.get("slides", False)))

    @classmethod
    def candidates(cls, dataset: Dataset) -> list[Effect]:
        """Return the backlash of every joint whose side is known: from the recorded approach or else its last move, and from a torque that is not
        negligible.
        """
        moving = moving_joints(dataset)
        moves_known = steps_are_known(dataset)
        turning = turning_joints(dataset)
        torque = {j: np.max(np.abs(typical_torque(dataset.robot, dataset.q, j))) for j in turning}
        most = max(torque.values(), default=0.0)
        found: list[Effect] = []
        for j in moving:
            by, slides = told_by(dataset, j), j not in turning
            if by == "approach":
                found.append(cls(j, by, slides=slides))
            elif moves_known and f"approach{j}" not in dataset.poses:
                found.append(cls(j, "moves", slides=slides))
            if not slides and torque[j] > LEAST_TORQUE * most:
                # A load may hold the joint on one side from whichever it came, as where the bolts of a link are loose. Where directions are recorded,
                # masses are not fitted: a step anywhere in the joint space would imitate the bow of a target plane.
                masses = () if by == "approach" else typical_masses(dataset.robot, dataset.q, j)
                found.append(cls(j, "torque", tuple(float(m) for m in masses)))
        return found

    def imitators(self, dataset: Dataset) -> list[Effect]:
        """Return what the weight may do in the place of play, if it tells the side: joints' axes or the base tilt, or the gear winds up."""
        if self.by != "torque":
            return []
        return [*tilts(dataset, with_base=True), *wind_ups(dataset, self.joint, self.masses)]

    @classmethod
    def in_many_arms(cls, dataset: Dataset) -> list[Effect]:
        """Return all candidates."""
        return cls.candidates(dataset)

    @classmethod
    def parsed(cls, dataset: Dataset, words: Sequence[str]) -> list[Effect]:
        """Return the backlash of a joint, or of every joint. The side is determined by the second word, or by what is recorded.

        Raises:
            ValueError: The robot has no such joint, or what would determine its side is not known.
        """
        found: list[Effect] = []
        for j in joints_named(dataset, words):
            by, slides = told_by(dataset, j), bool(dataset.robot.slides[j - 1])
            by = "moves" if slides and by == "torque" else by
            if words[1:] and (lacks := unknown_side(dataset, j, words[1])):
                raise ValueError(lacks)
            found.append(cls(j, words[1] if words[1:] else by, slides=slides))
        return found

    @property
    def command_words(self) -> list[str]:
        """Return what determines the side, unless it is the recorded direction of approach, which is the default where it is recorded."""
        return [] if self.by == "approach" else [self.by]

    def variations(self, scale: float) -> list[Self]:
        """Return the effect with one first moment of mass a little larger or smaller, so that the torque changes its sign at other poses."""
        step = scale * float(np.linalg.norm(self.masses)) / 2
        result = [self]
        for k in range(len(self.masses)):
            for side in (-step, step):
                result.append(
                    replace(self, masses=tuple(m + side * (i == k) for i, m in enumerate(self.masses)))
                )
        return result

    def not_transferable(self, dataset: Dataset) -> str | None:
        """Return what is missing that tells the side."""
        if self.by == "moves":
            known = steps_are_known(dataset)
            return None if known else "the order of the poses does not tell from which side the joint came"
        return missing_column(dataset, f"approach{self.joint}") if self.by == "approach" else None

    @property
    def clause(self) -> str:
        """Return which joint has play."""
        return f"joint {self.joint} has play"

    @classmethod
    def clause_of(cls, effects: Sequence[Effect]) -> str:
        """Return which joints have play."""
        if len(effects) == 1:
            return effects[0].clause
        return f"{joints_in_words(sorted({effect.erring_joint or 0 for effect in effects}))} have play"

    @property
    def advice(self) -> list[str]:
        """Return how to avoid it."""
        beyond = self.by != "torque" and self.coefficients[0] > 0
        recorded = (
            "the poses stand in the order in which they were measured"
            if self.by == "moves"
            else "the approach of the joint was recorded the other way round"
        )
        swapped = f" Play hardly makes a joint stand beyond its reading: see first whether {recorded}."
        return [
            f"Let joint {self.joint} arrive from the same side at every pose, and have the play of its gear adjusted.{swapped if beyond else ''}"
        ]

    @property
    def how_to_measure(self) -> str:
        """Return how to see it directly."""
        return (
            f"To see it directly, bring joint {self.joint} to the same angle from either side, with a dial gauge at the flange: the two readings "
            f"differ by {length(self._play)} for each metre between the gauge and the joint's axis."
        )

    @property
    def in_controller(self) -> str:
        """Return what changes in the controller."""
        return (
            f"Where the controller compensates backlash, set that of joint {self.joint} to {angle(self._play)}, the whole play"
            f"{_NEEDS[self.by].format(self.joint)}."
        )

    @property
    def _play(self) -> float:
        """The whole play [rad], or [m] at a metre from the axis."""
        return 2.0 * abs(float(self.coefficients[0]))

    @classmethod
    def advice_on_data(cls, dataset: Dataset) -> list[str]:
        """Return that the directions of approach should be recorded, where they are not."""
        if all(told_by(dataset, j) == "approach" for j in moving_joints(dataset)):
            return []
        return [
            "Record from which side each joint came to a pose (columns approach1, approach2, …; 1 with a growing position, −1 with a falling "
            "one), and let it come from both sides: without these columns, backlash could be looked for by the order of the poses and the sign of "
            "the gravity torque only."
        ]

    def pictures(self, view: View) -> list[Profile | Map]:
        """Return the error of the joint on either side, over its angle or over the torque on it."""
        j = self.joint
        if self.by != "torque":
            last = view.poses.column(f"approach{j}") if self.by == "approach" else self._last_move(view.poses)
            side = np.sign(last) if self.by == "approach" else np.where(last < 0, -1.0, 1.0)
            axis = angle_axis(j, self.joint_unit)
            return [joint_profile(view, self, j, axis, view.poses.q[:, j - 1], side=side)]
        torque = self.torque(view.nominal, view.poses.q)
        x = torque / max(float(np.max(np.abs(torque))), 1e-300)
        axis = Axis(f"gravity torque on joint {j}, relative to the largest", "1")
        return [joint_profile(view, self, j, axis, x, side=np.sign(torque))]
