"""Estimate the noise within scans from their profiles: whether it is white and equally large in all of them, and if not, its covariance."""

from __future__ import annotations

import numpy as np

from scalar.sensors.noise_thresholds import NoiseThresholds
from scalar.sensors.pose_noise import Autocorrelation, PoseNoise
from scalar.sensors.within_scan_noise.components import components
from scalar.sensors.within_scan_noise.correlation import correlated_parts, sample_of
from scalar.sensors.within_scan_noise.correlation_shapes import Part
from scalar.sensors.within_scan_noise.level import Level
from scalar.sensors.within_scan_noise.profiles import Profiles
from scalar.sensors.within_scan_noise.row_covariance import inverse_factors, row_covariance
from scalar.sensors.within_scan_noise.whiteness import whiteness

_NOISE_FREE = 1e-6  # times sigma^2: a smaller variance is rounding of the coordinates


def noise_within_scans(
    profiles: Profiles, sigma: float, sigma_stated: bool, settings: NoiseThresholds
) -> PoseNoise | None:
    """Return the noise within scans, or None if it is white and equally large in all scans, or if there are too few points to judge.

    Args:
        profiles: The scans, in units of sigma.
        sigma: Standard deviation of a point [m].
        sigma_stated: Whether the dataset states sigma, in which case it is tested; else it was estimated from the same scans.
        settings: Thresholds.
    """
    counts = profiles.counts
    trusted = counts >= settings.least_points
    if trusted.sum() < settings.least_scans:
        return None
    residual = profiles.clipped(profiles.without(profiles.height, 3), settings.winsorised_sigmas)
    freedom = np.maximum(counts - 3.0, 1.0)
    mean_square = profiles.sum(residual * residual) / freedom
    use = trusted & (mean_square > 0)
    if use.sum() < settings.least_scans or np.median(mean_square[use]) < _NOISE_FREE:
        return None
    white = whiteness(profiles, residual, use)
    level = Level.of(profiles, mean_square, freedom, use)
    parts: tuple[Part, ...] = ()
    pitch = _pitch(profiles)
    if white.p_value < settings.alpha:
        height = profiles.clipped(profiles.about_lines(use), settings.winsorised_sigmas)
        sample, pick = sample_of(profiles, height, np.sqrt(level.variance), use, pitch)
        parts = correlated_parts(sample, settings)
        if parts:
            mean_square = np.zeros(len(counts))
            squares = sample.factored(sample.correlation(parts))[1]
            mean_square[pick] = squares / sample.degrees_of_freedom * level.variance[pick]
            freedom = np.full(len(counts), float(sample.degrees_of_freedom))
            level = Level.of(profiles, mean_square, freedom, mean_square > 0)
    varies = level.p_varies < settings.alpha
    off = sigma_stated and level.p_stated < settings.alpha
    if not parts and not varies and not off:
        return None
    if not varies:
        level = level.constant()
    typical = float(np.exp(0.5 * np.mean(np.log(level.variance))))
    covariance = row_covariance(profiles, level.variance / typical**2, parts, pitch)
    return PoseNoise(
        sigma * typical,
        np.sqrt(level.variance) / typical,
        inverse_factors(covariance),
        components(parts, level, sigma, sigma * typical, varies, off),
        Autocorrelation(white.correlation, white.band),
    )


def _pitch(profiles: Profiles) -> float:
    """Return the median angle between neighbouring points [rad]."""
    scan = profiles.scan
    steps = np.diff(profiles.angle)[scan[1:] == scan[:-1]]
    return max(float(np.median(steps)), 1e-9)
