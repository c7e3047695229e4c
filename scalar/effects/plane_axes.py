"""Coordinates in a target plane, for effects that bend or turn it."""

from __future__ import annotations

import numpy as np

from scalar.geometry.planes import Planes
from scalar.geometry.se3 import Array

_STEEP = 0.9  # |n_x|: a plane that faces the base's x axis more than this has its first axis along y


def plane_axes(planes: Planes, name: str, plane_index: Array) -> tuple[Array, Array, Array]:
    """Return which poses measure a plane, in whatever session ``(N,)``, and the plane's axes u and v ``(N, 3)`` each.

    u is the base's x axis, or y on a plane that faces x, turned into the plane: it depends on where the plane is and not on what its
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


def carried_coordinates(
    planes: Planes, name: str, plane_index: Array, T_base_sensor: Array, centre: Array
) -> tuple[Array, Array, Array]:
    """Return which poses measure a plane ``(N,)``, and u and v of a point (x, 0, z) of the sensor as linear in (1, x, z).

    Args:
        planes: Where they are.
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
    return mine, np.einsum("nkx,nx->nk", carriers, e1), np.einsum("nkx,nx->nk", carriers, e2)
