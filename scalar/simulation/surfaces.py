"""Faces that are not flat: waves that are fixed to the surface, and a target plane that bends under a load.

Waves are left by milling and rolling: cosines of several lengths and directions, each with a phase of its own, fixed to the target plane's
axes, so that a second scan of a place finds the same height. A bent target plane has the shape of the first mode of a plate that is
supported along its edges (Navier), sin(pi u / a) sin(pi v / b) with u, v from a corner. Heights are micrometres to tenths of a millimetre,
and rays meet the face at less than 80 degrees from its normal, so the point where a ray meets the face is found by iterating from the flat
face.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from scalar.simulation.streams import SURFACE, stream
from scalar.simulation.target_planes import TargetPlane
from scalar.simulation.transforms import Array

ROUNDS = 4  # rounds of the iteration; each reduces the error by a factor of slope times tan(incidence), 0.1 at most


@dataclass(frozen=True, eq=False)
class Surface:
    """The height of one target plane's face over the ideal plane.

    Attributes:
        waves: (K, 2) wave vectors [rad/m] along the target plane's u and v.
        phases: (K,) [rad].
        amplitudes: (K,) [m].
        bow: height in the middle [m], its sign drawn.
        size: (2,) of the target plane [m].
    """

    waves: Array
    phases: Array
    amplitudes: Array
    bow: float
    size: Array

    def height(self, uv: Array) -> Array:
        """Return heights (...) [m] at uv (..., 2) [m] from the target plane's centre."""
        waves = np.zeros(uv.shape[:-1])
        for k, phase, amplitude in zip(self.waves, self.phases, self.amplitudes, strict=True):
            waves += amplitude * np.cos(uv @ k + phase)
        return waves + self.bow * np.cos(np.pi * uv / self.size).prod(-1)


def is_flat(block: Mapping[str, Any]) -> bool:
    """Return whether a complete `surface` block leaves the target planes flat."""
    return block["waves_m"] == 0 and block["bow_m"] == 0


def surfaces_of(block: Mapping[str, Any], target_planes: Sequence[TargetPlane], seed: int) -> list[Surface]:
    """Return the surface of each target plane of the config's `surface` block; none where all are flat."""
    return (
        []
        if is_flat(block)
        else [_drawn(block, plane, stream(seed, SURFACE, k)) for k, plane in enumerate(target_planes)]
    )


def _drawn(block: Mapping[str, Any], target_plane: TargetPlane, rng: np.random.Generator) -> Surface:
    count = block["waves"]
    short, long = block["wavelengths_m"]
    lengths = np.exp(rng.uniform(np.log(short), np.log(long), count))
    turns, phases = rng.uniform(0.0, np.pi, count), rng.uniform(0.0, 2 * np.pi, count)
    shares = rng.dirichlet(np.full(count, 2.0))
    sign = rng.choice([-1.0, 1.0])
    waves = (2 * np.pi / lengths)[:, None] * np.column_stack([np.cos(turns), np.sin(turns)])
    return Surface(
        waves, phases, block["waves_m"] * np.sqrt(shares), sign * block["bow_m"], target_plane.size
    )


def to_surface(
    surface: Surface, target_plane: TargetPlane, starts: Array, directions: Array, ranges: Array
) -> Array:
    """Return the ranges (..., M) [m] at which rays meet a face, from their ranges to the target plane without this surface.

    Args:
        starts: (..., 1, 3) [m], base frame.
        directions: (..., M, 3) unit, base frame.
        ranges: (..., M) [m] to the flat target plane, or to its mesh.
        target_plane: as it is during these scans.
    """
    toward = -directions @ target_plane.axes[:, 2]
    reached = ranges
    for _ in range(ROUNDS):
        spots = starts + reached[..., None] * directions
        reached = ranges - surface.height((spots - target_plane.centre) @ target_plane.axes[:, :2]) / toward
    return reached
