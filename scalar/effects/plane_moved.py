"""A target plane that is knocked, or creeps, while it is measured."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from scalar.data.poses import Poses
from scalar.effects.acquisition import ALWAYS, knock_std, on_plane, order_and_time, plane_centre, used_planes
from scalar.effects.command_words import planes_named, start_named
from scalar.effects.effect import Effect
from scalar.effects.flexible.rivals_of_changes import rivals_of_change
from scalar.effects.picture import Axis, Map, Profile, View, variable_axis
from scalar.effects.places import PointEffect
from scalar.effects.plane_axes import coordinates_by_sensor_axes
from scalar.effects.remedies import nothing_for_the_plane
from scalar.effects.wording import OWN_SESSION, listed
from scalar.geometry.se3 import Array

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset

# Number of beginnings of a creep that are tried, spread evenly over the orders at which the plane is measured.
CREEP_STARTS = 12
# Lengths of a creep that are tried, as shares of the range of these orders; a creep ends at the last order at the latest.
CREEP_SHARES = (0.1, 0.3, 1.0)


@dataclass(frozen=True, eq=False)
class PlaneMoved(PointEffect):
    """A target plane stands elsewhere from a pose on, or creeps: its distance and tilt change by a step, or by a ramp.

    Attributes:
        plane: Its name.
        order: Order of acquisition of the first pose after the step, or at the beginning of the creep.
        time: The time of that pose [s], or None.
        centre: ``(3,)`` [m], the point in the base frame about which the plane tilts.
        creep_span: Zero for a step; else the range of orders over which a creep reaches the stated change, which then remains.
    """

    plane: str
    order: float
    time: float | None
    centre: tuple[float, float, float]
    creep_span: float = 0.0

    name: ClassVar[str] = "plane_moved"
    kind: ClassVar[str] = "movement"
    sentence: ClassVar[str] = "the target plane was knocked or crept while it was measured"
    natural: ClassVar[Mapping[str, float]] = {"m": 1e-3, "rad": 1e-3}
    natural_source: ClassVar[str] = (
        "assumed: a knock may have any size, and a creep of a millimetre would be noticed"
    )
    most_words: ClassVar[int] = 2
    basis_names: ClassVar[tuple[str, ...]] = ("1", "x", "z")

    @property
    def target(self) -> dict[str, Any]:
        """The plane and when."""
        return {"plane": self.plane, "at": {"order": self.order, "time": self.time}}

    @property
    def coefficient_names(self) -> list[str]:
        """Change of distance and of tilt."""
        return ["distance_m", "tilt_u_rad", "tilt_v_rad"]

    @property
    def coefficient_units(self) -> list[str]:
        """Metres and radians."""
        return ["m", "rad", "rad"]

    @property
    def prior_std(self) -> Array:
        """Return two centimetres and three degrees, since a knock may move a plane far."""
        return knock_std(self.coefficient_units)

    def profile(self, order: Array) -> Array:
        """Return how much of the change has happened at each order ``(N,)``."""
        if self.creep_span:
            return np.clip((order - self.order) / self.creep_span, 0.0, 1.0)
        return (order >= self.order).astype(float)

    def variations(self, scale: float) -> list[Self]:
        """Return a creep that begins and ends a little earlier or later."""
        step = scale * self.creep_span / 8
        if not step:
            return [self]
        return [
            replace(self, order=self.order + a * step, creep_span=self.creep_span + (b - a) * step)
            for a in (-1.0, -0.5, 0.0, 0.5, 1.0)
            for b in (-1.0, 0.0, 1.0)
        ]

    def constant_and_shares(self, poses: Poses) -> tuple[PointEffect, Array] | None:
        """Return the plane that stands elsewhere all the time, and the profile."""
        always = replace(self, order=ALWAYS, time=None, creep_span=0.0)
        return None if self.order == ALWAYS else (always, self.profile(poses.order))

    def contact_columns(
        self, poses: Poses, T_base_sensor: Array, planes: Any, plane_index: Array, contact: Array
    ) -> Array:
        """Return ``(N, 3, 3)``, or ``(N, 1, 3)`` for a probe: minus the height of the moved plane over its first place.

        The height at the measured point is ``distance_m + u tilt_u_rad + v tilt_v_rad``, with u and v [m] along the plane from ``centre``. It is
        linear in (1, x, z), where x and z are the point's coordinates in the sensor frame.
        """
        centre = np.array(self.centre)
        mine, u, v = coordinates_by_sensor_axes(planes, self.plane, plane_index, T_base_sensor, centre)
        b = contact.shape[1] if contact.shape[1] == 1 else 3
        G = np.zeros((len(contact), 3, 3))
        G[:, 0, 0] = -1.0
        G[:, :, 1], G[:, :, 2] = -u, -v
        G *= (self.profile(poses.order) * mine)[:, None, None]
        return G[:, :b]

    def to_mapping(self) -> dict[str, Any]:
        """Return plane, beginning, centre and the span of a creep."""
        return {
            "plane": self.plane,
            "order": self.order,
            "time": self.time,
            "centre": list(self.centre),
            "creep_span": self.creep_span,
        }

    @classmethod
    def from_mapping(cls, mapping: Mapping[str, Any]) -> Self:
        """Return the effect of ``to_mapping``."""
        x, y, z = (float(c) for c in mapping["centre"])
        time = mapping["time"]
        return cls(
            str(mapping["plane"]), float(mapping["order"]), None if time is None else float(time), (x, y, z),
            float(mapping["creep_span"]),
        )  # fmt: skip

    @classmethod
    def candidates(cls, dataset: Dataset) -> list[Effect]:
        """Return creeps of every plane, from several beginnings on, to the end of its poses or to an earlier stop."""
        order, time = order_and_time(dataset)
        found: list[Effect] = []
        for name in used_planes(dataset):
            mine = np.flatnonzero(on_plane(dataset, name))
            span, end = float(np.ptp(order[mine])), float(order[mine[-1]])
            if span <= 0:
                continue
            centre = plane_centre(dataset, name)
            starts = np.unique(
                np.searchsorted(order[mine], order[mine[0]] + span * np.arange(CREEP_STARTS) / CREEP_STARTS)
            )
            for i in mine[starts]:
                start, at = float(order[i]), None if time is None else float(time[i])
                spans = {min(share * span, end - start) for share in CREEP_SHARES}
                found += [cls(name, start, at, centre, creep) for creep in sorted(spans) if creep > 0]
        return found

    @classmethod
    def changes(cls, dataset: Dataset) -> list[tuple[Effect, Array]]:
        """Return a knock of every plane at any of its poses."""
        return [
            (cls(name, ALWAYS, None, plane_centre(dataset, name)), on_plane(dataset, name))
            for name in used_planes(dataset)
        ]

    def beginning(self, order: float, time: float | None) -> Self:
        """Return a knock at a pose."""
        return replace(self, order=order, time=time, coefficients=np.zeros(len(self.coefficients)))

    @classmethod
    def parsed(cls, dataset: Dataset, words: Sequence[str]) -> list[Effect]:
        """Return a knock of the plane that is named, at the order of acquisition that is named."""
        if len(words) < 2:
            raise ValueError("name the plane and from which order on, as in plane_moved:floor:120")
        plane = planes_named(dataset, words)[0]
        return [cls(plane, start_named(words[1]), None, plane_centre(dataset, plane))]

    def at_a_pose(self, dataset: Dataset, poses: Poses) -> Self:
        """Return a creep that begins at the first pose of its plane after where it was found to begin, and ends where it did."""
        order = poses.order
        mine = np.flatnonzero(on_plane(dataset, self.plane))
        i = mine[min(int(np.searchsorted(order[mine], self.order)), len(mine) - 1)]
        time = poses.columns.get("time")
        span = self.order + self.creep_span - float(order[i])
        if span <= 0:
            return self
        at = None if time is None else float(time[i])
        return replace(self, order=float(order[i]), time=at, creep_span=span)

    @property
    def label(self) -> str:
        """The key: name, plane and order of acquisition."""
        return self.key

    def same_place(self, other: Effect) -> bool:
        """Return whether the other moves the same plane, at any time."""
        return isinstance(other, PlaneMoved) and self.plane == other.plane

    def imitators(self, dataset: Dataset) -> list[Effect]:
        """Return changes of a link, of the whole arm, or of its load, at that moment."""
        return rivals_of_change(dataset, self.order)

    @property
    def is_change_in_time(self) -> bool:
        """Always true."""
        return True

    @property
    def takes_time(self) -> bool:
        """Return whether the plane creeps."""
        return bool(self.creep_span)

    def not_transferable(self, dataset: Dataset) -> str | None:
        """Return that planes are another campaign's."""
        return "the planes are set up anew for every campaign"

    @property
    def clause(self) -> str:
        """Return which plane moved, and when."""
        when = f"from the pose of order {self.order:.0f} on"
        return f"target plane {self.plane} {'crept' if self.creep_span else 'stood elsewhere'} {when}"

    @classmethod
    def clause_of(cls, effects: Sequence[Effect]) -> str:
        """Return which planes moved."""
        names = list(dict.fromkeys(str(effect.target["plane"]) for effect in effects))
        if len(effects) == 1:
            return effects[0].clause
        return f"target plane{'s' if len(names) > 1 else ''} {listed(names)} moved during the acquisition"

    @property
    def advice(self) -> list[str]:
        """Return how to avoid it."""
        return [
            f"Clamp target plane {self.plane} and measure again, or give the poses from order "
            f"{self.order:.0f} on {OWN_SESSION}."
        ]

    @property
    def how_to_measure(self) -> str:
        """Return how to see it directly."""
        return f"To see it directly, measure a few poses on target plane {self.plane} at the beginning and again at the end of each campaign."

    @property
    def in_controller(self) -> str:
        """Return what changes in the controller."""
        return nothing_for_the_plane(self.plane)

    def pictures(self, view: View) -> list[Profile | Map]:
        """Return the heights of the plane's scans over the plane where it stood first, in order of acquisition."""
        found = view.pieces(self)
        mine = view.on_plane(self.plane)[found.pose]
        N, pose = len(view.poses), found.pose[mine]
        n, touched = np.maximum(np.bincount(pose, minlength=N), 1), np.unique(pose)

        def mean(values: Array) -> Array:
            return (np.bincount(pose, values[mine], N) / n)[touched]

        rest, fitted = mean(found.height), -mean(found.of_effect)
        std = np.sqrt(mean(found.std**2) / n[touched])
        order = view.poses.order[touched]
        axis = Axis("height over the plane as it stood first", "m")
        turned = self.coefficients[1:].any()
        note = "A tilted plane rises at some poses and falls at others." if turned else ""
        x_axis, mark = variable_axis("order", view.nominal), self.order
        return [
            Profile(x_axis, axis, order, fitted + rest, rest, std, fitted, mark=mark, pose=touched, note=note)
        ]
