"""Simulated scans of planes with noise of several kinds, by formulas independent of the package, for tests of the noise within scans."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace

import numpy as np

from scalar.sensors.within_scan_noise import Profiles

SIGMA = 1e-4  # m

Noise = Callable[[np.random.Generator, np.ndarray, np.ndarray, np.ndarray], np.ndarray]
"""A function of a generator and of the angles [rad], positions along the surface [m] and ranges [m] of a scan that returns the errors along
the rays ``(n,)`` [m]."""


def white(rng, angles, along, ranges):
    """Return independent errors of standard deviation SIGMA."""
    return SIGMA * rng.standard_normal(len(angles))


def autoregressive(rho: float) -> Noise:
    """Return a noise of standard deviation SIGMA in which each point keeps rho of its neighbour's error."""

    def errors(rng, angles, along, ranges):
        e = rng.standard_normal(len(angles))
        for i in range(1, len(e)):
            e[i] = rho * e[i - 1] + np.sqrt(1.0 - rho * rho) * e[i]
        return SIGMA * e

    return errors


def waves(height: float, wavelength: float) -> Noise:
    """Return the errors from a surface with waves of one length in all directions, plus white noise of 0.7 SIGMA."""

    def errors(rng, angles, along, ranges):
        directions, phases = rng.uniform(0, 2 * np.pi, (2, 12))
        h = np.sin(2 * np.pi * along[:, None] * np.cos(directions) / wavelength + phases)
        return height * np.sqrt(2 / 12) * h.sum(1) + 0.7 * SIGMA * rng.standard_normal(len(angles))

    return errors


def growing(power: float) -> Noise:
    """Return independent errors that grow with a power of the range."""
    return lambda rng, angles, along, ranges: (
        SIGMA * (ranges / 0.25) ** power * rng.standard_normal(len(angles))
    )


def profiles_of(
    noise: Noise,
    rng: np.random.Generator,
    scans: int = 60,
    points: int | tuple[int, int] = 80,
    bow: float = 0.0,
) -> Profiles:
    """Return the profiles of scans at many ranges and tilts, alternately of two planes.

    Args:
        noise: The noise of each scan.
        rng: Generator of all random numbers.
        scans: Number of scans.
        points: Number of points of each scan, or its least and largest value.
        bow: Curvature of the planes [1/m].
    """
    low, high = points if isinstance(points, tuple) else (points, points)
    clouds, contacts, incidences = [], [], []
    for _ in range(scans):
        n = int(rng.integers(low, high + 1))
        tilt, distance = rng.uniform(-0.4, 0.4), rng.uniform(0.15, 0.4)
        # The normal of the line in the scanner's plane, towards the scanner.
        normal = np.array([np.sin(tilt), -np.cos(tilt)])
        angles = np.linspace(-0.35, 0.35, n)
        rays = np.column_stack([np.sin(angles), np.cos(angles)])
        slant = -rays @ normal
        ranges = distance / slant
        along = ranges * (rays @ np.array([normal[1], -normal[0]]))
        error = noise(rng, angles, along, ranges)
        # The scanner's plane need not be perpendicular to the target plane, so a ray meets a bow of some height earlier by more than that height.
        out_of_plane = rng.uniform(0.8, 1.0)
        ranges = ranges - bow * along**2 / (slant * out_of_plane) + error
        clouds.append(ranges[:, None] * rays)
        contacts.append(out_of_plane * np.r_[distance, normal])
        incidences.append(out_of_plane * slant)
    starts = np.r_[0, np.cumsum([len(cloud) for cloud in clouds])]
    measured = SimpleNamespace(
        points=np.concatenate(clouds),
        starts=starts,
        error_axis="ray",
        sigma=SIGMA,
        target_index=np.arange(scans) % 2,
    )
    return Profiles.of(measured, np.array(contacts), np.concatenate(incidences))  # type: ignore[arg-type]
