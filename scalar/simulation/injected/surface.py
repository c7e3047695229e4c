"""Plates: one that is bent, as a mesh that rays hit, and one that is knocked or creeps."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np
import pandas as pd

from scalar.simulation.effects import Rows
from scalar.simulation.injected.base import PlantedEffect
from scalar.simulation.injected.stage import Stage
from scalar.simulation.plates import Plate
from scalar.simulation.transforms import Array, rotation_from_vector

FACET_ERROR = 2.5e-7  # m; by how much a facet may leave the curved face
FACETS_MAX = 240  # along a side
FACETS_MIN = 8
ARM_OF_TURN = 1.0  # m; a knock of a millimetre turns by a milliradian as well


def draw_plate(entry: Mapping[str, Any], stage: Stage, rng: np.random.Generator) -> Plate:
    """Return the plate that the entry names, or one that is drawn."""
    k = int(rng.integers(len(stage.cell.plates)))
    names = [plate.name for plate in stage.cell.plates]
    return stage.cell.plates[names.index(entry["target"].get("plane", names[k]))]


@dataclass(frozen=True, eq=False)
class PlaneBow(PlantedEffect):
    """The face stands h = c_1 s^2 + c_2 t^2 out of its plane, s and t along turned axes from the middle of what is scanned.

    |c_1| makes h the size at the farthest scan; c_2 = ratio c_1.
    """

    name: ClassVar[str] = "plane_bow"
    unit: ClassVar[str] = "m"

    @classmethod
    def plant(cls, entry: Mapping[str, Any], stage: Stage, rng: np.random.Generator) -> Self:
        """Draw the plate, whether it bulges or is hollow, along what axis, and the ratio of curvatures."""
        plate = draw_plate(entry, stage, rng)
        sign, turn, ratio = rng.choice([-1.0, 1.0]), rng.uniform(0.0, np.pi), rng.random()
        ratio = ratio if entry["ratio"] is None else entry["ratio"]
        middle, radius = stage.scanned(plate)
        strongest = sign * entry["size"] / radius**2
        details = {
            "curvatures_per_m": [float(strongest), float(ratio * strongest)],
            "axis_turned_rad": turn,
            "middle_uv_m": middle.tolist(),
            "scanned_radius_m": radius,
        }
        return cls({"plane": plate.name}, entry["size"], details)

    def height(self, uv: Array) -> Array:
        """Return how far the face stands out of its plane (...) [m] at uv (..., 2) [m] from the plate's centre."""
        turn = self.details["axis_turned_rad"]
        s, t = np.moveaxis(uv - self.details["middle_uv_m"], -1, 0)
        s, t = np.cos(turn) * s + np.sin(turn) * t, np.cos(turn) * t - np.sin(turn) * s
        first, second = self.details["curvatures_per_m"]
        return first * s**2 + second * t**2

    def plates(self, plates: tuple[Plate, ...], poses: pd.DataFrame) -> list[tuple[Rows, tuple[Plate, ...]]]:
        """Return the plates, one of them bent."""
        bent = tuple(self.bend(plate) if plate.name == self.target["plane"] else plate for plate in plates)
        return [(slice(None), bent)]

    def bend(self, plate: Plate) -> Plate:
        """Return a plate with a mesh in the place of its flat face."""
        sharpest = np.abs(self.details["curvatures_per_m"]).max()
        # A chord of length L leaves a parabola c s^2 by c L^2 / 4.
        side = np.sqrt(4.0 * FACET_ERROR / max(sharpest, 1e-12)) / np.sqrt(2.0)
        return faceted(plate, side, self.height)


