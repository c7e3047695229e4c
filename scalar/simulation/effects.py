"""The hooks by which injected effects change a scene; here, each of them changes nothing.

An effect subclasses `Effects` and overrides the hooks of what it changes (`scalar.simulation.injected`). Poses are chosen
without effects, on the plain arm and flat target planes, so scenes with and without an effect have the same poses
and the same draws of noise. Effects that move the arm act on the evaluation poses too; those of target planes and of
measurements do not.
"""

from dataclasses import dataclass
from typing import Any, Self

import numpy as np
import pandas as pd

from scalar.simulation.arm import Arm
from scalar.simulation.noise import Noise
from scalar.simulation.target_planes import TargetPlane
from scalar.simulation.transforms import Array
from scalar.simulation.world import World

Rows = Any
"""What indexes rows of an array: a slice, a mask or an array of integers."""


@dataclass(frozen=True)
class Effects:
    """No effect at all; the base class of all that are injected.

    In all methods `poses` is the table of poses in acquisition order: q1..qn [rad] as the encoders read them, and every
    optional column of poses.csv that the scene records (time, approach1.., temperature). `evaluating` is True
    for the evaluation poses, at which the arm is in its state at the end of the run.
    """

    def joint_errors(self, world: World, q: Array, poses: pd.DataFrame) -> Array:
        """Return dq (N, n) [rad]: the arm is at q + dq. `world` contains the arm, for its inverse dynamics."""
        return np.zeros_like(q)

    def arms(self, arm: Arm, poses: pd.DataFrame, evaluating: bool) -> list[tuple[Rows, Arm]]:
        """Return the arm at each pose, as (rows, arm): one for all poses, or one for each stretch of a drift or slip."""
        return [(slice(None), arm)]

    def motions(self, world: World, q: Array, poses: pd.DataFrame) -> Array:
        """Return the motion of the whole arm (N, 4, 4) or (4, 4) in the base frame, as of a base that tilts."""
        return np.eye(4)

    def target_planes(
        self, target_planes: tuple[TargetPlane, ...], poses: pd.DataFrame
    ) -> list[tuple[Rows, tuple[TargetPlane, ...]]]:
        """Return the target planes at each pose, as (rows, target planes): bowed ones, or ones that were moved."""
        return [(slice(None), target_planes)]

    def range_errors(self, readings: Array, angles: Array, poses: pd.DataFrame) -> Array:
        """Return the errors (N, M) [m] of true readings (N, M) [m] along the error axis, before noise.

        A reading is the range along the ray, or z for a profiler that errs along z; `angles` (N, M) [rad].
        """
        return np.zeros_like(readings)

    def noise(self, noise: Noise) -> Noise:
        """Return the noise of the scene with that of the effects added."""
        return noise

    def at_rest(self) -> Self:
        """Return the effects as they act on evaluation poses, which are reached one by one and at rest."""
        return self

    def record(self) -> list[dict[str, Any]]:
        """Return the entries of `effects` in truth.json."""
        return []
