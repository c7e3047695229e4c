"""Errors of target planes: one that is bowed (a mesh that the rays hit), and one that is moved, at once or gradually."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np
import pandas as pd

from scalar.simulation.effects import Rows
from scalar.simulation.injected.base import InjectedEffect
from scalar.simulation.injected.stage import Stage
from scalar.simulation.target_planes import TargetPlane
from scalar.simulation.transforms import Array, rotation_from_vector

FACET_ERROR = 2.5e-7  # m; the largest distance of a facet from the curved face
FACETS_MAX = 240  # along a side
FACETS_MIN = 8
LEVER = 1.0  # m; unless the entry states the tilt, a shift of a millimetre comes with a tilt by a milliradian


def draw_target_plane(entry: Mapping[str, Any], stage: Stage, rng: np.random.Generator) -> TargetPlane:
    """Return the target plane that the entry names, or one that is drawn."""
    k = int(rng.integers(len(stage.workcell.target_planes)))
    names = [target_plane.name for target_plane in stage.workcell.target_planes]
    return stage.workcell.target_planes[names.index(entry["target"].get("plane", names[k]))]


@dataclass(frozen=True, eq=False)
class PlaneBow(InjectedEffect):
    """The face stands h = c_1 s^2 + c_2 t^2 out of its plane, with s and t [m] along rotated axes from the middle of the scanned part.

    c_1 = size / radius^2, with either sign, so that |h| is `size` at the radius of the scanned part along s; c_2 = ratio c_1.
    """

    name: ClassVar[str] = "plane_bow"
    unit: ClassVar[str] = "m"

    @classmethod
    def inject(cls, entry: Mapping[str, Any], stage: Stage, rng: np.random.Generator) -> Self:
        """Draw the target plane, whether it bulges or is hollow, along what axis, and the ratio of curvatures."""
        target_plane = draw_target_plane(entry, stage, rng)
        sign, turn, ratio = rng.choice([-1.0, 1.0]), rng.uniform(0.0, np.pi), rng.random()
        ratio = ratio if entry["ratio"] is None else entry["ratio"]
        middle, radius = stage.scanned(target_plane)
        strongest = sign * entry["size"] / radius**2
        details = {
            "curvatures_per_m": [float(strongest), float(ratio * strongest)],
            "axis_turned_rad": turn,
            "middle_uv_m": middle.tolist(),
            "scanned_radius_m": radius,
        }
        return cls({"plane": target_plane.name}, entry["size"], details)

    def height(self, uv: Array) -> Array:
        """Return how far the face stands out of its plane (...) [m] at uv (..., 2) [m] from the target plane's centre."""
        turn = self.details["axis_turned_rad"]
        s, t = np.moveaxis(uv - self.details["middle_uv_m"], -1, 0)
        s, t = np.cos(turn) * s + np.sin(turn) * t, np.cos(turn) * t - np.sin(turn) * s
        first, second = self.details["curvatures_per_m"]
        return first * s**2 + second * t**2

    def target_planes(
        self, target_planes: tuple[TargetPlane, ...], poses: pd.DataFrame
    ) -> list[tuple[Rows, tuple[TargetPlane, ...]]]:
        """Return the target planes, one of them bent."""
        bent = tuple(
            self.bend(target_plane) if target_plane.name == self.target["plane"] else target_plane
            for target_plane in target_planes
        )
        return [(slice(None), bent)]

    def bend(self, target_plane: TargetPlane) -> TargetPlane:
        """Return a target plane with a mesh in the place of its flat face."""
        sharpest = np.abs(self.details["curvatures_per_m"]).max()
        # The largest distance of a chord of length L from a parabola c s^2 is c L^2 / 4.
        side = np.sqrt(4.0 * FACET_ERROR / max(sharpest, 1e-12)) / np.sqrt(2.0)
        return faceted(target_plane, side, self.height)


