"""Planes as points of S^2 x R: ``normal . p = distance`` in the base frame, moved by two tangent coordinates and a distance.

About a reference normal n0 with tangents e1, e2 the plane's normal is ``n = (n0 + u e1 + v e2) / |n0 + u e1 + v e2|``. This needs
neither a fourth parameter nor a square root, whose slope would be infinite at an upright wall. ``(-n, -d)`` is the same plane; the sign is
that of the initial guess.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar

import numpy as np

from scalar.geometry.se3 import Array, cross
from scalar.kernels.contacts import tangents

PARAMETERS_PER_PLANE = 3
_FACES_X = 0.9
"""|n_x| above which a plane's first axis is the base's y axis, projected, instead of its x axis."""


@dataclass(frozen=True, eq=False)
class Planes:
    """K planes, parameterised about reference normals.

    Attributes:
        is_stated: Datasets state initial guesses of planes.
        names: K names; planes of several sessions are ``floor@2`` and so on.
        reference_normals: ``(K, 3)``, unit, base frame.
        tangents: ``(K, 2, 3)``, orthonormal with the reference normals.
        tangent_coordinates: ``(K, 2)``, (u, v), dimensionless: for small values the tilt [rad].
        distances: ``(K,)`` [m].
    """

    is_stated: ClassVar[bool] = True
    names: tuple[str, ...]
    reference_normals: Array
    tangents: Array
    tangent_coordinates: Array
    distances: Array

    @classmethod
    def at(cls, names: Sequence[str], normals: Array, distances: Array | Sequence[float]) -> Planes:
        """Return planes whose references are the given normals ``(K, 3)`` and distances ``(K,)`` [m]."""
        normals = np.asarray(normals, dtype=float)
        normals = normals / _lengths(normals)
        return cls(
            tuple(names),
            normals,
            tangent_basis(normals),
            np.zeros((len(normals), 2)),
            np.array(distances, dtype=float),
        )

    @cached_property
    def normals(self) -> Array:
        """Return the unit normals ``(K, 3)``; computed once and therefore read-only."""
        n = self.reference_normals + np.einsum("kt,ktx->kx", self.tangent_coordinates, self.tangents)
        n /= _lengths(n)
        n.setflags(write=False)
        return n

    @cached_property
    def axes(self) -> Array:
        """Return two orthonormal axes in each plane, ``(K, 2, 3)``.

        The first is the base's x axis, or its y axis for a plane that faces x, projected into the plane; the second is ``normal x first``.
        """
        n = self.normals
        axes = np.where(np.abs(n[:, :1]) > _FACES_X, np.eye(3)[1], np.eye(3)[0])
        u = axes - n * np.sum(axes * n, axis=1, keepdims=True)
        u /= _lengths(u)
        found = np.stack([u, cross(n, u)], axis=1)
        found.setflags(write=False)
        return found

    @property
    def normal_derivatives(self) -> Array:
        """Return ``dn/d(u, v)``, ``(K, 3, 2)``."""
        n = self.normals
        length = np.sqrt(1.0 + np.sum(self.tangent_coordinates**2, axis=1))
        along = np.einsum("kx,ktx->kt", n, self.tangents)
        return (np.swapaxes(self.tangents, 1, 2) - n[:, :, None] * along[:, None, :]) / length[:, None, None]

    def relative_to(self, normals: Array) -> tuple[Array, Array]:
        """Return the angles to other normals ``(K, 3)`` [rad], and the distances of the same planes with their normals on the side of those [m].

        ``(-n, -d)`` is the same plane as ``(n, d)``: no angle exceeds a right angle. Both are ``(K,)``.
        """
        cosines = np.sum(self.normals * normals, axis=1)
        return np.arccos(np.minimum(np.abs(cosines), 1.0)), np.where(cosines < 0, -1.0, 1.0) * self.distances

    @property
    def parameter_names(self) -> list[str]:
        """Return ``normal_<name>_u, normal_<name>_v, distance_<name>`` of every plane."""
        return [
            text
            for name in self.names
            for text in (f"normal_{name}_u", f"normal_{name}_v", f"distance_{name}")
        ]

    @property
    def parameter_units(self) -> list[str]:
        """Return the units, in the order of the names."""
        return ["rad", "rad", "m"] * len(self.names)

    @property
    def vector(self) -> Array:
        """Return the coordinates ``(3 K,)``, in the order of the names; computed once and therefore read-only."""
        return self._vector

    @cached_property
    def _vector(self) -> Array:
        table = np.empty((len(self.distances), PARAMETERS_PER_PLANE))
        table[:, :2], table[:, 2] = self.tangent_coordinates, self.distances
        table.setflags(write=False)
        return table.ravel()

    def with_vector(self, vector: Array) -> Planes:
        """Return the planes at coordinates ``(3 K,)`` about the same references."""
        table = np.asarray(vector, dtype=float).reshape(-1, PARAMETERS_PER_PLANE)
        return replace(self, tangent_coordinates=table[:, :2].copy(), distances=table[:, 2].copy())

    def rebased(self) -> Planes:
        """Return the same planes with their current normals as references."""
        return Planes.at(self.names, self.normals, self.distances)

    def expressed_about(self, guess: Planes) -> Planes:
        """Return the same planes with those of ``guess``, which has the same names, as references.

        Raises:
            ValueError: A normal is a right angle or more away from its guess.
        """
        reference = Planes.at(guess.names, guess.normals, guess.distances)
        normals = self.normals
        along = np.sum(normals * reference.reference_normals, axis=1)
        if np.any(along <= 0):
            raise ValueError("a plane's normal is a right angle or more away from its guess")
        coordinates = np.einsum("kx,ktx->kt", normals, reference.tangents) / along[:, None]
        return replace(reference, tangent_coordinates=coordinates, distances=self.distances.copy())


def _lengths(vectors: Array) -> Array:
    """Return the lengths ``(K, 1)`` of vectors ``(K, 3)``; the same numbers as ``np.linalg.norm``, which takes three times as long for a few."""
    return np.sqrt(np.add.reduce(vectors * vectors, axis=1, keepdims=True))


def tangent_basis(normals: Array) -> Array:
    """Return two unit vectors ``(K, 2, 3)`` perpendicular to each normal ``(K, 3)`` and to each other; the same for the same normal."""
    compiled = tangents(normals)
    if compiled is not None:
        return compiled
    least = np.argmin(np.abs(normals), axis=1)
    axis = np.eye(3)[least]
    first = cross(normals, axis)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return np.stack([first, cross(normals, first)], axis=1)
