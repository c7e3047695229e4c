"""Scans cut into a few pieces each, whose heights show whether a plane is bent or only turned."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from scalar.geometry.planes import Planes
from scalar.geometry.se3 import Array
from scalar.sensors.profile import contact_vectors, point_basis
from scalar.sensors.rows import Pieces
from scalar.sensors.scans import Scans

PIECES = 4  # into which each scan is cut; the points of a piece are averaged


def cut_in_pieces(
    scans: Scans, T: Array, planes: Planes, point_effects: Sequence[Any], effect: Any
) -> Pieces:
    """Return the pieces of all scans, with the mean of the points of each.

    Args:
        scans: What was measured.
        T: ``(N, 4, 4)``, poses of the sensor in the base frame.
        planes: The planes of the model.
        point_effects: All effects on points and surfaces, bound to the poses.
        effect: The effect whose share of the heights is returned too, bound to the poses.
    """
    index = scans.target_index
    points, starts, axis = scans.points, scans.starts, scans.error_axis
    counts = np.diff(starts)
    scan = np.repeat(np.arange(len(counts)), counts)
    c = contact_vectors(T, planes, index)
    flat = np.sum(point_basis(("1", "x", "z"), points, axis) * c[scan], axis=1)

    def added(other: Any) -> Array:
        G = other.contact_columns(T, planes, index, c) @ other.coefficients
        return np.sum(point_basis(other.basis_names, points, axis) * G[scan], axis=1)

    height = flat + sum((added(e) for e in point_effects), np.zeros(len(flat)))
    ux, uz = point_basis(("ux", "uz"), points, axis).T
    incidence = c[scan, 1] * ux + c[scan, 2] * uz
    reach = np.hypot(points[:, 0], points[:, 1]) if axis == "ray" else points[:, 1]
    position = T[scan, :3, 3] + T[scan, :3, 0] * points[:, :1] + T[scan, :3, 2] * points[:, 1:]
    rank = np.arange(len(points)) - starts[scan]
    group = scan * PIECES + rank * PIECES // np.maximum(counts[scan], 1)
    found, where, size = np.unique(group, return_inverse=True, return_counts=True)

    def mean(values: Array) -> Array:
        return np.bincount(where, values, len(found)) / size

    std = scans.sigma * np.abs(mean(incidence)) / np.sqrt(size)
    place = np.stack([mean(position[:, i]) for i in range(3)], axis=1)
    profile = np.stack([mean(points[:, i]) for i in range(2)], axis=1)
    return Pieces(
        found // PIECES, mean(reach), place, mean(height), mean(added(effect)), mean(incidence), std, profile
    )
