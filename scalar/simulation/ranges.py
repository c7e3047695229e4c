"""How far the rays of all scans truly go: asked of the engine, and carried on to faces that are not flat."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from scalar.simulation.effects import Effects
from scalar.simulation.errors import SimulationError
from scalar.simulation.plan import Workcell
from scalar.simulation.scanner import BEYOND, cast_fan, directions
from scalar.simulation.surfaces import surfaces_of, to_surface
from scalar.simulation.transforms import Array
from scalar.simulation.world import World


def true_ranges(
    config: Mapping[str, Any],
    workcell: Workcell,
    effects: Effects,
    T_base_sensor: Array,
    angles: Array,
    plane_index: Array,
    poses: pd.DataFrame,
) -> Array:
    """Return the true ranges (N, M) [m], asked of pybullet in a world without the arm.

    That the arm does not stand in the beam was seen when the pose was chosen.
    """
    ranges = np.empty(angles.shape)
    surfaces = surfaces_of(config["surface"], workcell.target_planes, config["seed"])
    u = np.einsum("nij,nmj->nmi", T_base_sensor[:, :3, :3], directions(angles))
    length = workcell.scanner.range_far * BEYOND
    with World() as world:
        for rows, target_planes in effects.target_planes(workcell.target_planes, poses):
            world.set_target_planes(target_planes)
            hit, ranges[rows] = cast_fan(world, T_base_sensor[rows], angles[rows], length)
            wrong = (hit != np.array(world.target_plane_ids)[plane_index[rows], None]).sum(1)
            if wrong.any():
                worst = int(np.argmax(wrong))
                row = poses.iloc[rows].iloc[worst]
                raise SimulationError(
                    f"pose {row['pose']} on plane {row['plane']}: {wrong[worst]} of {angles.shape[1]} rays "
                    "left the target plane, moved by noise or effects; raise edge_margin_m"
                )
            for k, surface in enumerate(surfaces):
                mine = np.arange(len(plane_index))[rows]
                mine = mine[plane_index[mine] == k]
                starts = T_base_sensor[mine, None, :3, 3]
                ranges[mine] = to_surface(surface, target_planes[k], starts, u[mine], ranges[mine])
    return ranges
