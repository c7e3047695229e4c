"""Coordinates in a target plane, for effects that bend or turn it."""

from __future__ import annotations

import numpy as np

from scalar.geometry.planes import Planes
from scalar.geometry.se3 import Array


def plane_axes(planes: Planes, name: str, plane_index: Array) -> tuple[Array, Array, Array]:
    """Return which poses measure a plane, in any session, ``(N,)`` bool, and the plane's axes u and v ``(N, 3)`` each, base frame.

    The axes depend on the plane alone, and not on the reference normal of its parameters, so that coefficients mean the same in a fit and
    in a file.
    """
    mine = [k for k, other in enumerate(planes.names) if other.split("@")[0] == name or other == name]
    if not mine:
        raise ValueError(f"no plane '{name}'; there are {', '.join(planes.names)}")
    measured = np.zeros(len(planes.names), dtype=bool)
    measured[mine] = True
    axes = planes.axes[plane_index]
    return measured[plane_index], axes[:, 0], axes[:, 1]


def coordinates_by_sensor_axes(
    planes: Planes, name: str, plane_index: Array, T_base_sensor: Array, centre: Array
) -> tuple[Array, Array, Array]:
    """Return which poses measure a plane ``(N,)``, and the coefficients of (1, x, z) that give the plane coordinates u and v of a point
    (x, 0, z) of the sensor's frame.

    Args:
        planes: All target planes.
        name: Of the plane.
        plane_index: ``(N,)``, which plane each pose measures.
        T_base_sensor: ``(N, 4, 4)``.
        centre: ``(3,)`` [m], base frame: where u and v are zero.

    Returns:
        ``(N,)`` bool; ``(N, 3)`` each: the coordinates of the sensor's origin [m], and of its x and z axes.
    """
    mine, e1, e2 = plane_axes(planes, name, plane_index)
    offset = T_base_sensor[:, :3, 3] - centre
    carriers = np.stack([offset, T_base_sensor[:, :3, 0], T_base_sensor[:, :3, 2]], axis=1)
    found = carriers @ np.stack([e1, e2], axis=2)
    return mine, found[:, :, 0], found[:, :, 1]