def faceted(target_plane: TargetPlane, side: float, height: Any) -> TargetPlane:
    """Return a target plane whose face is a mesh of triangles with legs of about `side` [m], raised by `height`(uv) [m]."""
    counts = np.clip(np.ceil(target_plane.size / side), FACETS_MIN, FACETS_MAX).astype(int)
    grids = [
        np.linspace(-0.5, 0.5, count + 1) * size
        for count, size in zip(counts, target_plane.size, strict=True)
    ]
    uv = np.stack(np.meshgrid(*grids, indexing="ij"), -1).reshape(-1, 2)
    rise = height(uv)
    vertices = target_plane.centre + uv @ target_plane.axes[:, :2].T + rise[:, None] * target_plane.axes[:, 2]
    corner = (np.arange(counts[0])[:, None] * (counts[1] + 1) + np.arange(counts[1])).ravel()
    across, along = corner + counts[1] + 1, corner + 1
    triangles = np.concatenate(
        [np.column_stack([corner, across, across + 1]), np.column_stack([corner, across + 1, along])]
    )
    return target_plane.moved(mesh=(vertices, triangles))


@dataclass(frozen=True, eq=False)
class PlaneMoved(InjectedEffect):
    """From one pose on, a target plane is shifted by size along its normal and tilted, at once or gradually (a creep)."""

    name: ClassVar[str] = "plane_moved"
    unit: ClassVar[str] = "m"

    @classmethod
    def inject(cls, entry: Mapping[str, Any], stage: Stage, rng: np.random.Generator) -> Self:
        """Draw the target plane, the pose (one of its own), the sign of the shift and the axis of the tilt."""
        target_plane = draw_target_plane(entry, stage, rng)
        on_it = np.flatnonzero(stage.plane_index == stage.workcell.target_planes.index(target_plane))
        moment = stage.draw_moment(rng, on_it)
        sign, turn = rng.choice([-1.0, 1.0]), rng.uniform(0.0, 2 * np.pi)
        order = entry["target"].get("at", {}).get("order", moment)
        if not (on_it >= order).any() or not (on_it < order).any():
            stage.refuse(
                "target.at.order",
                f"plane {target_plane.name} is not scanned both before and after pose {order}",
            )
        tilt = entry["size"] / LEVER if entry["tilt_rad"] is None else entry["tilt_rad"]
        middle, _ = stage.scanned(target_plane)
        details = {
            "along_normal_m": float(sign * entry["size"]),
            "tilt_rad": (
                tilt * (np.cos(turn) * target_plane.axes[:, 0] + np.sin(turn) * target_plane.axes[:, 1])
            ).tolist(),
            "about_m": (target_plane.centre + target_plane.axes[:, :2] @ middle).tolist(),
            "creeping_share": entry["creep"],
            "end_order": len(stage.poses) - 1,
        }
        first = int(on_it[on_it >= order][0])
        return cls({"plane": target_plane.name, "at": stage.at(first)}, entry["size"], details)

    def share(self, order: Array) -> Array:
        """Return how much of the motion has happened at each order (N,)."""
        start, end = self.target["at"]["order"], self.details["end_order"]
        creep = self.details["creeping_share"]
        crept = np.clip((order - start) / max(end - start, 1), 0.0, 1.0)
        return np.where(order >= start, 1.0 - creep + creep * crept, 0.0)

    def target_planes(
        self, target_planes: tuple[TargetPlane, ...], poses: pd.DataFrame
    ) -> list[tuple[Rows, tuple[TargetPlane, ...]]]:
        """Return the target planes before the motion, and after it or at each pose of the creep."""
        shares, which = np.unique(self.share(poses["pose"].to_numpy()), return_inverse=True)
        stretches = []
        for k, share in enumerate(shares):
            then = tuple(
                self.move(target_plane, share) if target_plane.name == self.target["plane"] else target_plane
                for target_plane in target_planes
            )
            stretches.append((np.flatnonzero(which == k), then))
        return stretches

    def move(self, target_plane: TargetPlane, share: float) -> TargetPlane:
        """Return a target plane after a share of its motion."""
        if share == 0.0:
            return target_plane
        R = rotation_from_vector(share * np.array(self.details["tilt_rad"]))
        about = np.array(self.details["about_m"])
        shift = share * self.details["along_normal_m"] * target_plane.normal
        normal, centre = R @ target_plane.normal, about + R @ (target_plane.centre - about) + shift
        mesh = target_plane.mesh and (
            about + (target_plane.mesh[0] - about) @ R.T + shift,
            target_plane.mesh[1],
        )
        return target_plane.moved(
            normal=normal,
            centre=centre,
            distance=float(normal @ centre),
            axes=R @ target_plane.axes,
            mesh=mesh,
        )
