"""A joint that friction winds up: its error depends on how far it has moved since it turned round."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from scalar.data.moves import TRAVELS, moves, side_column, step_column, wind_up_column
from scalar.data.poses import Poses
from scalar.effects.acquisition import moving_joints, steps_are_known
from scalar.effects.command_words import joints_named
from scalar.effects.effect import Effect
from scalar.effects.joint_pictures import joint_profile
from scalar.effects.picture import Axis, Map, Profile, View
from scalar.effects.places import OneAxis, SingleJointEffect
from scalar.effects.sides_of_play import told_by
from scalar.effects.wording import angle, length, side_of_travel
from scalar.geometry.robot import BoolArray, Robot
from scalar.geometry.se3 import Array

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset

OWN_SHARE = 0.1  # least share of the wind-up's variance that neither angle, step nor side of the joint explains: with less it is their name (chosen)


@dataclass(frozen=True, eq=False)
class JointHysteresis(OneAxis, SingleJointEffect):
    """Friction winds a joint up: ``dq_j = sum of h w``; over a move by d a wind-up w goes to ``s + (w - s) exp(-|d| / travel)``, s the sign of d.

    Each term is the friction of Dahl (1968) with a travel of its own; friction that yields over many travels is the sum of a few. It differs from
    backlash in that short moves change the error by a part only, and that the moves before are remembered. Moves are taken to be direct. Where the
    moves are not known, as at a pose to be predicted without its order, w = 0.

    Attributes:
        joint: From 1.
        travels: Some of ``TRAVELS``, ascending [rad, or m for a joint that slides].
        slides: Whether the joint is prismatic.
    """

    joint: int
    travels: tuple[float, ...]
    slides: bool = False

    name: ClassVar[str] = "joint_hysteresis"
    kind: ClassVar[str] = "hysteresis"
    sentence: ClassVar[str] = (
        "friction winds the joint up, so that its error depends on how far it has moved since it turned"
    )
    natural: ClassVar[Mapping[str, float]] = {"rad": 1.5e-4, "m": 5e-5}
    natural_source: ClassVar[str] = (
        "half of 1 arc minute, below which the hysteresis loss of cycloidal gears stays (Nabtesco, Backlash, www.nabtesco.de/en/faq/backlash, which "
        "says that most of it is friction); of a travel assumed"
    )
    remedy: ClassVar[str] = "short and long moves of the joint in turns, in both directions, would show it"
    acts_by_joint_angles: ClassVar[bool] = False

    @property
    def coefficient_names(self) -> list[str]:
        """``half_width_over_0.2_rad``: half of the width that is wound up over a travel of 0.2 rad; or the same in metres."""
        return [f"half_width_over_{travel:g}_{self.joint_unit}" for travel in self.travels]

    @property
    def coefficient_units(self) -> list[str]:
        """Radians, or metres."""
        return [self.joint_unit] * len(self.travels)

    @property
    def sign_in_words(self) -> str:
        """Return on which side of its reading the joint stands, if all of its wind-ups agree."""
        return side_of_travel(self.coefficients.tolist())

    @property
    def moves_from(self) -> tuple[str, ...]:
        """Return the order."""
        return ("order",)

    def moves_unknown(self, poses: Poses) -> BoolArray:
        """Return where no move of the joint is known yet."""
        return np.asarray(~self._wind_up(poses).any(axis=1))

    def own_columns(self, robot: Robot, poses: Poses) -> Array:
        """Return the wind-up by each travel, -1 to 1."""
        return self._wind_up(poses)

    def _wind_up(self, poses: Poses) -> Array:
        """Return the wind-up by each travel ``(N, k)``."""
        none = np.zeros(len(poses))
        return np.stack(
            [poses.columns.get(wind_up_column(self.joint, travel), none) for travel in self.travels], axis=1
        )

    @property
    def n_terms(self) -> int:
        """Return the number of travels."""
        return len(self.travels)

    def with_terms(self, chosen: Sequence[int]) -> Effect:
        """Return some of the travels only."""
        return JointHysteresis(self.joint, tuple(self.travels[i] for i in sorted(chosen)), self.slides)

    def merged_with(self, other: Effect) -> Effect | None:
        """Return the travels of both, if they wind up one joint."""
        if not isinstance(other, JointHysteresis) or other.joint != self.joint:
            return None
        travels = tuple(sorted({*self.travels, *other.travels}))
        return JointHysteresis(self.joint, travels, self.slides).with_coefficients_of(self)

    def to_mapping(self) -> dict[str, Any]:
        """Return the joint and the travels."""
        return {**super().to_mapping(), "travels": list(self.travels)}

    @classmethod
    def from_mapping(cls, mapping: Mapping[str, Any]) -> Self:
        """Return the effect of ``to_mapping``."""
        travels = tuple(float(travel) for travel in mapping["travels"])
        return cls(int(mapping["joint"]), travels, bool(mapping.get("slides", False)))

    @classmethod
    def candidates(cls, dataset: Dataset) -> list[Effect]:
        """Return the hysteresis of every joint, by the travels that its moves distinguish from backlash, scale and lag.

        It is tried where the order of the poses is recorded (a column ``order`` or ``time``) and no direction of approach, which would say that moves
        were not direct.
        """
        recorded = {"order", "time"} & {*dataset.poses.columns}
        if not recorded or not steps_are_known(dataset):
            return []
        known = moves(dataset.poses, dataset.robot.slides)
        found: list[Effect] = []
        for j in moving_joints(dataset):
            if told_by(dataset, j) == "approach":
                continue
            others = np.column_stack(
                [np.ones(dataset.n_poses), dataset.q[:, j - 1], known[step_column(j)], known[side_column(j)]]
            )
            travels = tuple(
                travel
                for travel in TRAVELS
                if _unexplained_share(known[wind_up_column(j, travel)], others) >= OWN_SHARE
            )
            if travels:
                found.append(cls(j, travels, bool(dataset.robot.slides[j - 1])))
        return found

    @classmethod
    def parsed(cls, dataset: Dataset, words: Sequence[str]) -> list[Effect]:
        """Return the hysteresis of a joint, or of every joint, by the middle one of the travels."""
        return [
            cls(j, (TRAVELS[len(TRAVELS) // 2],), bool(dataset.robot.slides[j - 1]))
            for j in joints_named(dataset, words)
        ]

    def not_transferable(self, dataset: Dataset) -> str | None:
        """Return that the moves are not known."""
        known = steps_are_known(dataset)
        return (
            None if known else "the order of the poses does not tell how far the joint moved since it turned"
        )

    @property
    def clause(self) -> str:
        """Return which joint is wound up, and over which travel."""
        travel = length(self.travels[-1]) if self.slides else angle(self.travels[-1])
        return f"joint {self.joint} is wound up by friction, and unwinds over about {travel} of travel when it turns round"

    @property
    def advice(self) -> list[str]:
        """Return how to avoid it."""
        return [
            f"Let joint {self.joint} arrive from the same side and over a long move at every pose, and have its friction checked: seals, brake, "
            "bearings, and hoses that it drags along."
        ]

    @property
    def how_to_measure(self) -> str:
        """Return how to see it directly."""
        return (
            f"To see it directly, move joint {self.joint} forth and back by steps that grow from short to long, with a dial gauge at the flange: "
            "with play the whole difference is there after the shortest step, with hysteresis it grows with the step."
        )

    @property
    def in_controller(self) -> str:
        """Return what changes in the controller."""
        return "No fixed parameter of a controller holds it: correct programs with 'scalar correct', which needs the poses in their order."

    def pictures(self, view: View) -> list[Profile | Map]:
        """Return the error of the joint over its wind-up, the mean of those by each travel."""
        axis = Axis(f"wind-up of joint {self.joint}", "1")
        return [joint_profile(view, self, self.joint, axis, self._wind_up(view.poses).mean(axis=1))]


def _unexplained_share(values: Array, others: Array) -> float:
    """Return the share of the variance of values ``(N,)`` that no combination of the columns ``(N, k)`` explains."""
    centred = values - values.mean()
    total = float(centred @ centred)
    if total == 0.0:
        return 0.0
    left = values - others @ np.linalg.lstsq(others, values, rcond=None)[0]
    return float(left @ left) / total
