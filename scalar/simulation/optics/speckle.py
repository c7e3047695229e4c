"""Speckle: the random error with which the position of a laser line on a rough surface is measured.

The surface scatters with random phases, the camera's aperture removes detail that is finer than a speckle, and the
scanner takes, across the line, the centroid of the light that each pixel column collects (Dorsch, Häusler, Herrmann, "Laser
triangulation: fundamental uncertainty in distance measurement", Applied Optics 33, 1994). The field itself is
simulated: circular Gaussian scatterers under a Gaussian line, a square aperture, intensity, pixels, centroid. Speckles
that are larger than a pixel correlate the errors of neighbouring pixels; the correlation is not a parameter but follows from the field.
"""

from functools import cache

import numpy as np

from scalar.simulation.transforms import Array

SAMPLES = 4  # samples of the field along the line in a speckle or a pixel, whichever is smaller
ACROSS = 2  # samples of the field in a speckle, across the line
BLOCK = 64  # samples; transforms of multiples of it are quick
WINDOW = 2.0  # width of the camera's window across the line, in widths of the line
REFERENCE_SPECKLES = 15_000  # along the line from which the centroid's standard deviation is computed
REFERENCE_SEED = 19940301


def speckle_errors(rng: np.random.Generator, pixels: int, size: float, line: float) -> Array:
    """Return the errors of the centroid along one line, (pixels,), scaled to unit variance over many lines.

    Args:
        rng: generator of this line.
        pixels: number of pixels of the scanner along the line.
        size: of a speckle along the line, in pixels: the lag at which the field's autocorrelation has its first zero.
        line: width (1/e^2) of the laser line, in speckles.
    """
    return _centroids(rng, pixels, size, line) / _centroid_std(size, line)


@cache
def _centroid_std(size: float, line: float) -> float:
    """Return the standard deviation of the centroid, in speckles, from one long line of its own seed."""
    rng = np.random.default_rng(REFERENCE_SEED)
    return float(_centroids(rng, int(np.ceil(REFERENCE_SPECKLES * size)), size, line).std())


def _centroids(rng: np.random.Generator, pixels: int, size: float, line: float) -> Array:
    """Return the centroid across the line of each pixel column (pixels,), in speckles."""
    a_pixel = max(1, int(np.ceil(SAMPLES / size)))
    margin = int(np.ceil(2 * size)) + 1  # cut off, since the Fourier transform joins the two ends of the line
    along = BLOCK * -(-(pixels + margin) * a_pixel // BLOCK)
    across = 2 * int(np.ceil(WINDOW * line * ACROSS / 2))
    y = (np.arange(across) - (across - 1) / 2) / ACROSS
    light = np.exp(-4.0 * (y / line) ** 2)  # of the field: the intensity falls to 1/e^2 at half a width
    scattered = rng.standard_normal((across, along)) + 1j * rng.standard_normal((across, along))
    seen_along = np.abs(np.fft.fftfreq(along, 1.0 / (size * a_pixel))) <= 0.5
    seen_across = np.abs(np.fft.fftfreq(across, 1.0 / ACROSS)) <= 0.5
    spectrum = np.fft.fft2(light[:, None] * scattered) * (seen_across[:, None] & seen_along)
    intensity = np.abs(np.fft.ifft2(spectrum)) ** 2
    columns = intensity[:, : pixels * a_pixel].reshape(across, pixels, a_pixel).sum(2)
    return (y @ columns) / columns.sum(0)
