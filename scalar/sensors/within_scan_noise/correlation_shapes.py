"""Shapes of the correlation between the errors of two points of a scan, as functions of their distance in correlation lengths.

Errors of the scanner (speckle, filters, neighbouring pixels that share light; a moving average gives a triangle) are correlated along the
rays, with distances in points; errors of the surface (waves and roughness) along the surface, with distances in metres. All shapes are
positive definite on a line (Rasmussen and Williams, Gaussian Processes for Machine Learning, 2006, ch. 4; the waves are those of an
isotropic random surface of one wavelength, Longuet-Higgins, Phil. Trans. A 249, 1957, damped over about two wavelengths).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import j0

from scalar.geometry.se3 import Array


@dataclass(frozen=True)
class Kernel:
    """A shape of correlation.

    Attributes:
        of_surface: Whether distances are along the surface [m]; else they are along the rays [points].
        shape: ``exponential``, ``triangular``, ``gaussian`` or ``waves``.
    """

    of_surface: bool
    shape: str

    def __call__(self, distance: Array) -> Array:
        """Return the correlation at distances in correlation lengths, for ``waves`` in wavelengths."""
        if self.shape == "exponential":
            return np.exp(-np.abs(distance))
        if self.shape == "triangular":
            return np.maximum(1.0 - np.abs(distance), 0.0)
        if self.shape == "gaussian":
            return np.exp(-0.5 * distance * distance)
        return j0(2.0 * np.pi * distance) * np.exp(-0.125 * distance * distance)


KERNELS = (
    Kernel(False, "exponential"),
    Kernel(False, "triangular"),
    Kernel(False, "gaussian"),
    Kernel(True, "exponential"),
    Kernel(True, "gaussian"),
    Kernel(True, "waves"),
)


@dataclass(frozen=True)
class Part:
    """A correlated component of the noise.

    Attributes:
        kernel: Its shape.
        length: Correlation length, or wavelength [points or m].
        share: Its share of the variance.
        gain: Gain in restricted log likelihood by this component [nats].
        length_std: Standard error of the logarithm of the length.
        share_std: Standard error of the share.
        rivals: Other shapes that explain the data about as well.
    """

    kernel: Kernel
    length: float
    share: float
    gain: float
    length_std: float
    share_std: float
    rivals: tuple[Kernel, ...]
