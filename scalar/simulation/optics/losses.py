"""Pixels that measure two surfaces at once, nothing, or a glint: mixed pixels at an edge, gaps, glints.

A spot that lies across an edge of the target plane returns light from the plane and from the background; the centroid lies between the two,
according to the shares of the spot. Pixels that are read farther behind the plane than `gate` are removed, as a user would remove them; pixels at
the beginning of that flank remain.
"""

import numpy as np
from scipy.special import ndtr

from scalar.simulation.transforms import Array

EDGE_AT = (0.06, 0.3)  # share of the pixels that an edge cuts off, from either end
GAP = (0.02, 0.3)  # m: how far behind the plane the background lies
SPOT_PIXELS = (0.6, 2.0)  # half the width of a spot, one standard deviation


def mixed_pixels(rng: np.random.Generator, pixels: int, share: float, gate: float) -> tuple[Array, Array]:
    """Return how much too far the pixels of one scan are read (pixels,) [m], and which are kept (pixels,) bool.

    Args:
        share: share of the scans that cross an edge.
        gate: pixels that are read farther behind than this [m] are cut off.
    """
    crosses = rng.random() < share
    at, gap, spot = rng.uniform(*EDGE_AT), rng.uniform(*GAP), rng.uniform(*SPOT_PIXELS)
    from_left = rng.random() < 0.5
    if not crosses:
        return np.zeros(pixels), np.full(pixels, True)
    place = np.arange(pixels) if from_left else np.arange(pixels)[::-1]
    beyond = ndtr((at * pixels - place) / spot)  # share of the spot that falls behind
    error = gap * beyond
    return error, error <= gate


def gaps(rng: np.random.Generator, pixels: int, share: float, run: float) -> Array:
    """Return which pixels of one scan are delivered (pixels,) bool: gaps of geometric length, on average `run` pixels.

    Args:
        share: share of all pixels that are lost.
        run: average length of a gap [pixels].
    """
    if share == 0.0:
        return np.full(pixels, True)
    lost = np.full(pixels, False)
    begins = np.flatnonzero(rng.random(pixels) < share / run)
    for start, length in zip(begins, rng.geometric(1.0 / run, len(begins)), strict=True):
        lost[start : start + length] = True
    return ~lost


def glints(rng: np.random.Generator, pixels: int, share: float, times: float) -> Array:
    """Return the factor of the noise of each pixel (pixels,): 1, or 1 + `times` E at a glint, where E is drawn from Exp(1).

    Args:
        rng: draws which pixels are glints, and E for each.
        pixels: number of pixels.
        share: probability that a pixel is a glint.
        times: mean of what a glint adds to the factor.
    """
    hit = rng.random(pixels) < share
    return 1.0 + times * np.where(hit, rng.exponential(size=pixels), 0.0)
