"""The problem of a contest as a binary file, which the programs of other solvers read.

Numbers follow one another without gaps, int64 and then float64, both little-endian: N poses, n joints, K planes, G free coordinates of arm and
sensor, P points; ``starts (N + 1,)``, ``plane (N,)``, ``free (G,)``; ``q (N, n)`` [rad], ``x``, ``z`` ``(P,)`` [m], ``w`` ``(P,)`` [1/m], the
start ``(5 n + 6 + 3 K,)`` [m, rad], ``T_base_0``, ``T_n_flange`` ``(4, 4)``, the reference rotation of the sensor ``(3, 3)``, the planes'
reference normals ``(K, 3)`` and tangents ``(K, 2, 3)``. Coordinates are ordered as in ``Model.vector``. This module imports NumPy alone.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np


@dataclass(frozen=True, eq=False)
class PlaneProblemFile:
    """Points on planes, seen from the poses of an arm, and where a fit of arm, sensor and planes starts; arrays as in the module's text."""

    starts: np.ndarray
    plane: np.ndarray
    free: np.ndarray
    q: np.ndarray
    x: np.ndarray
    z: np.ndarray
    w: np.ndarray
    start: np.ndarray
    T_base_0: np.ndarray
    T_n_flange: np.ndarray
    R_sensor: np.ndarray
    normals: np.ndarray
    tangents: np.ndarray

    def write(self, path: Path) -> None:
        """Write the file."""
        counts = *self.q.shape, len(self.normals), len(self.free), len(self.x)
        with path.open("wb") as file:
            for numbers in (counts, self.starts, self.plane, self.free):
                file.write(np.asarray(numbers, "<i8").tobytes())
            for numbers in (self.q, self.x, self.z, self.w, self.start):
                file.write(np.asarray(numbers, "<f8").tobytes())
            for numbers in (self.T_base_0, self.T_n_flange, self.R_sensor, self.normals, self.tangents):
                file.write(np.asarray(numbers, "<f8").tobytes())

    @classmethod
    def read(cls, path: Path) -> PlaneProblemFile:
        """Return what a file holds; ValueError if it is too short."""
        with path.open("rb") as file:
            N, n, K, G, P = (int(count) for count in _numbers(file, "<i8", 5))
            whole = [_numbers(file, "<i8", count) for count in (N + 1, N, G)]
            shapes = (
                (N, n), (P,), (P,), (P,), (5 * n + 6 + 3 * K,), (4, 4), (4, 4), (3, 3), (K, 3), (K, 2, 3),
            )  # fmt: skip
            real = [_numbers(file, "<f8", int(np.prod(shape))).reshape(shape) for shape in shapes]
        return cls(*whole, *real)


def _numbers(file: BinaryIO, kind: str, count: int) -> np.ndarray:
    data = file.read(8 * count)
    if len(data) != 8 * count:
        raise ValueError(f"the file of the problem ends {8 * count - len(data)} bytes too early")
    return np.frombuffer(data, kind)
