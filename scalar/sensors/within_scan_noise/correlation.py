"""Estimate how far along a scan its noise is correlated: the shape and length of greatest restricted likelihood, one component after another.

A sample of the scans and a thinned set of their points suffice. The search uses a part of this sample, and the final estimate all of it. Lengths
run from about a point to a share of the scan; a longer correlation cannot be distinguished from a shift or a turn of the scan.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from scipy.optimize import minimize

from scalar.geometry.se3 import Array
from scalar.sensors.noise_thresholds import NoiseThresholds
from scalar.sensors.within_scan_noise.correlation_shapes import KERNELS, Kernel, Part
from scalar.sensors.within_scan_noise.profiles import Profiles
from scalar.sensors.within_scan_noise.restricted_likelihood import ScanSample

MOST_PARTS = 2
# Largest numbers of scans, and of points of each, in the sample, whatever the size of the dataset.
MOST_SCANS, MOST_POINTS = 60, 48
_SEARCHED = 20  # approximate number of scans in the search
_RATIO = 2.5  # largest ratio of successive lengths of the grid
_SHARES = (0.25, 0.6, 0.9)  # shares of the variance that are tried on the grid
_EVALUATIONS = 24  # evaluations of the likelihood for each shape that is refined
_HOPELESS = 0.3  # a shape whose gain on the grid is smaller than the best by this share is not refined
_LOGIT = 7.0  # largest log odds of a share: 0.999 or 0.001
_STEP = 0.15  # step of the log odds of the share and of the log length, in differences for the curvature of the likelihood


def sample_of(
    profiles: Profiles, height: Array, level: Array, use: Array, pitch: float
) -> tuple[ScanSample, Array]:
    """Return a sample of the scans, each in units of its noise level, and the indices of these scans ``(S,)``.

    Args:
        profiles: The scans.
        height: ``(P,)``, heights about the scans' own lines.
        level: ``(N,)``, each scan's standard deviation.
        use: ``(N,)`` bool, the scans from which the sample is taken.
        pitch: Angle between neighbouring points [rad].
    """
    counts = profiles.counts
    m = int(min(MOST_POINTS, np.quantile(counts[use], 0.1, method="lower")))
    pick = np.flatnonzero(use & (counts >= m))
    pick = pick[np.unique(np.linspace(0, len(pick) - 1, min(len(pick), MOST_SCANS)).astype(int))]
    rows = np.stack([profiles.starts[s] + _thinned(int(counts[s]), m) for s in pick])
    y = height[rows] / level[pick][:, None]
    line = np.swapaxes(profiles.Q[rows, :2], 1, 2)
    bordering = np.concatenate([line, y[:, None, :]], axis=1)
    return ScanSample(bordering, profiles.angle[rows] / pitch, profiles.along[rows]), pick


def _thinned(n: int, m: int) -> Array:
    """Return indices ``(m,)`` of m of n points: half are neighbours in the middle, for short lengths, the others are spread out, for long ones."""
    if n <= m:
        return np.arange(n)
    inner = np.arange(m // 2) + (n - m // 2) // 2
    outer = np.setdiff1d(np.arange(n), inner)
    spread = outer[np.linspace(0, len(outer) - 1, m - len(inner)).astype(int)]
    return np.sort(np.concatenate([inner, spread]))


def correlated_parts(sample: ScanSample, settings: NoiseThresholds) -> tuple[Part, ...]:
    """Return the components of the correlation in the order in which they were found; none if none gains enough likelihood."""
    few = sample.some(max(len(sample.pixel) // _SEARCHED, 1))
    parts: tuple[Part, ...] = ()
    for _ in range(MOST_PARTS):
        part = _best(sample, few, parts, settings)
        if part is None:
            break
        parts = (*(replace(p, share=p.share * (1.0 - part.share)) for p in parts), part)
    return parts


def lengths(kernel: Kernel, sample: ScanSample, longest_share: float) -> Array:
    """Return the lengths of the grid ``(L,)``, from about the distance of two points to a share of the scan [points, or m on the surface].

    Args:
        kernel: The shape of the correlation, which decides the shortest length.
        sample: The scans.
        longest_share: The longest length, over the extent of a scan.
    """
    at = sample.surface if kernel.of_surface else sample.pixel
    extent = float(np.median(np.ptp(at, axis=1)))
    closest = float(np.median(np.abs(np.diff(at, axis=1))[:, at.shape[1] // 4 : -(at.shape[1] // 4)]))
    longest = longest_share * extent * (2.0 if kernel.shape == "waves" else 1.0)
    shortest = min(
        closest * {"exponential": 0.7, "triangular": 1.5, "gaussian": 1.0, "waves": 4.0}[kernel.shape],
        longest,
    )
    n = max(int(np.ceil(np.log(longest / shortest) / np.log(_RATIO))) + 1, 2)
    return np.geomspace(shortest, longest, n)


def _best(
    sample: ScanSample, few: ScanSample, parts: tuple[Part, ...], settings: NoiseThresholds
) -> Part | None:
    """Return the component that gains most likelihood in addition to those found so far; None if it does not gain enough.

    Args:
        sample: The scans on which the component is judged.
        few: A part of them, on which it is searched for.
        parts: The components found so far.
        settings: Thresholds.
    """
    search = _Search(few, parts)
    allowed = {kernel: lengths(kernel, few, settings.longest_share) for kernel in KERNELS}
    tried = [search.coarse(kernel, allowed[kernel]) for kernel in KERNELS]
    scale = len(sample.pixel) / len(few.pixel)
    leading = max(part.gain for part in tried)
    if scale * leading < 0.5 * settings.least_gain:
        return None
    hopeful = [part for part in tried if part.gain > (1.0 - _HOPELESS) * leading]
    refined = [search.refined(part, allowed[part.kernel]) for part in hopeful]
    leading = max(part.gain for part in refined)
    whole = _Search(sample, parts)
    close = [part for part in refined if part.gain > leading - settings.confounded_likelihood]
    ended = [whole.refined(part, allowed[part.kernel]) for part in close]
    part = max(ended, key=lambda p: p.gain)
    if part.gain < settings.least_gain:
        return None
    rivals = tuple(
        p.kernel for p in ended if p is not part and p.gain > part.gain - settings.confounded_likelihood
    )
    return whole.with_errors(replace(part, rivals=rivals))


class _Search:
    """The likelihood of one more component on a sample."""

    def __init__(self, sample: ScanSample, parts: tuple[Part, ...]) -> None:
        """Compute the likelihood with the components found so far."""
        self.sample = sample
        self.so_far = sample.correlation(parts)
        self.without = sample.log_likelihood(self.so_far)

    def gain(self, kernel: Kernel, share: float, length: float) -> float:
        """Return the gain in log likelihood by a component [nats]."""
        correlation = (1.0 - share) * self.so_far + share * self.sample.kernel(kernel, length)
        return self.sample.log_likelihood(correlation) - self.without

    def coarse(self, kernel: Kernel, tried: Array) -> Part:
        """Return the best component of a grid of shares and lengths."""
        found = []
        for length in tried:
            K = self.sample.kernel(kernel, float(length))
            found += [
                (self.sample.log_likelihood((1.0 - a) * self.so_far + a * K), a, float(length))
                for a in _SHARES
            ]
        best, share, length = max(found)
        return Part(kernel, length, share, best - self.without, np.inf, np.inf, ())

    def refined(self, part: Part, allowed: Array) -> Part:
        """Return a component at its best share and length (Nelder and Mead, Computer Journal 7, 1965)."""
        low, high = np.r_[-_LOGIT, np.log(allowed[0])], np.r_[_LOGIT, np.log(allowed[-1])]

        def at(x: Array) -> tuple[float, float]:
            x = np.clip(x, low, high)
            return float(1.0 / (1.0 + np.exp(-x[0]))), float(np.exp(x[1]))

        start = np.array([np.log(part.share / (1.0 - part.share)), np.log(part.length)])
        first_step = np.array([0.6, 0.4 if part.length < allowed[-1] else -0.4])
        simplex = np.vstack([start, start + np.diag(first_step)])
        result: Any = minimize(
            lambda x: -self.gain(part.kernel, *at(x)),
            start,
            method="Nelder-Mead",
            options={"maxfev": _EVALUATIONS, "xatol": 0.03, "fatol": 0.2, "initial_simplex": simplex},
        )
        share, length = at(result.x)
        return replace(part, length=length, share=share, gain=-float(result.fun))

    def with_errors(self, part: Part) -> Part:
        """Return a component with the standard errors that the curvature of the likelihood gives."""
        x = np.array([np.log(part.share / (1.0 - part.share)), np.log(part.length)])

        def gain(a: float, b: float) -> float:
            share = 1.0 / (1.0 + np.exp(-(x[0] + _STEP * a)))
            return self.gain(part.kernel, float(share), float(np.exp(x[1] + _STEP * b)))

        middle = gain(0, 0)
        up, down, longer, shorter = gain(1, 0), gain(-1, 0), gain(0, 1), gain(0, -1)
        mixed = (gain(1, 1) - gain(1, -1) - gain(-1, 1) + gain(-1, -1)) / 4.0
        H = -np.array([[up + down - 2 * middle, mixed], [mixed, longer + shorter - 2 * middle]]) / _STEP**2
        if np.linalg.eigvalsh(H)[0] <= 0:  # the optimum is at a bound
            return part
        std = np.sqrt(np.diag(np.linalg.inv(H)))
        return replace(
            part, share_std=float(std[0]) * part.share * (1.0 - part.share), length_std=float(std[1])
        )
