"""Errors of the plates: one that is not flat, one that is knocked or creeps while it is scanned."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Self

import numpy as np

from scalar.data.poses import Poses
from scalar.effects.effect import PointEffect
from scalar.geometry.planes import Planes
from scalar.geometry.se3 import Array

_STEEP = 0.9  # |n_x|: a plate that faces the base's x axis more than this has its first axis along y


def _plate_axes(planes: Planes, name: str, plane_index: Array) -> tuple[Array, Array, Array]:
    """Return which poses measure a plate, in whatever session ``(N,)``, and the plate's axes u and v ``(N, 3)`` each.

    u is the base's x axis, or y on a plate that faces x, turned into the plate: it depends on where the plate is and not on what its
    coordinates are counted from, so that coefficients mean the same in a fit and in a file.
    """
    mine = [k for k, other in enumerate(planes.names) if other.split("@")[0] == name or other == name]
    if not mine:
        raise ValueError(f"no plane '{name}'; there are {', '.join(planes.names)}")
    normals = planes.normals
    axes = np.where(np.abs(normals[:, :1]) > _STEEP, np.eye(3)[1], np.eye(3)[0])
    u = axes - normals * np.sum(axes * normals, axis=1, keepdims=True)
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    v = np.cross(normals, u)
    return np.isin(plane_index, mine), u[plane_index], v[plane_index]


def _heights(carriers: Array, along: Array) -> Array:
    """Return each pose's carriers ``(N, 3, 3)`` along a direction ``(N, 3)``."""
    return np.einsum("nkx,nx->nk", carriers, along)


@dataclass(frozen=True, eq=False)
class PlaneBow(PointEffect):
    """A plate is a paraboloid over its plane: ``h = c_uu u^2 + c_uv u v + c_vv v^2``, u and v from the middle of what was scanned.

    Attributes:
        plane: Its name.
        centre: ``(3,)`` [m], base frame.
    """

    plane: str
    centre: tuple[float, float, float]

    name: ClassVar[str] = "plane_bow"
    sentence: ClassVar[str] = "the plate is not flat"
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
        """Return minus the height as a quadratic form of (1, x, z)."""
        mine, e1, e2 = _plate_axes(planes, self.plane, plane_index)
        offset = T_base_sensor[:, :3, 3] - np.array(self.centre)
        carriers = np.stack([offset, T_base_sensor[:, :3, 0], T_base_sensor[:, :3, 2]], axis=1)
        u, v = _heights(carriers, e1), _heights(carriers, e2)
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


@dataclass(frozen=True, eq=False)
class PlaneMoved(PointEffect):
    """A plate stands elsewhere from a pose on, or creeps: distance and tilt change by a step, or by a ramp.

    Attributes:
        plane: Its name.
        order: Order of acquisition of the first pose after the step; of the beginning of the creep.
        time: Its time [s], or None.
        centre: ``(3,)`` [m], base frame: the tilt turns about it.
        creep_span: Zero for a step; else the span of order over which a creep reaches the stated change, and stays.
    """

    plane: str
    order: float
    time: float | None
    centre: tuple[float, float, float]
    creep_span: float = 0.0

    name: ClassVar[str] = "plane_moved"
    sentence: ClassVar[str] = "the plate was knocked or crept while it was measured"
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
    def plausible_sizes(self) -> Array:
        """Return two centimetres and three degrees: what is knocked moves far."""
        return np.array([0.02 if unit == "m" else 0.05 for unit in self.coefficient_units])

    def course(self, order: Array) -> Array:
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

    def contact_columns(
        self, poses: Poses, T_base_sensor: Array, planes: Any, plane_index: Array, contact: Array
    ) -> Array:
        """Return minus the height of the moved plate over the old one, linear in (1, x, z)."""
        mine, e1, e2 = _plate_axes(planes, self.plane, plane_index)
        offset = T_base_sensor[:, :3, 3] - np.array(self.centre)
        carriers = np.stack([offset, T_base_sensor[:, :3, 0], T_base_sensor[:, :3, 2]], axis=1)
        b = contact.shape[1] if contact.shape[1] == 1 else 3
        G = np.zeros((len(contact), 3, 3))
        G[:, 0, 0] = -1.0
        G[:, :, 1], G[:, :, 2] = -_heights(carriers, e1), -_heights(carriers, e2)
        G *= (self.course(poses.order) * mine)[:, None, None]
        return G[:, :b]

    def to_mapping(self) -> dict[str, Any]:
        """Return plane, moment and centre."""
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
