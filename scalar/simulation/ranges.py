"""True ranges of the rays of all scans, by the physics engine, corrected for the waves and the bow of the target planes' faces."""

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
    """Return the true ranges (N, M) [m] along M rays of each of N scans, by pybullet in a world without the arm.

    When a pose was chosen, a test made sure that the arm is not in the beam.

    Args:
        config: config of the scene, complete.
        workcell: the target planes and the scanner.
        effects: the injected effects.
        T_base_sensor: (N, 4, 4), true sensor frames in the base frame.
        angles: (N, M) [rad], angles of the rays in the fan.
        plane_index: (N,), index of the target plane that each pose scans.
        poses: the table of poses, with a row for each scan.

    Raises:
        SimulationError: a ray misses its target plane.
    """
    ranges = np.empty(angles.shape)
    surfaces = surfaces_of(config["surface"], workcell.target_planes, config["seed"])
    u = np.einsum("nij,nmj->nmi", T_base_sensor[:, :3, :3], directions(angles))
    length = workcell.scanner.range_far * BEYOND
    with World() as world:
        for rows, target_planes in effects.target_planes(workcell.target_planes, poses):
            world.set_target_planes(target_planes)
            hit, ranges[rows] = cast_fan(world, T_base_sensor[rows], angles[rows], length)
            missed = (hit != np.array(world.target_plane_ids)[plane_index[rows], None]).sum(1)
            if missed.any():
                worst = int(np.argmax(missed))
                row = poses.iloc[rows].iloc[worst]
                raise SimulationError(
                    f"pose {row['pose']} on plane {row['plane']}: {missed[worst]} of {angles.shape[1]} rays "
                    "left the target plane, because noise or an effect moved it or the sensor; raise edge_margin_m"
                )
            for k, surface in enumerate(surfaces):
                scans = np.arange(len(plane_index))[rows]
                scans = scans[plane_index[scans] == k]
                starts = T_base_sensor[scans, None, :3, 3]
                ranges[scans] = to_surface(surface, target_planes[k], starts, u[scans], ranges[scans])
    return ranges
