"""A sensor or tool that shifts on the flange."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from scalar.data.poses import Poses
from scalar.effects.acquisition import ALWAYS, knock_std
from scalar.effects.command_words import start_named
from scalar.effects.effect import Effect
from scalar.effects.flexible.rivals_of_changes import rivals_of_change
from scalar.effects.picture import Axis, Map, Profile, View, largest, variable_axis
from scalar.effects.places import SensorEffect
from scalar.effects.wording import OWN_SESSION
from scalar.geometry.robot import Robot
from scalar.geometry.screws import change_frame
from scalar.geometry.se3 import Array
from scalar.sensors import kind_of

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset

_COMPONENTS = ("x", "y", "z", "rx", "ry", "rz")


@dataclass(frozen=True, eq=False)
class SensorSlip(SensorEffect):
    """The sensor sits elsewhere on the flange from a pose on.

    Attributes:
        order: Order of acquisition of the first pose after the slip.
        time: The time of that pose [s], or None.
        turns: Whether the rotation is observable as well (a probe's is not).
    """

    order: float
    time: float | None = None
    turns: bool = True

    name: ClassVar[str] = "sensor_slip"
    kind: ClassVar[str] = "slip of the sensor"
    sentence: ClassVar[str] = "the sensor sat elsewhere on the flange from one pose on"
    natural: ClassVar[Mapping[str, float]] = {"m": 5e-4, "rad": 1e-3}
    natural_source: ClassVar[str] = "assumed: the play of a screw in its hole; a knock may be any size"
    acts_by_joint_angles: ClassVar[bool] = False
    usual_odds: ClassVar[float] = 30.0  # wrong in 4 of 12 with less, in 0 of 827 with more

    @property
    def target(self) -> dict[str, Any]:
        """When the slip happened."""
        return {"at": {"order": self.order, "time": self.time}}

    @property
    def coefficient_names(self) -> list[str]:
        """Translation and rotation in the sensor's frame."""
        names = [f"{c}_m" for c in _COMPONENTS[:3]]
        return names + [f"{c}_rad" for c in _COMPONENTS[3:]] if self.turns else names

    @property
    def coefficient_units(self) -> list[str]:
        """Metres and radians."""
        return ["m"] * 3 + (["rad"] * 3 if self.turns else [])

    @property
    def prior_std(self) -> Array:
        """Return two centimetres and three degrees, since a knock may move a sensor far."""
        return knock_std(self.coefficient_units)

    def sensor_screws(self, robot: Robot, poses: Poses) -> Array:
        """Return unit motions of the sensor for poses after the slip, and zeros for those before."""
        after = (poses.order >= self.order).astype(float)
        unit = np.zeros((6, len(self.coefficient_names)))
        unit[3:, :3] = np.eye(3)
        if self.turns:
            unit[:3, 3:] = np.eye(3)
        return after[:, None, None] * unit

    def to_mapping(self) -> dict[str, Any]:
        """Return when the slip happened, and whether the rotation is fitted."""
        return {"order": self.order, "time": self.time, "turns": self.turns}

    @classmethod
    def from_mapping(cls, mapping: Mapping[str, Any]) -> Self:
        """Return the effect of ``to_mapping``."""
        time = mapping["time"]
        return cls(float(mapping["order"]), None if time is None else float(time), bool(mapping["turns"]))

    @classmethod
    def changes(cls, dataset: Dataset) -> list[tuple[Effect, Array]]:
        """Return a slip at any pose."""
        return [
            (cls(ALWAYS, turns=kind_of(dataset).shows_turns(dataset)), np.ones(dataset.n_poses, dtype=bool))
        ]

    def beginning(self, order: float, time: float | None) -> Self:
        """Return a slip at a pose."""
        return replace(self, order=order, time=time, coefficients=np.zeros(len(self.coefficients)))

    @classmethod
    def parsed(cls, dataset: Dataset, words: Sequence[str]) -> list[Effect]:
        """Return a slip from the order of acquisition that is named."""
        if not words:
            raise ValueError("say from which order on, as in sensor_slip:120")
        return [cls(start_named(words[0]), turns=kind_of(dataset).shows_turns(dataset))]

    @property
    def label(self) -> str:
        """The key: name and order of acquisition."""
        return self.key

    def same_place(self, other: Effect) -> bool:
        """Return whether the other is a slip as well, at any time."""
        return isinstance(other, SensorSlip)

    def since(self, poses: Poses) -> Array | None:
        """Return at which poses the sensor has slipped ``(N,)``."""
        return poses.order >= self.order

    def imitators(self, dataset: Dataset) -> list[Effect]:
        """Return changes of a link, of the whole arm, or of its load, at that moment."""
        return rivals_of_change(dataset, self.order, but_link=dataset.robot.n_joints)

    @property
    def is_change_in_time(self) -> bool:
        """Always true."""
        return True

    def not_transferable(self, dataset: Dataset) -> str | None:
        """Return that a slip belongs to one campaign."""
        return "the sensor slipped in one campaign only"

    @property
    def clause(self) -> str:
        """Return when the sensor slipped."""
        return f"the sensor slipped on the flange before the pose of order {self.order:.0f}"

    @property
    def advice(self) -> list[str]:
        """Return what to do about it."""
        return [
            "Tighten the sensor's mount on the flange and measure again, or give the poses from order "
            f"{self.order:.0f} on {OWN_SESSION}."
        ]

    @property
    def how_to_measure(self) -> str:
        """Return how to see it directly."""
        return "To see it directly, repeat one pose at the beginning, in the middle and at the end of a campaign: a sensor that slips shows at once."

    @property
    def in_controller(self) -> str:
        """Return what changes in the controller."""
        return "Teach the tool frame of the sensor again when its mount is tight: a slip changes no length or angle of the arm."

    def pictures(self, view: View) -> list[Profile | Map]:
        """Return the shift along the fitted motion in order of acquisition."""
        order = view.poses.order
        shift = float(np.linalg.norm(self.coefficients[:3]))
        motion = np.zeros(6)
        motion[3:] = self.coefficients[:3]
        if self.turns:
            motion[:3] = self.coefficients[3:]
        repeated = np.broadcast_to(motion[:, None], (len(order), 6, 1))
        rest, std = view.estimated_along(
            change_frame(view.T_base_sensor, repeated)[:, :, 0] / max(shift, 1e-300)
        )
        fitted = np.where(order >= self.order, shift, 0.0)
        at = np.array([order.min(), self.order, self.order, order.max()])
        curve = np.stack([at, np.array([0.0, 0.0, shift, shift]), np.zeros(4)])
        y_axis = Axis("slip of the sensor along the fitted motion", "m")
        note = "If the sensor turned as well, the turn is included in proportion." if self.turns else ""
        x_axis, mark = variable_axis("order", view.nominal), self.order
        return [Profile(x_axis, y_axis, order, fitted + rest, rest, std, fitted, curve, mark=mark, note=note)]

    def size(self, pictures: Sequence[Profile | Map]) -> str:
        """Return how far the sensor shifted."""
        return largest(pictures, "")
