"""A tracker, or the base of the arm, that moves in the course of a campaign: slowly, or by a step."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from scalar.data.formats import TARGET_MOTION
from scalar.data.poses import Poses
from scalar.effects.acquisition import ALWAYS, knock_std, missing_column, order_and_time
from scalar.effects.command_words import start_named
from scalar.effects.effect import Effect
from scalar.effects.flexible.rivals_of_changes import rivals_of_change
from scalar.effects.picture import CURVE_POINTS, Axis, Map, Profile, View, largest, variable_axis
from scalar.effects.places import BaseEffect
from scalar.effects.wording import OWN_SESSION
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import Array
from scalar.sensors import kind_of

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset

REFERENCES, STEP = "references", "step"
CLOCKS = ("time", "order")
WAVES = (1, 2, 3)  # numbers of half waves over the campaign
LEAST_POSES = 40  # chosen: each half wave has six coefficients
_COMPONENTS = ("rx", "ry", "rz", "x", "y", "z")


@dataclass(frozen=True, eq=False)
class TargetDrift(BaseEffect):
    """The base moves relative to the tracker: by half waves of time, by a step, or as references on the base show it.

    ``T_base_moved = exp(sum over k of cos(k pi s) c_k)``, s the share of the campaign that has passed and c_k the coefficients. The first few such
    waves make up nine tenths of the variance of a slow random motion. Poses that are no part of the campaign (without order, or without time) are
    predicted with the base at its mean place, or where it stood before a step: the arm's programs know nothing of the tracker.

    Attributes:
        by: ``time`` or ``order``, the clock of the half waves; ``step``: all at once; or ``references``: the motion that references on the base
            show, times one coefficient, which is 1 if they show the whole motion.
        start: First time [s] or order of the campaign.
        end: Last time [s] or order of the campaign.
        waves: Numbers of half waves, six coefficients each.
        order: Order of acquisition of the first pose after a step; None for the other kinds.
        moment: The time of that pose [s], or None.
    """

    by: str
    start: float = 0.0
    end: float = 1.0
    waves: tuple[int, ...] = ()
    order: float | None = None
    moment: float | None = None

    name: ClassVar[str] = "target_drift"
    kind: ClassVar[str] = "movement of the tracker or the base"
    sentence: ClassVar[str] = (
        "the tracker or the base moved in the course of the campaign, slowly or by a step"
    )
    natural: ClassVar[Mapping[str, float]] = {"m": 1e-4, "rad": 3e-5}
    natural_source: ClassVar[str] = (
        "assumed: a tripod on a hall's floor settles by a tenth of a millimetre, and turns by 6 seconds of arc, in a campaign of hours"
    )
    in_timed_predictions: ClassVar[str] = (
        "the frames contain the movement of the tracker or the base at the order and time of each row; without these columns they are those of the "
        "arm alone"
    )
    acts_on_arm: ClassVar[bool] = False
    acts_by_joint_angles: ClassVar[bool] = False

    @property
    def target(self) -> dict[str, Any]:
        """When a step happened; else empty: tracker and base move relative to each other."""
        return {} if self.by != STEP else {"at": {"order": self.order, "time": self.moment}}

    @property
    def prior_std(self) -> Array:
        """Return two centimetres and three degrees for a step, since a knock may move a tracker far."""
        if self.by != STEP:
            return super().prior_std
        return knock_std(self.coefficient_units)

    @property
    def coefficient_names(self) -> list[str]:
        """``wave1_rx_rad``: amplitude of the first half wave; ``rx_rad``: of a step; or the share of what references show."""
        if self.by == REFERENCES:
            return ["share_of_references_1"]
        if self.by == STEP:
            return [f"{c}_{'rad' if c.startswith('r') else 'm'}" for c in _COMPONENTS]
        return [f"wave{k}_{c}_{'rad' if c.startswith('r') else 'm'}" for k in self.waves for c in _COMPONENTS]

    @property
    def coefficient_units(self) -> list[str]:
        """Radians and metres, or a pure number."""
        return ["1"] if self.by == REFERENCES else ["rad", "rad", "rad", "m", "m", "m"] * self.n_terms

    def base_screws(self, robot: Robot, poses: Poses) -> Array:
        """Return the motion that references show, or unit motions about the base's origin times the half waves or the step."""
        if self.by == REFERENCES:
            none = np.zeros(len(poses))
            return np.stack([poses.columns.get(name, none) for name in TARGET_MOTION], axis=1)[:, :, None]
        after = self.by == STEP
        profile = self._after(poses.order)[:, None] if after else self._profile(self._clock(poses))
        return np.einsum("nk,ij->nikj", profile, np.eye(6)).reshape(len(poses), 6, -1)

    def _after(self, order: Array) -> Array:
        """Return 1 for orders from the step on, and 0 for those before and for poses that are no part of the campaign, ``(N,)``."""
        assert self.order is not None
        return ((order >= self.order) & np.isfinite(order)).astype(float)

    def _clock(self, poses: Poses) -> Array:
        """Return the time [s] or the order of the poses ``(N,)``; NaN where it is not known."""
        if self.by == "order":
            return np.where(np.isfinite(poses.order), poses.order, np.nan)
        return poses.columns.get("time", np.full(len(poses), np.nan))

    def _profile(self, clock: Array) -> Array:
        """Return the half waves ``(N, K)`` at values of the clock; zero where it is not known."""
        share = np.clip((clock - self.start) / max(self.end - self.start, 1e-300), 0.0, 1.0)
        return np.nan_to_num(np.cos(np.pi * share[:, None] * np.asarray(self.waves, dtype=float)))

    def to_mapping(self) -> dict[str, Any]:
        """Return what drives it, and when a step happened."""
        at = {"order": self.order, "time": self.moment} if self.by == STEP else {}
        return {"by": self.by, "start": self.start, "end": self.end, "waves": list(self.waves), **at}

    @classmethod
    def from_mapping(cls, mapping: Mapping[str, Any]) -> Self:
        """Return the effect of ``to_mapping``."""
        waves = tuple(int(k) for k in mapping["waves"])
        at = [mapping.get(key) for key in ("order", "time")]
        order, moment = (None if value is None else float(value) for value in at)
        return cls(str(mapping["by"]), float(mapping["start"]), float(mapping["end"]), waves, order, moment)

    @classmethod
    def measured(cls, dataset: Dataset) -> Self | None:
        """Return the drift that references show, in full; None where they show none."""
        if not all(name in dataset.poses and dataset.poses[name].any() for name in TARGET_MOTION[3:]):
            return None
        return cls(REFERENCES, coefficients=np.ones(1))

    @classmethod
    def by_clock(cls, dataset: Dataset) -> Self | None:
        """Return the drift by half waves of time, or of the order of poses; None where that stands still."""
        order, time = order_and_time(dataset)
        clock = order if time is None or np.ptp(time) <= 0 else time
        if np.ptp(clock) <= 0:
            return None
        by = "order" if clock is order else "time"
        return cls(by, float(clock.min()), float(clock.max()), WAVES)

    @classmethod
    def candidates(cls, dataset: Dataset) -> list[Effect]:
        """Return what references show, and half waves of the clock; nothing if the sensor measures planes, each of which may move by itself."""
        if kind_of(dataset).format.on_planes:
            return []
        seen, by_clock = cls.measured(dataset), cls.by_clock(dataset)
        found: list[Effect] = [] if seen is None else [seen.with_coefficients([0.0])]
        return found + ([by_clock] if by_clock is not None and dataset.n_poses >= LEAST_POSES else [])

    @classmethod
    def changes(cls, dataset: Dataset) -> list[tuple[Effect, Array]]:
        """Return a step at any pose; nothing if the sensor measures planes, each of which may move by itself."""
        if kind_of(dataset).format.on_planes:
            return []
        return [(cls(STEP, order=ALWAYS), np.ones(dataset.n_poses, dtype=bool))]

    def beginning(self, order: float, time: float | None) -> Self:
        """Return a step at a pose."""
        return replace(self, order=order, moment=time, coefficients=np.zeros(len(self.coefficients)))

    @classmethod
    def parsed(cls, dataset: Dataset, words: Sequence[str]) -> list[Effect]:
        """Return the motion that references show, half waves of the clock, or a step from the order of acquisition that is named."""
        if words and words[0] not in (REFERENCES, *CLOCKS):
            try:
                return [cls(STEP, order=start_named(words[0]))]
            except ValueError:
                known = f"{REFERENCES}, {', '.join(CLOCKS)}, or the order of the first pose after a step"
                raise ValueError(f"'{words[0]}' moves no target; there are {known}") from None
        if words and words[0] == "time" and (missing := missing_column(dataset, "time")):
            raise ValueError(missing)
        seen = cls.measured(dataset) if not words or words[0] == REFERENCES else None
        if words and words[0] == REFERENCES and seen is None:
            raise ValueError("no references on the base show a motion (nests.csv)")
        found = seen or cls.by_clock(dataset)
        return [] if found is None else [found]

    @property
    def n_terms(self) -> int:
        """Return the number of half waves."""
        return max(len(self.waves), 1)

    def with_terms(self, chosen: Sequence[int]) -> Effect:
        """Return some of the half waves only."""
        if self.by in (REFERENCES, STEP):
            return self
        return TargetDrift(self.by, self.start, self.end, tuple(self.waves[i] for i in sorted(chosen)))

    def merged_with(self, other: Effect) -> Effect | None:
        """Return the half waves of both, if one clock drives them."""
        if not isinstance(other, TargetDrift) or self.by != other.by or self.by in (REFERENCES, STEP):
            return None
        waves = tuple(sorted({*self.waves, *other.waves}))
        return TargetDrift(self.by, self.start, self.end, waves).with_coefficients_of(self)

    @property
    def label(self) -> str:
        """The name, since there is one tracker and one base; for a step the key, since there may be several."""
        return self.key if self.by == STEP else self.name

    def same_place(self, other: Effect) -> bool:
        """Return whether the other is a drift of the target as well."""
        return isinstance(other, TargetDrift)

    def imitators(self, dataset: Dataset) -> list[Effect]:
        """Return changes of a link, of the whole arm, or of its load, at the moment of the step, or at several moments of the campaign."""
        return rivals_of_change(dataset, self.order, but_link=1)

    @property
    def is_change_in_time(self) -> bool:
        """Always true."""
        return True

    def not_transferable(self, dataset: Dataset) -> str | None:
        """Return that it belongs to one campaign."""
        return "the tracker or the base moved in one campaign only"

    @property
    def clause(self) -> str:
        """Return that it moved, when, and what shows it."""
        if self.by == STEP:
            return f"the tracker or the base stood elsewhere from the pose of order {self.order:.0f} on"
        shown = ", as the references on the base show" if self.by == REFERENCES else ""
        return f"the tracker or the base moved in the course of the campaign{shown}"

    @property
    def advice(self) -> list[str]:
        """Return what to do about it."""
        if self.by == STEP:
            return [
                f"Give the poses from order {self.order:.0f} on {OWN_SESSION}: the tracker may have been "
                "knocked or set up anew, or the base of the robot moved. Before the next campaign, tighten the base's bolts and stand the tracker "
                "where nobody walks."
            ]
        return [
            "Let the tracker warm up on firm ground, and measure three nests on the robot's base at every pose: they say how the tracker moves, so "
            "that it can be taken off."
        ]

    @property
    def how_to_measure(self) -> str:
        """Return how to see it directly."""
        return (
            "To see it directly, measure a nest on the robot's base every few minutes with the arm at rest, with an inclinometer on the base next to "
            "it: a tracker that drifts moves the nest, and leaves the inclinometer as it is."
        )

    @property
    def in_controller(self) -> str:
        """Return what changes in the controller."""
        return "Nothing in the controller: the movement belongs to the campaign, and the parameters of the arm are free of it."

    def pictures(self, view: View) -> list[Profile | Map]:
        """Return the shift of the middle of the measured positions along its main direction in the course of the campaign."""
        middle = view.nominal.flange(view.poses.q)[:, :3, 3].mean(axis=0)
        screws = self.base_screws(view.nominal, view.poses) @ self.coefficients
        shifts = screws[:, 3:] + np.cross(screws[:, :3], middle)
        direction = np.linalg.svd(shifts - shifts.mean(axis=0), full_matrices=False)[2][0]
        motion = np.zeros((len(screws), 6))
        motion[:, 3:] = direction
        rest, std = view.estimated_along(motion)
        fitted = shifts @ direction
        clock = view.poses.columns["time"] if self.by == "time" else view.poses.order
        if self.by in (REFERENCES, STEP):
            at = np.argsort(clock)
            curve = np.stack([clock[at], fitted[at], np.zeros(len(at))])
        else:
            x = np.linspace(clock.min(), clock.max(), CURVE_POINTS)
            along = np.r_[np.cross(middle, direction), direction]
            basis = np.einsum("nk,j->nkj", self._profile(x), along).reshape(len(x), -1)
            curve = np.stack([x, basis @ self.coefficients, view.error_of(self, basis)])
        axis = Axis("shift of the measured positions relative to the tracker", "m")
        x_axis = variable_axis("time" if self.by == "time" else "order", view.nominal)
        return [Profile(x_axis, axis, clock, fitted + rest, rest, std, fitted, curve, mark=self.order)]

    def size(self, pictures: Sequence[Profile | Map]) -> str:
        """Return how far the middle of the measured positions was moved."""
        return largest(pictures, "")
