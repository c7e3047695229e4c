"""All errors that the config's `scanner` block adds to a scan, put together."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from scalar.simulation.optics.losses import gaps, glints, mixed_pixels
from scalar.simulation.optics.speckle import speckle_errors
from scalar.simulation.optics.triangulation import Linearity, growth
from scalar.simulation.scanner import Scanner
from scalar.simulation.transforms import Array

SWITCHES = ("speckle_share", "growth", "glint_share", "gap_share", "edge_share", "linearity_m")
FEWEST = 5  # points: a scanner delivers no profile with fewer


@dataclass(frozen=True, eq=False)
class Imperfections:
    """The errors of the points of all scans.

    Attributes:
        draws: (N, M) of noise, in units of its stated standard deviation.
        errors: (N, M) [m] along the error axis, the same at every repetition of a scan.
        seen: (N, M) bool, the points that are delivered.
    """

    draws: Array
    errors: Array
    seen: Array


def is_imperfect(block: Mapping[str, Any]) -> bool:
    """Return whether a complete `scanner` block switches any error on."""
    return any(block[key] for key in SWITCHES)


def imperfections(
    block: Mapping[str, Any],
    scanner: Scanner,
    ranges: Array,
    angles: Array,
    cosines: Array,
    chosen: Array,
    white: Array,
    rng_of: Callable[[int], np.random.Generator],
    own: np.random.Generator,
) -> Imperfections:
    """Return the errors of a scanner's scans.

    Args:
        block: `scanner` of a complete config.
        scanner: its geometry.
        ranges: (N, M) [m], true ranges.
        angles: (N, M) [rad], angles of the rays.
        cosines: (N, M), cosines of incidence.
        chosen: (N, M), the pixel of each point.
        white: (N, M) standard normal, the part of the noise that is independent between pixels.
        rng_of: returns the generator of a scan, given its row.
        own: the generator for errors that belong to the scanner and are the same in all scans.
    """
    if not is_imperfect(block):
        return Imperfections(white, np.zeros_like(white), np.full(white.shape, True))
    pixels, share = scanner.rays, block["speckle_share"]
    speckle, factor, error = (np.zeros((len(white), pixels)) for _ in range(3))
    seen = np.empty((len(white), pixels), bool)
    for k in range(len(white)):
        rng = rng_of(k)
        behind, before_edge = mixed_pixels(rng, pixels, block["edge_share"], block["edge_gate_m"])
        seen[k] = gaps(rng, pixels, block["gap_share"], block["gap_pixels"]) & before_edge
        factor[k] = glints(rng, pixels, block["glint_share"], block["glint_times"])
        error[k] = behind
        if share > 0:
            speckle[k] = speckle_errors(rng, pixels, block["speckle_pixels"], block["line_speckles"])

    def of_points(table: Array) -> Array:
        return np.take_along_axis(table, chosen, axis=1)

    draws = np.sqrt(1.0 - share) * white + np.sqrt(share) * of_points(speckle)
    draws = draws * of_points(factor)
    if block["growth"]:
        draws = draws * growth(scanner, ranges * np.cos(angles), cosines, block["shot_share"])
    errors = of_points(error)
    if block["linearity_m"] > 0:
        field = Linearity.drawn(block["linearity_m"], scanner, own)
        dx, dz = field.error(ranges * np.sin(angles), ranges * np.cos(angles))
        errors = errors + (dz if scanner.error_axis == "z" else dx * np.sin(angles) + dz * np.cos(angles))
    kept = of_points(seen)
    few = kept.sum(1) < min(FEWEST, kept.shape[1])
    kept[few] = True  # such a scan would be taken again, without its gaps
    return Imperfections(draws, errors, kept)
