"""The order in which the poses of a scene are measured, and random draws for each of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from scalar.simulation.streams import ORDER, stream
from scalar.simulation.transforms import Array


@dataclass(frozen=True, eq=False)
class Acquisition:
    """Which pose is measured when, and draws that belong to the pose and not to its place in the order.

    Attributes:
        seed: the seed of the scene.
        wanted: number of poses of each plane.
        order: (N,), for each pose in acquisition order its index in the list of poses plane by plane.
    """

    seed: int
    wanted: Sequence[int]
    order: Array

    @classmethod
    def of(cls, config: Mapping[str, Any], wanted: Sequence[int]) -> Acquisition:
        """Return the acquisition of a complete config's poses.

        A random order sorts by a number drawn for each pose, so that poses keep their relative order if more are planned.
        """
        seed = config["seed"]
        if config["order"] == "by_plane":
            return cls(seed, wanted, np.arange(sum(wanted)))
        keys = [stream(seed, ORDER, k).random(count) for k, count in enumerate(wanted)]
        return cls(seed, wanted, np.argsort(np.concatenate(keys), kind="stable"))

    @property
    def plane_index(self) -> Array:
        """Return (N,), the index of the plane that each pose scans."""
        return np.repeat(np.arange(len(self.wanted)), self.wanted)[self.order]

    def sorted(self, by_plane: Sequence[Array]) -> Array:
        """Return (N, ...), the rows of one array for each plane, of which a plane's first ones are wanted."""
        return np.concatenate([rows[:k] for rows, k in zip(by_plane, self.wanted, strict=True)])[self.order]

    def draws(self, use: int, *shape: int, uniform: bool = False) -> Array:
        """Return draws (N, *shape), standard normal or uniform; those of a plane's first poses do not depend on how many poses it has."""
        parts = []
        for k, count in enumerate(self.wanted):
            rng = stream(self.seed, use, k)
            parts.append(rng.random((count, *shape)) if uniform else rng.standard_normal((count, *shape)))
        return np.concatenate(parts)[self.order]

    def rng_of(self, use: int, row: int) -> np.random.Generator:
        """Return the generator of one purpose for the pose in one row."""
        ends, listed = np.cumsum(self.wanted), int(self.order[row])
        plane = int(np.searchsorted(ends, listed, side="right"))
        return stream(self.seed, use, plane, listed - int(ends[plane] - self.wanted[plane]))
