"""The covariance of the three rows of each scan, ``V = g^2 Q' C Q``, computed without a matrix over all pairs of points.

For a scan of M points, Q ``(M, 3)`` holds orthonormal functions of the points (shift, turn, curvature), g^2 is the variance of a point in units of
its assumed variance sigma^2, and C ``(M, M)`` the correlation of the points' errors.

A kernel is evaluated on a regular grid along the scan, and each point's weights are distributed to the two nearest nodes (structured
kernel interpolation: Wilson and Nickisch, ICML 2015). On a grid the kernel's matrix is Toeplitz, so that its quadratic forms follow by
the fast Fourier transform of its circulant embedding. The cost grows with the points, not with their square.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.fft import next_fast_len

from scalar.geometry.se3 import Array
from scalar.sensors.pose_noise import PoseNoise
from scalar.sensors.within_scan_noise.correlation_shapes import Kernel, Part
from scalar.sensors.within_scan_noise.profiles import Profiles

_NODES_PER_LENGTH = 8.0  # nodes for each correlation length: interpolated correlations err by less than 0.01
_NODES_PER_WAVELENGTH = 24.0  # the same for a wavelength
_AT_ONCE = 2_000_000  # most numbers on the grids of the scans of a batch: 16 MB


def row_covariance(profiles: Profiles, variance: Array, parts: Sequence[Part], pitch: float) -> Array:
    """Return the covariance ``(N, 3, 3)`` of the rows ``Q' y`` of every scan.

    Args:
        profiles: The scans.
        variance: ``(N,)``, g^2 of each scan, dimensionless.
        parts: The correlated components; the rest of the variance is white.
        pitch: Angle between neighbouring points [rad].
    """
    Q = profiles.Q
    white = profiles.sum((Q[:, :, None] * Q[:, None, :]).reshape(len(Q), 9)).reshape(-1, 3, 3)
    C = (1.0 - sum(p.share for p in parts)) * white
    for p in parts:
        at = profiles.along if p.kernel.of_surface else profiles.angle / pitch
        C = C + p.share * quadratic_forms(profiles, at / p.length, p.kernel)
    # A scan of two points has no curvature: its third row is zero, and gets the variance g^2.
    missing = np.diagonal(white, axis1=1, axis2=2) < 0.5
    C = C + np.einsum("ni,ij->nij", missing.astype(float), np.eye(3))
    return C * variance[:, None, None]


def quadratic_forms(profiles: Profiles, at: Array, kernel: Kernel) -> Array:
    """Return ``Q' K Q`` ``(N, 3, 3)`` for a kernel K and positions ``at`` of the points ``(P,)``, in correlation lengths."""
    counts = profiles.counts
    at = at - np.repeat(np.minimum.reduceat(at, profiles.starts[:-1]), counts)
    step = 1.0 / (_NODES_PER_WAVELENGTH if kernel.shape == "waves" else _NODES_PER_LENGTH)
    nodes = int(np.ceil(at.max() / step)) + 2
    n = int(next_fast_len(2 * nodes, True) or 2 * nodes)
    lag = np.minimum(np.arange(n), n - np.arange(n))
    spectrum = np.fft.rfft(kernel(lag * step)).real
    spectrum *= np.where((np.arange(len(spectrum)) == 0) | (2 * np.arange(len(spectrum)) == n), 1.0, 2.0) / n
    low = np.minimum((at / step).astype(int), nodes - 2)
    above = at / step - low
    # Interpolation lowers each point's own variance; the difference is added back.
    lost = 2.0 * above * (1.0 - above) * (1.0 - kernel(np.array([step]))[0])
    result = profiles.sum(
        (lost[:, None, None] * profiles.Q[:, :, None] * profiles.Q[:, None, :]).reshape(-1, 9)
    ).reshape(-1, 3, 3)
    batch = max(_AT_ONCE // (3 * n), 1)
    for first in range(0, len(counts), batch):
        last = min(first + batch, len(counts))
        mine = slice(profiles.starts[first], profiles.starts[last])
        place = (profiles.scan[mine] - first) * n + low[mine]
        grid = np.stack(
            [
                np.bincount(place, q * (1.0 - above[mine]), (last - first) * n)
                + np.bincount(place + 1, q * above[mine], (last - first) * n)
                for q in profiles.Q[mine].T
            ]
        ).reshape(3, last - first, n)
        transformed = np.fft.rfft(grid)
        weighted = transformed * spectrum
        result[first:last] += np.einsum("inf,jnf->nij", weighted.real, transformed.real)
        result[first:last] += np.einsum("inf,jnf->nij", weighted.imag, transformed.imag)
    return result


def long_waves(profiles: Profiles, noise: PoseNoise | None) -> Array:
    """Return the covariance ``(N, 3, 3)`` of the rows from errors as large as the points' noise, correlated exponentially over a scan's length.

    The correlation length is the median length of all scans.

    Args:
        profiles: The scans.
        noise: The noise for which the rows are whitened, or None.
    """
    first = profiles.starts[:-1]
    extent = np.maximum.reduceat(profiles.along, first) - np.minimum.reduceat(profiles.along, first)
    length = max(float(np.median(extent)), 1e-9)
    forms = quadratic_forms(profiles, profiles.along / length, Kernel(True, "exponential"))
    return forms if noise is None else noise.whitening @ forms @ np.swapaxes(noise.whitening, 1, 2)


def inverse_factors(covariance: Array) -> Array:
    """Return the inverse lower Cholesky factors ``(N, 3, 3)``: they whiten rows, and only scale the first one, the shift."""
    return np.linalg.inv(np.linalg.cholesky(covariance))
