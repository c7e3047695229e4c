"""A target plane that is not flat."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from scalar.data.poses import Poses
from scalar.effects.acquisition import plane_centre, used_planes
from scalar.effects.command_words import planes_named
from scalar.effects.effect import Effect
from scalar.effects.flexible.profile_bow import profile_bow
from scalar.effects.picture import Axis, Map, Profile, View
from scalar.effects.places import PointEffect
from scalar.effects.plane_axes import coordinates_by_sensor_axes
from scalar.effects.remedies import nothing_for_the_plane
from scalar.effects.wording import listed
from scalar.geometry.se3 import Array
from scalar.sensors import kind_of
from scalar.sensors.scan_pieces import PIECES

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset


@dataclass(frozen=True, eq=False)
class PlaneBow(PointEffect):
    """A target plane is bowed: its height is ``h = c_uu u^2 + c_uv u v + c_vv v^2``, with coordinates u and v in the plane from ``centre`` on.

    Attributes:
        plane: Its name.
        centre: ``(3,)`` [m], base frame: the middle of what was scanned, where u and v are zero.
    """

    plane: str
    centre: tuple[float, float, float]

    name: ClassVar[str] = "plane_bow"
    in_every_setup: ClassVar[bool] = True  # no plane is quite flat
    # In simulated exams where one plane was bowed, the name was wrong in 7 of 81 cases with less, and in none of 528 with more.
    usual_odds: ClassVar[float] = 30.0
    borne_out_by_others: ClassVar[bool] = True  # with two bowed planes or more, wrong in 3 of 4,000
    kind: ClassVar[str] = "bow"
    sentence: ClassVar[str] = "the target plane is not flat but bowed"
    natural: ClassVar[Mapping[str, float]] = {"1/m": 2e-3}
    natural_source: ClassVar[str] = (
        "cold-rolled sheet may be out of flat by millimetres over a metre (EN 10131): 0.5 mm at half a metre from the middle"
    )
    basis_names: ClassVar[tuple[str, ...]] = ("1", "x", "z", "xx", "xz", "zz")

    @property
    def target(self) -> dict[str, Any]:
        """The plane."""
        return {"plane": self.plane}

    @property
    def coefficient_names(self) -> list[str]:
        """The three curvatures."""
        return ["uu_per_m", "uv_per_m", "vv_per_m"]

    @property
    def coefficient_units(self) -> list[str]:
        """One over metres."""
        return ["1/m"] * 3

    def contact_columns(
        self, poses: Poses, T_base_sensor: Array, planes: Any, plane_index: Array, contact: Array
    ) -> Array:
        """Return the columns of minus the height, which is a quadratic form in (1, x, z)."""
        centre = np.array(self.centre)
        mine, u, v = coordinates_by_sensor_axes(planes, self.plane, plane_index, T_base_sensor, centre)
        columns = [_quadratic(u, u), _quadratic(u, v), _quadratic(v, v)]
        G = -np.stack(columns, axis=2)
        G[~mine] = 0.0
        return G

    def to_mapping(self) -> dict[str, Any]:
        """Return plane and centre."""
        return {"plane": self.plane, "centre": list(self.centre)}

    @classmethod
    def from_mapping(cls, mapping: Mapping[str, Any]) -> Self:
        """Return the effect of ``to_mapping``."""
        x, y, z = (float(c) for c in mapping["centre"])
        return cls(str(mapping["plane"]), (x, y, z))

    def imitators(self, dataset: Dataset) -> list[Effect]:
        """Return a bow of the scanner's profiles."""
        return [*profile_bow(dataset)]

    @classmethod
    def candidates(cls, dataset: Dataset) -> list[Effect]:
        """Return a bow of every plane that is measured, where the sensor scans planes."""
        used = used_planes(dataset) if kind_of(dataset).scans else []
        return [cls(p.name, plane_centre(dataset, p.name)) for p in dataset.planes if p.name in used]

    @classmethod
    def together(cls, dataset: Dataset) -> list[list[Effect]]:
        """Return the bows of all planes: plates of one make, set up alike, bend alike."""
        return [cls.candidates(dataset)]

    @classmethod
    def parsed(cls, dataset: Dataset, words: Sequence[str]) -> list[Effect]:
        """Return the bow of a plane, or of every plane."""
        return [cls(p, plane_centre(dataset, p)) for p in planes_named(dataset, words)]

    def not_transferable(self, dataset: Dataset) -> str | None:
        """Return that a bow belongs to the planes of one campaign."""
        return "the planes are set up anew for every campaign"

    @property
    def clause(self) -> str:
        """Return which plane is not flat."""
        return f"target plane {self.plane} is not flat"

    @classmethod
    def clause_of(cls, effects: Sequence[Effect]) -> str:
        """Return which planes are not flat."""
        names = list(dict.fromkeys(str(effect.target["plane"]) for effect in effects))
        return effects[0].clause if len(names) == 1 else f"target planes {listed(names)} are not flat"

    @property
    def advice(self) -> list[str]:
        """Return what to do about it."""
        return [
            f"Replace target plane {self.plane} by a flatter one, or support it so that it does not bend."
        ]

    @property
    def how_to_measure(self) -> str:
        """Return how to see it directly."""
        return (
            f"To see it directly, lay a straightedge over target plane {self.plane}, or move a dial gauge over it: "
            "the middle stands out or lies back."
        )

    @property
    def in_controller(self) -> str:
        """Return what changes in the controller."""
        return nothing_for_the_plane(self.plane)

    def pictures(self, view: View) -> list[Profile | Map]:
        """Return the heights over the plane, in the two base axes nearest to it."""
        found = view.pieces(self)
        mine = view.on_plane(self.plane)[found.pose]
        position, height = found.position[mine], found.height[mine]
        across = int(np.argmax(np.abs(view.normal_of(self.plane))))
        a, b = [i for i in range(3) if i != across]
        u_axis, v_axis = (Axis(f"{'xyz'[i]} of the base", "m") for i in (a, b))
        without = height - found.of_effect[mine]
        note = f"Each scan is cut in {PIECES} pieces." if len(found.pose) > len(view.poses) else ""
        y_axis = Axis("height over the plane", "m")
        return [
            Map(
                u_axis,
                v_axis,
                y_axis,
                position[:, a],
                position[:, b],
                without,
                height,
                found.pose[mine],
                note,
            )
        ]


def _quadratic(s: Array, t: Array) -> Array:
    """Return the product of two linear forms ``(N, 3)`` in (1, x, z) as coefficients of 1, x, z, xx, xz, zz ``(N, 6)``."""
    return np.stack(
        [
            s[:, 0] * t[:, 0],
            s[:, 0] * t[:, 1] + s[:, 1] * t[:, 0],
            s[:, 0] * t[:, 2] + s[:, 2] * t[:, 0],
            s[:, 1] * t[:, 1],
            s[:, 1] * t[:, 2] + s[:, 2] * t[:, 1],
            s[:, 2] * t[:, 2],
        ],
        axis=1,
    )
