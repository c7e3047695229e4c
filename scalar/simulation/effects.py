"""Where something may be planted in a scene that the published model does not know: the hooks, all idle here.

An effect subclasses `Effects` and overrides what it changes. Poses are chosen before effects act, on the
plain arm and flat plates, so scenes with and without an effect have the same poses. Effects that move the arm
act on the evaluation poses too; those of plates and of measuring do not.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from scalar.simulation.arm import Arm
from scalar.simulation.plates import Plate
from scalar.simulation.transforms import Array
from scalar.simulation.world import World

Rows = Any
"""What indexes rows of an array: a slice, a mask or an array of integers."""


@dataclass(frozen=True)
class Effects:
    """No effect at all; the base of those that are planted.

    `poses` is the table of poses in acquisition order: q1..qn [rad] as the encoders read them, and every
    optional column of poses.csv that the scene has (order, time, approach1.., temperature). `evaluating` is
    True for the evaluation poses.
    """

    def columns(self, poses: pd.DataFrame, rng: np.random.Generator) -> dict[str, Array]:
        """Return columns to add to poses.csv, each (N,): time, approach1, ..."""
        return {}

    def joint_errors(self, world: World, q: Array, poses: pd.DataFrame) -> Array:
        """Return dq (N, n) [rad]: the arm stands at q + dq. `world` holds it, for its inverse dynamics."""
        return np.zeros_like(q)

    def arms(self, arm: Arm, poses: pd.DataFrame, evaluating: bool) -> list[tuple[Rows, Arm]]:
        """Return which arm stands at which poses: one for all, or one for each stretch of a drift or slip."""
        return [(slice(None), arm)]

    def move_frames(self, T_base_sensor: Array, q: Array, poses: pd.DataFrame) -> Array:
        """Return the sensor frames (N, 4, 4) after what moves the whole arm: a base that tilts."""
        return T_base_sensor

    def plates(self, plates: tuple[Plate, ...], poses: pd.DataFrame) -> list[tuple[Rows, tuple[Plate, ...]]]:
        """Return which plates stand at which poses: bowed ones, or ones that were knocked."""
        return [(slice(None), plates)]

    def ranges(self, ranges: Array, angles: Array, poses: pd.DataFrame) -> Array:
        """Return what the laser makes of the true ranges (N, M) [m] before noise: gain, zero, curvature."""
        return ranges

    def record(self) -> list[dict[str, Any]]:
        """Return the entries of `effects` in truth.json."""
        return []
