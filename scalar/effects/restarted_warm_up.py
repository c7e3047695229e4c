"""Lengths of the arm that grow while it works, shrink while it stands still, and grow again: a warm-up that starts anew after each stop."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from scalar.data.poses import Poses
from scalar.effects.acquisition import missing_column
from scalar.effects.effect import Effect
from scalar.effects.flexible.rivals_of_changes import rivals_of_change
from scalar.effects.growth import growing_lengths, growth_picture, time_constant_steps
from scalar.effects.picture import Map, Profile, View
from scalar.effects.places import LinkEffect
from scalar.effects.stretches import stretches_of_work
from scalar.effects.thermal_drift import WARM_UP_SHARES
from scalar.effects.wording import number
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import Array

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset

CLOCKS = ("time", "order")
_UNIT = {"time": "s", "order": "poses"}
_COOLING_RANGE = (1 / 9, 9.0)  # time constant of cooling over that of warming: within what is refined


@dataclass(frozen=True, eq=False)
class RestartedWarmUp(LinkEffect):
    """All lengths grow in proportion to the warmth w of the arm, which is 0 when the arm is cold and 1 after long work.

    ``a, d -> (1 + g w) a, d``, with ``tau dw/dt = 1 - w`` at work and ``cooling tau dw/dt = -w`` at rest.

    The arm is cold when the record begins. It works from the first to the last pose of each stretch of the record and stands still between the
    stretches: where the time is recorded, a stretch ends with a gap of at least ten usual intervals; where it is not, with a session, and the arm
    is taken to be cold again at the next one. After the last stretch it goes on working.

    Attributes:
        by: ``time`` or ``order``: the clock.
        begins: First time [s] or order of each stretch of work, ascending.
        ends: Last time [s] or order of each.
        time_constant: Time constant tau of the warm-up at work, in the unit of the clock.
        cooling: Time constant of the cooling at rest over that of the warm-up; zero if the arm is cold again after each stop.
    """

    by: str
    begins: tuple[float, ...]
    ends: tuple[float, ...]
    time_constant: float
    cooling: float = 1.0

    name: ClassVar[str] = "restarted_warm_up"
    kind: ClassVar[str] = "warm-up after each stop"
    growth_of_arm: ClassVar[bool] = True
    sentence: ClassVar[str] = (
        "the arm's lengths grow as it works, shrink while it stands still, and grow again"
    )
    natural: ClassVar[Mapping[str, float]] = {"m/m": 2.3e-4}
    natural_source: ClassVar[str] = (
        "aluminium alloys grow by 23e-6 a kelvin (EN 573-3 alloy 6082, data sheets); ten kelvin between a cold arm and one at work are assumed. That "
        "arms warm up at work and cool down when they stop is measured by Yin et al., Int. J. Adv. Manuf. Technol. 75 (2014) 933-946"
    )
    remedy: ClassVar[str] = "poses measured again and again after each stop would show it"
    acts_by_joint_angles: ClassVar[bool] = False

    @property
    def follows_order(self) -> bool:
        """Return whether the order of acquisition is the clock."""
        return self.by == "order"

    @property
    def target(self) -> dict[str, Any]:
        """Empty: it acts on the whole arm."""
        return {}

    @property
    def coefficient_names(self) -> list[str]:
        """Growth of an arm that has worked for long."""
        return ["growth_m_per_m"]

    @property
    def coefficient_units(self) -> list[str]:
        """Metres of growth per metre of length."""
        return ["m/m"]

    def variations(self, scale: float) -> list[Self]:
        """Return the effect with its time constants a little smaller or larger."""
        steps = time_constant_steps(scale)
        found = [replace(self, time_constant=self.time_constant * step) for step in steps]
        low, high = _COOLING_RANGE
        cooled = [float(np.clip(self.cooling * step, low, high)) for step in steps if self.cooling]
        return found + [replace(self, cooling=cooling) for cooling in cooled if cooling != self.cooling]

    def geometry_basis(self, robot: Robot, poses: Poses) -> Array:
        """Return the columns of ``LinkEffect.geometry_basis``: the nominal lengths [m] times the warmth."""
        return growing_lengths(robot, poses, self.warmth(self._clock(poses)))

    def _clock(self, poses: Poses) -> Array:
        """Return time or order ``(N,)``; the end of the last stretch where the order is not known."""
        if self.by == "time":
            return poses.column("time")
        return np.where(np.isfinite(poses.order), poses.order, self.ends[-1])

    def warmth(self, clock: Array) -> Array:
        """Return the warmth ``(N, 1)``, 0 cold and 1 after long work, at values ``(N,)`` of the clock."""
        x = np.asarray(clock, dtype=float)
        found = np.zeros(len(x))
        starting = 0.0  # warmth at the start of a stretch
        last = len(self.begins) - 1
        for k, (begin, end) in enumerate(zip(self.begins, self.ends, strict=True)):
            here = (x >= begin) & (x < self.begins[k + 1] if k < last else True)
            worked = x[here] - begin if k == last else np.minimum(x[here], end) - begin
            rested = np.zeros(int(here.sum())) if k == last else np.maximum(x[here] - end, 0.0)
            found[here] = self._warmed(starting, worked) * self._left(rested)
            if k < last:
                at_end = self._warmed(starting, np.array([end - begin]))
                starting = float((at_end * self._left(np.array([self.begins[k + 1] - end])))[0])
        return found[:, None]

    def _warmed(self, starting: float, worked: Array) -> Array:
        """Return the warmth after some work, from the warmth before it."""
        return 1.0 - (1.0 - starting) * np.exp(-worked / self.time_constant)

    def _left(self, rested: Array) -> Array:
        """Return the share of the warmth that is left after some rest."""
        if not self.cooling:
            return np.where(rested > 0.0, 0.0, 1.0)
        return np.exp(-rested / (self.cooling * self.time_constant))

    def stated(self, std: Sequence[float | None]) -> dict[str, tuple[float, float | None]]:
        """Return the growth, and the time constants in the unit of the clock."""
        found = {"growth_m_per_m": (float(self.coefficients[0]), std[0])}
        unit = _UNIT[self.by]
        found[f"time_constant_{unit}"] = (self.time_constant, None)
        if self.cooling:
            found[f"time_constant_of_cooling_{unit}"] = (self.cooling * self.time_constant, None)
        return found

    def to_mapping(self) -> dict[str, Any]:
        """Return the clock, the stretches of work, and the time constants."""
        return {
            "by": self.by,
            "begins": list(self.begins),
            "ends": list(self.ends),
            "time_constant": self.time_constant,
            "cooling": self.cooling,
        }

    @classmethod
    def from_mapping(cls, mapping: Mapping[str, Any]) -> Self:
        """Return the effect of ``to_mapping``."""
        begins, ends = (tuple(float(x) for x in mapping[key]) for key in ("begins", "ends"))
        return cls(
            str(mapping["by"]), begins, ends, float(mapping["time_constant"]), float(mapping["cooling"])
        )

    @classmethod
    def candidates(cls, dataset: Dataset) -> list[Effect]:
        """Return warm-ups of a few time constants, where the record has stops: gaps in time, or sessions without a time."""
        by, stretches = stretches_of_work(dataset)
        if len(stretches) < 2:
            return []
        begins, ends = (tuple(column) for column in np.transpose(stretches).tolist())
        longest = float(np.max(np.subtract(ends, begins)))
        cooling = 1.0 if by == "time" else 0.0
        return [cls(by, begins, ends, share * longest, cooling) for share in WARM_UP_SHARES]

    @classmethod
    def parsed(cls, dataset: Dataset, words: Sequence[str]) -> list[Effect]:
        """Return the warm-up of the middle time constant.

        Raises:
            ValueError: The clock that is named is not recorded, or the record has no stops.
        """
        if words and words[0] not in CLOCKS:
            raise ValueError(f"'{words[0]}' is no clock of a warm-up; there are {', '.join(CLOCKS)}")
        if words and words[0] == "time" and (missing := missing_column(dataset, "time")):
            raise ValueError(missing)
        found = cls.candidates(dataset)
        if not found or (words and words[0] != found[0].to_mapping()["by"]):
            raise ValueError(
                "the record has no stop after which the arm could warm up again: neither a gap in the time nor, without a time, sessions"
            )
        return [found[len(found) // 2]]

    def imitators(self, dataset: Dataset) -> list[Effect]:
        """Return changes of a link, of the whole arm, or of its load, at several moments of the campaign."""
        return rivals_of_change(dataset)

    @property
    def is_change_in_time(self) -> bool:
        """Always true."""
        return True

    def not_transferable(self, dataset: Dataset) -> str | None:
        """Return that the stretches of work are those of one campaign."""
        return f"its dependence on {self.by} is that of one campaign"

    @property
    def title(self) -> str:
        """Return what it is, and how fast the arm warms up."""
        return f"{self.kind} (constant {number(self.time_constant)} {_UNIT[self.by]})"

    @property
    def clause(self) -> str:
        """Return that the arm grows again after each stop."""
        return (
            f"the arm's lengths grow as it warms up, with a time constant of {number(self.time_constant)} {_UNIT[self.by]}, and again after each "
            f"of {len(self.begins) - 1} stops"
        )

    @property
    def advice(self) -> list[str]:
        """Return how to avoid it."""
        return [
            "Let the arm move through breaks as it does at work, or let it warm up again after each of them before it is measured or used.",
            "Record the time with each pose, from which the length of a stop follows; a session alone does not say how far the arm cooled.",
        ]

    @property
    def how_to_measure(self) -> str:
        """Return how to see it directly."""
        return (
            "To see it directly, measure one pose far from the base every few minutes: before a break, right after it, and until it no longer "
            "changes."
        )

    @property
    def in_controller(self) -> str:
        """Return what changes in the controller."""
        return "Nothing in the controller corrects it: it follows when the arm worked and stood still in this campaign."

    def pictures(self, view: View) -> list[Profile | Map]:
        """Return the growth of all lengths over the clock."""
        return [growth_picture(view, self, self.by, self._clock(view.poses), self.warmth)]
