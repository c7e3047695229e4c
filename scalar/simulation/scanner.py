"""A line laser as a fan of rays, whose ranges pybullet computes.

The rays leave the sensor's origin in its XZ plane, u(phi) = (sin phi, 0, cos phi), phi from -half to +half of
the fan. Range is counted along the ray. A measured point is (x, z) = range * (sin phi, cos phi).
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from scalar.simulation.transforms import Array
from scalar.simulation.world import World

BEYOND = 1.02  # ratio of the length of the rays to the far limit, so that a surface at the limit is hit


@dataclass(frozen=True)
class Scanner:
    """The geometry of a line laser.

    Attributes:
        fan: half of the fan's opening angle [rad].
        range_near, range_far: limits of the range [m].
        incidence: largest angle [rad] between ray and surface normal.
        points: number of points delivered in a scan.
        rays: number of rays in a scan, among which the points are chosen if the config's `selection` is "random"; with
            "even" there are as many rays as points.
        error_axis: "ray" or "z", the direction in which range errors act.
    """

    fan: float
    range_near: float
    range_far: float
    incidence: float
    points: int
    rays: int
    error_axis: str

    def angles(self) -> Array:
        """Return the angle of each ray, (rays,) [rad]; a single ray points straight ahead."""
        return np.linspace(-self.fan, self.fan, self.rays) if self.rays > 1 else np.zeros(1)


def scanner_from_mapping(sensor: Mapping[str, Any], degree: float) -> Scanner:
    """Return the scanner of the config's `sensor` block; `degree` is the size of one degree in rad, by which its angles are multiplied."""
    near, far = sensor["range_m"]
    points = sensor["points_per_scan"]
    return Scanner(
        fan=sensor["fan_half_angle_deg"] * degree,
        range_near=float(near),
        range_far=float(far),
        incidence=sensor["incidence_max_deg"] * degree,
        points=points,
        rays=max(points, sensor["rays"]) if sensor["selection"] == "random" else points,
        error_axis=sensor["error_axis"],
    )


def directions(angles: Array) -> Array:
    """Return u(phi) in the sensor frame, (..., 3), for angles (...) [rad]."""
    return np.stack([np.sin(angles), np.zeros_like(angles), np.cos(angles)], -1)


def cast_fan(world: World, T_base_sensor: Array, angles: Array, length: float) -> tuple[Array, Array]:
    """Return what each ray of each scan hits (N, M) int and its range (N, M) [m], inf where it hits nothing.

    Args:
        world: with the target planes as they are during these scans.
        T_base_sensor: sensor frames in the base frame, (N, 4, 4).
        angles: angles of the rays in the fan, (N, M) or (M,) [rad].
        length: length of the rays [m].
    """
    x, z, origins = (T_base_sensor[:, None, :3, k] for k in (0, 2, 3))
    ends = np.sin(angles)[..., None] * x
    ends += np.cos(angles)[..., None] * z
    ends *= length
    ends += origins
    shape = ends.shape[:2]
    starts = [origin for origin in origins[:, 0].tolist() for _ in range(shape[1])]
    hit, fraction = world.cast(starts, ends.reshape(-1, 3))
    distance = np.where(hit >= 0, fraction * length, np.inf)
    return hit.reshape(shape), distance.reshape(shape)
