"""A pedestal that tilts under the arm's moving weight."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from scalar.data.poses import Poses
from scalar.effects.acquisition import turning_joints
from scalar.effects.effect import WEIGHT, Effect, Table
from scalar.effects.flexible.tilt import tilts
from scalar.effects.flexible.wobble import wobbles_of
from scalar.effects.gravity import AXES, unit_moments_at
from scalar.effects.joint_compliance import JointCompliance
from scalar.effects.picture import Axis, Map, Profile, View
from scalar.effects.places import BaseEffect
from scalar.effects.typical_weight import base_along_weight
from scalar.geometry.planes import tangent_basis
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import Array, cross

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset


HORIZONTAL = 0.5  # largest cosine of the angle between the axis of a rail and the vertical


@dataclass(frozen=True, eq=False)
class BaseCompliance(BaseEffect):
    """The base tilts about its origin under the moment of the arm's weight, possibly more easily about one horizontal axis than about another.

    An arm on a rail tilts about its carriage: a rail rests on the floor along its length, and where it is not straight, its carriage tilts by the
    travel, whatever it weighs. The travel therefore adds no moment.

    ``w = sum over frames i and axes e of C_ie (R_i e) x g / |g|``: the tilt about a horizontal axis is proportional to the moment about it.

    Attributes:
        frames: The frames, from 1, whose first moments of mass act.
        alike: Whether the base is equally stiff about every horizontal axis. Each frame then has two coefficients, one for each component of its
            first moment; else it has four, because each component tilts the base about two axes by different amounts.
    """

    frames: tuple[int, ...]
    alike: bool = False

    name: ClassVar[str] = "base_compliance"
    imitators_are_as_likely: ClassVar[bool] = True
    load: ClassVar[str] = WEIGHT
    kind: ClassVar[str] = "compliance of the base"
    sentence: ClassVar[str] = (
        "the base tilts a little under the moving weight of the arm: its pedestal or its bolts give way"
    )
    natural: ClassVar[Mapping[str, float]] = {"rad": 5e-4}
    natural_source: ClassVar[str] = (
        "assumed: half a millimetre at a metre; it depends on the floor, and no data sheet states it"
    )

    @property
    def target(self) -> dict[str, Any]:
        """Empty: there is one base."""
        return {}

    @property
    def coefficient_names(self) -> list[str]:
        """``frame3_x_rad``, ``tilt_u_frame3_x_rad``: tilt (about u) at full leverage of a first moment along x of frame 3."""
        if self.alike:
            return [f"frame{f}_{axis}_rad" for f in self.frames for axis in AXES]
        return [
            f"tilt_{tilt}_frame{f}_{axis}_rad" for f in self.frames for axis in AXES for tilt in ("u", "v")
        ]

    @property
    def coefficient_units(self) -> list[str]:
        """Radians."""
        return ["rad"] * ((2 if self.alike else 4) * len(self.frames))

    @property
    def plausible_std(self) -> Array:
        """Return the natural sizes: two effects of the same weight that almost cancel at the measured poses would add up at others."""
        return self.natural_sizes

    def base_screws(self, robot: Robot, poses: Poses) -> Array:
        """Return the tilts by unit first moments of mass, as rotations about the origin of the base frame, or about a carriage on a rail."""
        moments, _ = unit_moments_at(robot, poses)
        index = np.array(self.frames) - 1
        across = tangent_basis(robot.down[None])[0]
        if self.alike:
            w = moments[:, index].reshape(len(poses), len(self.coefficient_units), 3)
            return _about_carriage(robot, poses, w)
        by_axis = np.einsum("nfax,tx->nfat", moments[:, index], across)
        w = (by_axis[..., None] * across).reshape(len(poses), len(self.coefficient_units), 3)
        return _about_carriage(robot, poses, w)

    def along_typical_weight(self, robot: Robot, poses: Poses) -> float | None:
        """Return how well the tilt follows the moment of typical masses."""
        tilts = self.base_screws(robot, poses)[:, :3] @ self.coefficients
        return base_along_weight(robot, poses.q, _frames_that_load(robot)[0], tilts)

    def to_mapping(self) -> dict[str, Any]:
        """Return the frames."""
        return {"frames": list(self.frames), "alike": self.alike}

    @classmethod
    def from_mapping(cls, mapping: Mapping[str, Any]) -> Self:
        """Return the effect of ``to_mapping``."""
        return cls(tuple(int(f) for f in mapping["frames"]), bool(mapping["alike"]))

    @classmethod
    def candidates(cls, dataset: Dataset) -> list[Effect]:
        """Return a base that is equally stiff about every horizontal axis, and one that is not."""
        frames = _frames_that_load(dataset.robot)
        return [cls(frames, alike) for alike in (True, False)] if frames else []

    def imitators(self, dataset: Dataset) -> list[Effect]:
        """Return tilts of the joints' axes, and of the base, under the weight that they bear, and the wobble of the first axis that turns.

        The weight of the link that it turns, off the axis, tilts a base that is stiffer about one horizontal axis just as such a wobble does.
        """
        return [*tilts(dataset, with_base=True), *wobbles_of(turning_joints(dataset)[:1])]

    def giving_way_like(self, other: Effect) -> list[tuple[str, Array]]:
        """Return the coefficients of a base that tilts as far about every horizontal axis as a joint turns under the same moment.

        Args:
            other: With fitted coefficients; only a ``JointCompliance`` has such joints.

        Returns:
            One pair for each of its joints: the joint in words, and the coefficients ``(2 F,)`` [rad], two for each of the F ``frames``. No pair for
            another effect, or if this base has a compliance of its own about each axis (``alike`` is False).
        """
        if not self.alike or not isinstance(other, JointCompliance):
            return []
        found = []
        for joint in other.target["joints"]:
            terms = [k for k, (bends, _) in enumerate(other.terms) if bends == joint]
            by_frame = {other.terms[k][1]: other.coefficients[2 * k : 2 * k + 2] for k in terms}
            each = [by_frame.get(frame, np.zeros(2)) for frame in self.frames]
            found.append((f"joint {joint}", np.concatenate(each)))
        return found

    @classmethod
    def in_many_arms(cls, dataset: Dataset) -> list[Effect]:
        """Return all candidates."""
        return cls.candidates(dataset)

    @classmethod
    def parsed(cls, dataset: Dataset, words: Sequence[str]) -> list[Effect]:
        """Return a base whose stiffness differs between two axes, under the weight of every link."""
        return [cls(_frames_that_load(dataset.robot))]

    @property
    def n_terms(self) -> int:
        """Return the number of frames."""
        return len(self.frames)

    def with_terms(self, chosen: Sequence[int]) -> Effect:
        """Return the tilt under the weight of some frames only."""
        return BaseCompliance(tuple(self.frames[i] for i in sorted(chosen)), self.alike)

    def merged_with(self, other: Effect) -> Effect | None:
        """Return the frames of both: there is one base."""
        if not isinstance(other, BaseCompliance):
            return None
        frames = tuple(sorted({*self.frames, *other.frames}))
        return BaseCompliance(frames, self.alike and other.alike).with_coefficients_of(self)

    @property
    def label(self) -> str:
        """The name: there is one base."""
        return self.name

    def same_place(self, other: Effect) -> bool:
        """Return whether the other is a compliance of the base as well."""
        return isinstance(other, BaseCompliance)

    @property
    def clause(self) -> str:
        """Return that the base tilts."""
        return "the base tilts under the weight of the arm"

    def table(self, std: Sequence[float | None]) -> Table | None:
        """Return the coefficients as a table whose rows say which first moment of mass tilts the base."""
        table = super().table(std)
        assert table is not None
        head, rows = table
        places = [(frame, axis) for frame in self.frames for axis in AXES]
        titles = [
            f"tilt {about}by the masses along {axis} of frame {frame}"
            for frame, axis in places
            for about in (("",) if self.alike else ("about u ", "about v "))
        ]
        return head, [(title, *row[1:]) for title, row in zip(titles, rows, strict=True)]

    @property
    def advice(self) -> list[str]:
        """Return what to do about it."""
        return ["Tighten the bolts of the base, stiffen its pedestal, and measure again."]

    @property
    def how_to_measure(self) -> str:
        """Return how to see it directly."""
        return (
            "To see it directly, put an inclinometer on the base and move the arm from a folded to a stretched pose: "
            "the reading should not change."
        )

    @property
    def in_controller(self) -> str:
        """Return what changes in the controller."""
        return "No parameter of a controller holds a base that gives way: until it is stiff, programs have to be corrected."

    def pictures(self, view: View) -> list[Profile | Map]:
        """Return the tilt over the overturning moment."""
        w = self.base_screws(view.nominal, view.poses) @ self.coefficients
        size = np.linalg.norm(w[:, :3], axis=1)
        largest = max(float(size.max()), 1e-300)
        rest, std = view.estimated_along(w / np.maximum(size, 1e-300)[:, None])
        curve = np.array([[0.0, 1.0], [0.0, largest], [0.0, 0.0]])
        x_axis, y_axis = (
            Axis("overturning moment, relative to the largest", "1"),
            Axis("tilt of the base", "rad"),
        )
        note = (
            "How the moment depends on the pose is fitted too, since the masses of the links are not known."
        )
        return [Profile(x_axis, y_axis, size / largest, size + rest, rest, std, size, curve, note=note)]


def _frames_that_load(robot: Robot) -> tuple[int, ...]:
    """Return the frames, from 1, whose first moments of mass tilt the base: all but those of rails."""
    rails, _ = _rails(robot)
    return tuple(f for f in range(1, robot.n_joints + 1) if f - 1 not in rails)


def _rails(robot: Robot) -> tuple[list[int], Array]:
    """Return the joints, from 0, that slide horizontally below the first joint that turns, and their axes ``(r, 3)`` in the base frame."""
    sliding = list(itertools.takewhile(lambda j: j in robot.prismatic, range(robot.n_joints)))
    if not sliding:
        return [], np.zeros((0, 3))
    axes = robot.frames(np.zeros((1, robot.n_joints)))[0, 1:, :3, 2]
    rails = [j for j in sliding if abs(float(axes[j] @ robot.down)) < HORIZONTAL]
    return rails, axes[rails]


def _about_carriage(robot: Robot, poses: Poses, w: Array) -> Array:
    """Return screws ``(N, 6, k)`` of tilts ``(N, k, 3)`` about the place to which rails carry the origin of the base frame."""
    rails, axes = _rails(robot)
    v = np.zeros_like(w)
    if rails:
        place = poses.q[:, rails] @ axes
        v = cross(np.broadcast_to(place[:, None, :], w.shape), w)
    return np.concatenate([np.swapaxes(w, 1, 2), np.swapaxes(v, 1, 2)], axis=1)