def faceted(plate: Plate, side: float, height: Any) -> Plate:
    """Return a plate whose face is a mesh of triangles with legs of about `side` [m], raised by `height`(uv) [m].

    Heights are added to those of a mesh that the plate has already.
    """
    counts = np.clip(np.ceil(plate.size / side), FACETS_MIN, FACETS_MAX).astype(int)
    grids = [np.linspace(-0.5, 0.5, count + 1) * size for count, size in zip(counts, plate.size, strict=True)]
    uv = np.stack(np.meshgrid(*grids, indexing="ij"), -1).reshape(-1, 2)
    rise = height(uv)
    vertices = plate.centre + uv @ plate.axes[:, :2].T + rise[:, None] * plate.axes[:, 2]
    corner = (np.arange(counts[0])[:, None] * (counts[1] + 1) + np.arange(counts[1])).ravel()
    across, along = corner + counts[1] + 1, corner + 1
    triangles = np.concatenate(
        [np.column_stack([corner, across, across + 1]), np.column_stack([corner, across + 1, along])]
    )
    return plate.moved(mesh=(vertices, triangles))


@dataclass(frozen=True, eq=False)
class PlaneMoved(PlantedEffect):
    """From a moment on a plate stands size metres along its normal elsewhere, and is tilted, at once or creeping."""

    name: ClassVar[str] = "plane_moved"
    unit: ClassVar[str] = "m"

    @classmethod
    def plant(cls, entry: Mapping[str, Any], stage: Stage, rng: np.random.Generator) -> Self:
        """Draw the plate, the moment among its own poses, the side and the axis of the tilt."""
        plate = draw_plate(entry, stage, rng)
        mine = np.flatnonzero(stage.plane_index == stage.cell.plates.index(plate))
        moment = stage.draw_moment(rng, mine)
        sign, turn = rng.choice([-1.0, 1.0]), rng.uniform(0.0, 2 * np.pi)
        order = entry["target"].get("at", {}).get("order", moment)
        if not (mine >= order).any() or not (mine < order).any():
            stage.refuse(
                "target.at.order", f"plane {plate.name} is not scanned both before and after {order}"
            )
        tilt = entry["size"] / ARM_OF_TURN if entry["tilt_rad"] is None else entry["tilt_rad"]
        middle, _ = stage.scanned(plate)
        details = {
            "along_normal_m": float(sign * entry["size"]),
            "tilt_rad": (tilt * (np.cos(turn) * plate.axes[:, 0] + np.sin(turn) * plate.axes[:, 1])).tolist(),
            "about_m": (plate.centre + plate.axes[:, :2] @ middle).tolist(),
            "creeping_share": entry["creep"],
            "end_order": len(stage.poses) - 1,
        }
        first = int(mine[mine >= order][0])
        return cls({"plane": plate.name, "at": stage.at(first)}, entry["size"], details)

    def share(self, order: Array) -> Array:
        """Return how much of the motion has happened at each order (N,)."""
        start, end = self.target["at"]["order"], self.details["end_order"]
        creep = self.details["creeping_share"]
        crept = np.clip((order - start) / max(end - start, 1), 0.0, 1.0)
        return np.where(order >= start, 1.0 - creep + creep * crept, 0.0)

    def plates(self, plates: tuple[Plate, ...], poses: pd.DataFrame) -> list[tuple[Rows, tuple[Plate, ...]]]:
        """Return the plates before, and after or at each pose of the creep."""
        shares, which = np.unique(self.share(poses["pose"].to_numpy()), return_inverse=True)
        stretches = []
        for k, share in enumerate(shares):
            then = tuple(
                self.move(plate, share) if plate.name == self.target["plane"] else plate for plate in plates
            )
            stretches.append((np.flatnonzero(which == k), then))
        return stretches

    def move(self, plate: Plate, share: float) -> Plate:
        """Return a plate after a share of its motion."""
        if share == 0.0:
            return plate
        R = rotation_from_vector(share * np.array(self.details["tilt_rad"]))
        about = np.array(self.details["about_m"])
        shift = share * self.details["along_normal_m"] * plate.normal
        normal, centre = R @ plate.normal, about + R @ (plate.centre - about) + shift
        mesh = plate.mesh and (about + (plate.mesh[0] - about) @ R.T + shift, plate.mesh[1])
        return plate.moved(
            normal=normal,
            centre=centre,
            distance=float(normal @ centre),
            axes=R @ plate.axes,
            mesh=mesh,
        )
