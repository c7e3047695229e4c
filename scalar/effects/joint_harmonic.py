"""Errors of a joint that are periodic in its own angle, as gears make them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from scalar.data.poses import Poses
from scalar.effects.acquisition import swept_joints, turning_joints
from scalar.effects.command_words import orders_named, turning_named
from scalar.effects.effect import Effect, Table
from scalar.effects.flexible.proposals import curves_of, waves_of
from scalar.effects.joint_pictures import along_joint, at_angle, joint_profile
from scalar.effects.picture import CURVE_POINTS, Axis, Map, Profile, View
from scalar.effects.remedies import CORRECT_PROGRAMS
from scalar.effects.series import Series
from scalar.effects.title import ORDERS_IN_SENTENCE, joints_in_words
from scalar.effects.wording import UNKNOWN, angle, periods
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import Array
from scalar.units import DEG

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset

MAX_ORDER = 32  # of a gear's error; higher orders are a ripple (``joint_ripple``)
MAX_RIPPLE_ORDER = 64
HIGH_ORDER = 5  # from this order on a curve is hard to follow over a whole turn; it is then shown folded to one period as well

_LARGEST_IN_GEARS = 6  # chosen: the largest order that many arms have without its being found; once and twice a turn are the usual ones
_STEPS_A_PERIOD = 8  # advised number of steps in each period when a joint is turned to see its error


@dataclass(frozen=True, eq=False)
class JointHarmonic(Series):
    """A joint's angle errs periodically in itself: ``dq_j = sum_k s_k sin(k q_j) + c_k cos(k q_j)``.

    Orders 1 to 32: eccentric and strain wave gears. Gear errors as harmonics of the joint angle: Judd and Knasinski, IEEE
    Transactions on Robotics and Automation 6 (1990).
    """

    name: ClassVar[str] = "joint_harmonic"
    kind: ClassVar[str] = "harmonic error"
    sentence: ClassVar[str] = (
        "the joint's angle errs periodically over its own turn, as an eccentric gear makes it err"
    )
    natural: ClassVar[Mapping[str, float]] = {"rad": 3e-4}
    natural_source: ClassVar[str] = (
        "strain wave gears are sold with a transmission accuracy of 1 arc minute, 2.9e-4 rad (Harmonic Drive, CSG catalogue)"
    )
    most_words: ClassVar[int] = 1 + MAX_ORDER
    every_order: ClassVar[tuple[int, ...]] = tuple(range(1, MAX_ORDER + 1))

    @property
    def coefficient_names(self) -> list[str]:
        """``sin_rad, cos_rad``, with the order where there are several."""
        if len(self.orders) == 1:
            return ["sin_rad", "cos_rad"]
        return [f"{f}{k}_rad" for k in self.orders for f in ("sin", "cos")]

    @property
    def term_names(self) -> list[str]:
        """``sin4, cos4`` for every order."""
        return [f"{f}{k}" for k in self.orders for f in ("sin", "cos")]

    @property
    def coefficient_units(self) -> list[str]:
        """Radians."""
        return ["rad"] * (2 * len(self.orders))

    def own_columns(self, robot: Robot, poses: Poses) -> Array:
        """Return sine and cosine of the multiples of the angle."""
        phase = np.multiply.outer(self.orders, poses.q[:, self.joint - 1])
        return np.stack([np.sin(phase), np.cos(phase)], axis=1).reshape(-1, len(poses)).T

    def change_with_orders(self, q: Array) -> Array:
        """Return ``q (s_k cos k q - c_k sin k q)`` of each order k."""
        phase = np.multiply.outer(q, self.orders)
        sine, cosine = self.coefficients.reshape(-1, 2).T
        return q[:, None] * (sine * np.cos(phase) - cosine * np.sin(phase))

    @classmethod
    def from_mapping(cls, mapping: Mapping[str, Any]) -> Self:
        """Return the effect of ``to_mapping``; version 1 called the prior standard deviations ``believed_rad``."""
        std = tuple(float(size) for size in mapping.get("prior_std_rad", mapping.get("believed_rad", ())))
        return cls(int(mapping["joint"]), tuple(int(k) for k in mapping["orders"]), term_std=std)

    @classmethod
    def candidates(cls, dataset: Dataset) -> list[Effect]:
        """Return every order of every joint that turns alone, and all orders of each."""
        moving, every = _sweeping(dataset), cls.every_order
        alone: list[Effect] = [cls(j, (k,)) for j in moving for k in every]
        return alone + [cls(j, every) for j in moving]

    @classmethod
    def in_many_arms(cls, dataset: Dataset) -> list[Effect]:
        """Return the lowest orders of every joint that turns, each alone: the largest errors of gears are among them."""
        return [cls(j, (k,)) for j in _sweeping(dataset) for k in cls.every_order if k <= _LARGEST_IN_GEARS]

    @classmethod
    def parsed(cls, dataset: Dataset, words: Sequence[str]) -> list[Effect]:
        """Return the orders that are named, or the first, of a joint or of all joints."""
        wanted = orders_named(words[1:], 1, MAX_ORDER) or (1,)
        return [cls(j, wanted) for j in turning_named(dataset, words)]

    def imitators(self, dataset: Dataset) -> list[Effect]:
        """Return waves whose period need not be a whole part of a turn, with overtones and without."""
        return [*waves_of(dataset, self.joint), *waves_of(dataset, self.joint, 1)]

    def partial_imitators(self, dataset: Dataset) -> list[Effect]:
        """Return simple shapes along the joint's own angle, and single waves."""
        return [*curves_of(dataset, self.joint), *waves_of(dataset, self.joint, 1)]

    @property
    def clause(self) -> str:
        """Return which joint errs, and how many periods a turn has."""
        return f"joint {self.joint} errs periodically, with {periods(self.orders, ORDERS_IN_SENTENCE)}"

    @classmethod
    def clause_of(cls, effects: Sequence[Effect]) -> str:
        """Return which joints err."""
        joints = sorted({effect.erring_joint or 0 for effect in effects})
        one = len(joints) == 1
        return (
            effects[0].clause
            if len(effects) == 1
            else f"{joints_in_words(joints)} err{'s' if one else ''} periodically"
        )

    @property
    def advice(self) -> list[str]:
        """Return which gear to look at."""
        return [
            f"Compare this error of joint {self.joint} with the accuracy on the data sheet of its gear, and have the gear checked for wear "
            "and eccentricity if the error is larger."
        ]

    @property
    def how_to_measure(self) -> str:
        """Return how to see it directly."""
        amplitudes = np.hypot(*self.coefficients.reshape(-1, 2).T)
        strongest = self.orders[int(np.argmax(amplitudes))]
        error = "the error" if len(self.orders) == 1 else "the largest part of the error"
        times = "once" if strongest == 1 else f"{strongest} times"
        return (
            f"To see it directly, turn joint {self.joint} alone in steps of {angle(2 * np.pi / (_STEPS_A_PERIOD * max(self.orders)), 1)} or "
            f"less, with a tracker or an angle standard at the flange: {error} comes back {times} in a turn."
        )

    @property
    def in_controller(self) -> str:
        """Return what changes in the controller."""
        return CORRECT_PROGRAMS

    def table(self, std: Sequence[float | None]) -> Table | None:
        """Return one row an order: amplitude, its standard error, and where the wave has its first maximum, all in degrees."""
        rows: list[tuple[str, ...]] = []
        for i, order in enumerate(self.orders):
            s, c = self.coefficients[2 * i : 2 * i + 2]
            errors = [e for e in std[2 * i : 2 * i + 2] if e is not None]
            error = angle(float(np.sqrt(np.mean(np.square(errors))))) if errors else UNKNOWN
            top = f"{float(np.arctan2(s, c)) / order / DEG:.1f}°".replace("-", "−")
            rows.append((str(order), angle(float(np.hypot(s, c)), 3), error, top))
        return ("order", "amplitude", "±", "first top at"), rows

    def pictures(self, view: View) -> list[Profile | Map]:
        """Return the error over the joint's angle, and the strongest order within its period where that is short."""
        whole = along_joint(view, self, self.joint, self.joint)
        strongest = int(np.argmax(np.hypot(self.coefficients[0::2], self.coefficients[1::2])))
        return [whole] if self.orders[strongest] < HIGH_ORDER else [whole, self._folded(view, strongest)]

    def _folded(self, view: View, term: int) -> Profile:
        """Return the error of one order over its period."""
        order, own = self.orders[term], slice(2 * term, 2 * term + 2)
        one = type(self)(self.joint, (order,), coefficients=self.coefficients[own])
        period = 2 * np.pi / order
        x = np.linspace(0.0, period, CURVE_POINTS)
        basis = one.joint_basis(view.nominal, at_angle(x, self.joint, view.poses.q.shape[1]))[
            :, self.joint - 1
        ]
        padded = np.zeros((len(x), len(self.coefficients)))
        padded[:, own] = basis
        curve = np.stack([x, basis @ one.coefficients, view.error_of(self, padded)])
        axis = Axis(f"angle of joint {self.joint} within a period of order {order}", "rad")
        folded = np.mod(view.poses.q[:, self.joint - 1], period)
        note = f"Order {order} alone, all its periods laid over one another."
        return joint_profile(view, one, self.joint, axis, folded, curve=curve, note=note)


def _sweeping(dataset: Dataset) -> list[int]:
    """Return the joints, from 1, that turn and take enough positions to show what is periodic in their angle."""
    swept = swept_joints(dataset)
    return [j for j in turning_joints(dataset) if j in swept]
