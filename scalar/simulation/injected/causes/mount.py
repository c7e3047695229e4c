"""Errors of the mounted scanner: a loose mount that gravity tips to either side, and a laser whose plane wanders."""

from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np
import pandas as pd

from scalar.simulation.arm import Arm
from scalar.simulation.effects import Rows
from scalar.simulation.injected.causes.base import Cause, every_joint
from scalar.simulation.injected.sensor import draw_direction
from scalar.simulation.injected.stage import Stage
from scalar.simulation.optics.triangulation import BASELINE
from scalar.simulation.transforms import Array

MOUNT_LENGTH = 0.1  # m; the play turns the mount by play / length
FRICTION = 0.25  # the scanner stays on its side until the pull of gravity to the other exceeds this share of its weight
MINUTES = (3.0, 10.0)  # correlation time of the laser's angle


@dataclass(frozen=True, eq=False)
class LooseMount(Cause):
    """The scanner rests on the one or the other side of its play: that to which its weight last pulled it against friction."""

    kind: ClassVar[str] = "loose_mount"
    unit: ClassVar[str] = "m"

    @classmethod
    def drawn(cls, target: dict[str, Any], size: float, stage: Stage, rng: np.random.Generator) -> Self:
        """Draw the direction of the play and the axis about which it turns."""
        play = draw_direction(rng)
        turn = np.cross(play, draw_direction(rng))
        turn = turn / np.linalg.norm(turn) * size / MOUNT_LENGTH
        details = cls.details_of(
            every_joint(stage.arm.n)[1:], play_direction=play.tolist(), turn_rad=turn.tolist()
        )
        pull = _pull(stage.arm, stage.q, play)
        return cls({}, size, details, states=sides(pull))

    def arms(self, arm: Arm, poses: pd.DataFrame, evaluating: bool) -> list[tuple[Rows, Arm]]:
        """Return the arm with the scanner on either side."""
        state = self.state(poses)
        play = np.array(self.details["play_direction"])
        if state is None:
            q = poses[[f"q{i + 1}" for i in range(arm.n)]].to_numpy()
            state = np.where(_pull(arm, q, play) >= 0, 1.0, -1.0)
        half = 0.5 * np.array(self.details["turn_rad"])
        return [
            (
                np.flatnonzero(state == side),
                arm.shifted({"t": side * 0.5 * self.size * play, "r": side * half}),
            )
            for side in (-1.0, 1.0)
        ]


def _pull(arm: Arm, q: Array, play: Array) -> Array:
    """Return the component of the weight along the play, over the weight (N,), -1 to 1."""
    R = arm.sensor_frames(q)[0]
    down = arm.gravity / np.linalg.norm(arm.gravity)
    return np.einsum("nij,i,j->n", R, down, play)


def sides(pull: Array) -> Array:
    """Return on which side a scanner rests (N,), 1 or -1: it stays until the pull the other way exceeds friction."""
    state = np.empty(len(pull))
    side = 1.0 if pull[0] >= 0 else -1.0
    for k, now in enumerate(pull):
        if side * now < -FRICTION:
            side = -side
        state[k] = side
    return state


@dataclass(frozen=True, eq=False)
class WanderingLaser(Cause):
    """The laser's plane turns about the scanner's x axis by an angle that wanders (Ornstein and Uhlenbeck's process).

    The light leaves in the turned plane, but the scanner computes the depth as if it left in the plane of the scanner's own
    calibration. The depth then has an error of angle z^2 / baseline.
    """

    kind: ClassVar[str] = "wandering_laser"

    @classmethod
    def drawn(cls, target: dict[str, Any], size: float, stage: Stage, rng: np.random.Generator) -> Self:
        """Draw the angles at the poses of the scene; at the evaluation poses the angle is zero."""
        time = stage.poses["time"].to_numpy(float)
        tau = 60.0 * float(rng.uniform(*MINUTES))
        draws = rng.standard_normal(len(time))
        angle = np.empty(len(time))
        angle[0] = draws[0]
        for k in range(1, len(time)):
            kept = np.exp(-(time[k] - time[k - 1]) / tau)
            angle[k] = kept * angle[k - 1] + np.sqrt(1 - kept**2) * draws[k]
        angle = angle * size / np.abs(angle).max()
        return cls({}, size, cls.details_of(["time"], forgets_s=tau), states=angle)

    def arms(self, arm: Arm, poses: pd.DataFrame, evaluating: bool) -> list[tuple[Rows, Arm]]:
        """Return an arm for each pose, with the scanner turned by the angle."""
        angles = self.state(poses)
        if angles is None or evaluating:
            return [(slice(None), arm)]
        return [(np.array([k]), arm.shifted({"r": np.array([a, 0.0, 0.0])})) for k, a in enumerate(angles)]

    def range_errors(self, readings: Array, angles: Array, poses: pd.DataFrame) -> Array:
        """Return how much too far points are measured (N, M) [m]."""
        turned = self.state(poses)
        if turned is None:
            return np.zeros_like(readings)
        return -turned[:, None] * (readings * np.cos(angles)) ** 2 / BASELINE
