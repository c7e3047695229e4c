"""The straight pieces of a recording's scans with the description of the workcell, and how they fit it under other readings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from scalar.geometry.planes import Planes
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import Array
from scalar.ingest.bag.labels import Labels, labels_by
from scalar.ingest.bag.placement import JointAxis, Placement, distances_from, line_factors, place

_MOST_PLACED = 100  # scans from which scanner and planes are found: a wrong description shows in any poses


@dataclass(frozen=True, eq=False)
class Pieces:
    """Straight pieces of scans, one of each stop, and the planes on which they are expected to lie.

    Attributes:
        robot: The nominal robot.
        T_flange_sensor: ``(4, 4)``, the scanner's nominal pose.
        q: ``(S, n)`` [rad, m], the recorded joint positions of the robot's joints, in the assumed order q1..qn.
        points: S arrays ``(M, 2)`` [m], x and z.
        normals, distances: ``(K, 3)`` and ``(K,)`` [m], guesses of the planes.
        plane_names: Names of the planes.
        known_factors: ``(S, 3, 3)``, the factors of the points, where they are known already; None to compute them when they are needed.
    """

    robot: Robot
    T_flange_sensor: Array
    q: Array
    points: Sequence[Array]
    normals: Array
    distances: Array
    plane_names: Sequence[str]
    known_factors: Array | None = None

    @cached_property
    def planes(self) -> Planes:
        """Return the planes as guessed."""
        return Planes.at(self.plane_names, self.normals, self.distances)

    @cached_property
    def factors(self) -> Array:
        """Return a factor R of each scan, ``(S, 3, 3)``: ``R'R`` has the mean products of the functions 1, x, z of its points."""
        return line_factors(self.points) if self.known_factors is None else self.known_factors

    @cached_property
    def frames(self) -> Array:
        """Return the flange at each scan, ``T_base_flange`` ``(S, 4, 4)``."""
        return self.robot.flange(self.q)

    @cached_property
    def placement(self) -> Placement:
        """Return where a fit has scanner and planes."""
        return self.placed()

    @cached_property
    def labels(self) -> Labels:
        """Return the plane of each piece, and its distance from the nearest plane."""
        return self.labels_at(self.placement)

    def plane_index(self) -> Array:
        """Return the index of the plane of each piece, ``(S,)``, -1 where it is not clear."""
        return self.labels.index

    def placed(self, used: Array | None = None, joint: int | None = None) -> Placement:
        """Return where a fit to some of the scans has scanner and planes.

        Args:
            used: ``(K,)`` bool, the planes on which scans may lie; None for all.
            joint: A joint, from 0, whose zero is free; None if none is.
        """
        some = np.arange(len(self.q))
        if len(some) > _MOST_PLACED:
            some = np.linspace(0, len(some) - 1, _MOST_PLACED).round().astype(int)
        axis = None
        if joint is not None:
            of_joint = self.robot.frames(self.q[some])[:, joint + 1]
            axis = JointAxis(of_joint[:, :3, 2], of_joint[:, :3, 3])
        return place(self.frames[some], self.factors[some], self.T_flange_sensor, self.planes, used, axis)

    def labels_at(self, placement: Placement) -> Labels:
        """Return the planes of all pieces with scanner and planes at a placement."""
        return labels_by(
            distances_from(self.frames @ placement.T_flange_sensor, self.factors, placement.planes)
        )

    def nearest_of(self, placement: Placement, used: Array) -> Array:
        """Return the distance of each piece from the nearest of the planes ``used`` ``(K,)`` bool at a placement, ``(S,)`` [m]."""
        away = distances_from(self.frames @ placement.T_flange_sensor, self.factors, placement.planes)
        return np.min(away[:, used], axis=1, initial=np.inf)

    def read_otherwise(
        self, q: Array | None = None, axes: Array | None = None, distances: Array | None = None
    ) -> Pieces:
        """Return the same recording under another reading.

        Args:
            q: ``(S, n)``, other joint positions; None for the recorded ones.
            axes: ``(2, 2)``, a matrix by which x and z of the scans are multiplied; None for the unit matrix.
            distances: ``(K,)`` [m], other guesses of the planes' distances; None for the stated ones.
        """
        factors = self.factors.copy()
        if axes is not None:
            factors[:, :, 1:] = factors[:, :, 1:] @ axes.T
        return replace(
            self,
            q=self.q if q is None else q,
            points=self.points if axes is None else [points @ axes.T for points in self.points],
            distances=self.distances if distances is None else distances,
            known_factors=factors,
        )
