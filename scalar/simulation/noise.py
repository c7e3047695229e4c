"""The noise of the measurements: of each range, of each scan and of the joints, and rounding.

Each is declared in the config and off by default. Draws are standard normal and scaled afterwards,
so that scenes of one seed differ in the size of their noise and not in its pattern.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from scalar.simulation.transforms import Array


@dataclass(frozen=True)
class Noise:
    """Standard deviations of the noises.

    Attributes:
        range_std: of the error of each point, independent and Gaussian, as in the paper [m].
        scan_bias_std: of the Gaussian error of each scan, common to its points [m].
        joint_std: of the Gaussian error of each joint at each pose [rad]: encoders read q, and the arm is at q + error.
        range_quantum: the step [m] to which ranges are rounded at the end; 0 if they are not rounded.
    """

    range_std: float
    scan_bias_std: float
    joint_std: float
    range_quantum: float


def noise_from_mapping(noise: Mapping[str, float]) -> Noise:
    """Return the noises of the config's `noise` block."""
    return Noise(
        range_std=float(noise["range_noise_std_m"]),
        scan_bias_std=float(noise["scan_bias_std_m"]),
        joint_std=float(noise["joint_noise_std_rad"]),
        range_quantum=float(noise["range_quantum_m"]),
    )


def noisy_points(
    ranges: Array,
    angles: Array,
    noise: Noise,
    draws: Array,
    bias_draws: Array,
    error_axis: str,
    systematic: Array | float = 0.0,
) -> Array:
    """Return the measured points (x, z), (N, M, 2) [m].

    Along the ray: range + e, then rounded. Along z (a triangulating profiler): z + e, then rounded, with x
    kept.

    Args:
        ranges: (N, M) [m], the true ranges along the rays.
        angles: (N, M) [rad], of the rays.
        noise: the standard deviations.
        draws: (N, M) and bias_draws: (N,) standard normal.
        error_axis: "ray" or "z".
        systematic: (N, M) [m], errors along the same axis that are not noise.
    """
    error = noise.range_std * draws + noise.scan_bias_std * bias_draws[:, None] + systematic
    x, z = ranges * np.sin(angles), ranges * np.cos(angles)
    if error_axis == "z":
        return np.stack([x, _rounded(z + error, noise.range_quantum)], -1)
    measured = _rounded(ranges + error, noise.range_quantum)
    return np.stack([measured * np.sin(angles), measured * np.cos(angles)], -1)


def _rounded(values: Array, quantum: float) -> Array:
    return values if quantum == 0 else np.round(values / quantum) * quantum
