"""Variance components that are injected by name: errors of the joints that differ from pose to pose, and an error common to a scan.

They enlarge the standard deviations of the config's `noise` block, with the same draws.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Self

import numpy as np

from scalar.simulation.injected.base import InjectedEffect
from scalar.simulation.injected.stage import Stage
from scalar.simulation.noise import Noise


@dataclass(frozen=True, eq=False)
class PoseJitter(InjectedEffect):
    """At each pose, every joint has a random error with standard deviation `size`."""

    name: ClassVar[str] = "pose_jitter"
    unit: ClassVar[str] = "rad"

    @classmethod
    def inject(cls, entry: Mapping[str, Any], stage: Stage, rng: np.random.Generator) -> Self:
        """Draw nothing here: the errors come from the stream of the joints' noise."""
        return cls({}, entry["size"], {})

    def noise(self, noise: Noise) -> Noise:
        """Return the noise with a larger standard deviation of the joints."""
        return replace(noise, joint_std=float(np.hypot(noise.joint_std, self.size)))


@dataclass(frozen=True, eq=False)
class ScanBias(InjectedEffect):
    """Each scan has a random error common to its points, with standard deviation `size`."""

    name: ClassVar[str] = "scan_bias"
    unit: ClassVar[str] = "m"

    @classmethod
    def inject(cls, entry: Mapping[str, Any], stage: Stage, rng: np.random.Generator) -> Self:
        """Draw nothing here: the errors come from the stream of the scans' noise."""
        return cls({}, entry["size"], {})

    def noise(self, noise: Noise) -> Noise:
        """Return the noise with a larger standard deviation of the scans."""
        return replace(noise, scan_bias_std=float(np.hypot(noise.scan_bias_std, self.size)))
