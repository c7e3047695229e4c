"""Noises that have names of their own: a spread of the joints from pose to pose, and an error common to a scan.

They enlarge what the config's `noise` block states, from the same draws.
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
    """Each joint repeats only to a spread of size, from pose to pose."""

    name: ClassVar[str] = "pose_jitter"
    unit: ClassVar[str] = "rad"

    @classmethod
    def inject(cls, entry: Mapping[str, Any], stage: Stage, rng: np.random.Generator) -> Self:
        """Draw nothing: the joints' own stream does."""
        return cls({}, entry["size"], {})

    def noise(self, noise: Noise) -> Noise:
        """Return the noise with more spread of the joints."""
        return replace(noise, joint_std=float(np.hypot(noise.joint_std, self.size)))


@dataclass(frozen=True, eq=False)
class ScanBias(InjectedEffect):
    """Each scan has an error of its own, with a spread of size."""

    name: ClassVar[str] = "scan_bias"
    unit: ClassVar[str] = "m"

    @classmethod
    def inject(cls, entry: Mapping[str, Any], stage: Stage, rng: np.random.Generator) -> Self:
        """Draw nothing: the scans' own stream does."""
        return cls({}, entry["size"], {})

    def noise(self, noise: Noise) -> Noise:
        """Return the noise with more spread of the scans."""
        return replace(noise, scan_bias_std=float(np.hypot(noise.scan_bias_std, self.size)))
