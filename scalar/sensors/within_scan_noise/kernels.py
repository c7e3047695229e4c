"""Shapes of correlation between two points of a scan, by their distance over the correlation length.

Along the rays (the scanner: speckle, filters, neighbouring pixels that share light; a moving average makes a triangle) the distance
counts in points, along the surface (its waves and roughness) in metres. All are positive definite on a line (Rasmussen and Williams,
Gaussian Processes for Machine Learning, 2006, ch. 4; the waves are those of an isotropic random surface of one wavelength,
Longuet-Higgins, Phil. Trans. A 249, 1957, losing step after two).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import j0

from scalar.geometry.se3 import Array


@dataclass(frozen=True)
class Kernel:
    """A family of correlations.

    Attributes:
        of_surface: Whether distances are along the surface [m], else along the rays [points].
        shape: ``exponential``, ``triangular``, ``gaussian`` or ``waves``.
    """

    of_surface: bool
    shape: str

    def __call__(self, distance: Array) -> Array:
        """Return the correlation at distances over the length."""
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
    """A correlated share of the noise.

    Attributes:
        kernel: Its shape.
        length: Correlation length, or wavelength [points or m].
        share: Of the variance.
        gain: Restricted log likelihood that it gained [nats].
        length_std: Standard error of the logarithm of the length.
        share_std: Standard error of the share.
        rivals: Kernels that explain it about as well.
    """

    kernel: Kernel
    length: float
    share: float
    gain: float
    length_std: float
    share_std: float
    rivals: tuple[Kernel, ...]
