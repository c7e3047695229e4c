"""A hose or a bundle of cables between the base and the sensor, whose pull depends on its earlier lengths."""

from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np
import pandas as pd

from scalar.simulation.arm import Arm
from scalar.simulation.body import reach
from scalar.simulation.injected.causes.base import Cause, every_joint
from scalar.simulation.injected.stage import Stage
from scalar.simulation.transforms import Array
from scalar.simulation.world import World

STEP = 1e-5  # rad; step of central differences
SLACK = (0.2, 0.5)  # the hose is slack below this quantile of its lengths in the scene
MEMORY = (0.4, 0.8)  # stiffness of the spring that relaxes, over that of the one that does not
MINUTES = (1.0, 5.0)  # time constant of the relaxation
# Over the arm's reach: the anchor's distance from the base's z axis is the first, its height is between the two.
ANCHOR = (0.15, 0.4)
WRIST_SOFTER = 4.0  # compliance of the joints from the fourth on, over that of the others


@dataclass(frozen=True, eq=False)
class Hose(Cause):
    """A spring between an anchor beside the base and the sensor, slack below a length, in parallel with one that relaxes.

    The tension is F = max(L - L0, 0) + m (L - r), where r follows the length L as dr/dt = (L - r) / tau (a standard linear
    solid). The torque about a joint is -F dL/dq, and each joint deflects in proportion to it.
    """

    kind: ClassVar[str] = "hose"

    @classmethod
    def drawn(cls, target: dict[str, Any], size: float, stage: Stage, rng: np.random.Generator) -> Self:
        """Draw anchor, slack length L0 and memory m; `states` are the lengths r (N,) [m]."""
        span = reach(stage.arm)
        turn = rng.uniform(0.0, 2 * np.pi)
        radius = ANCHOR[0] * span
        anchor = [radius * np.cos(turn), radius * np.sin(turn), rng.uniform(*ANCHOR) * span]
        length = _length(stage.arm, stage.q, np.array(anchor))
        tau = 60.0 * rng.uniform(*MINUTES)
        memory = rng.uniform(*MEMORY)
        slack = float(np.quantile(length, rng.uniform(*SLACK)))
        remembered = relaxed(length, stage.poses["time"].to_numpy(float), tau)
        details = cls.details_of(
            [*every_joint(stage.arm.n), "time"],
            anchor_m=anchor, slack_m=slack, memory=memory, relaxes_s=tau, factor=1.0,
        )  # fmt: skip
        hose = cls({}, size, details, states=remembered)
        largest = np.abs(hose._deflection(stage.arm, stage.q, remembered)).max()
        return cls({}, size, details | {"factor": float(size / largest)}, states=remembered)

    def joint_errors(self, world: World, q: Array, poses: pd.DataFrame) -> Array:
        """Return dq (N, n) [rad]; at rest the second spring has relaxed."""
        assert world.arm is not None, "no arm has been placed"
        return self._deflection(world.arm, q, self.state(poses))

    def _deflection(self, arm: Arm, q: Array, remembered: Array | None) -> Array:
        """Return dq (N, n) [rad], with the lengths r (N,) [m], or None if the second spring has relaxed."""
        anchor = np.array(self.details["anchor_m"])
        length = _length(arm, q, anchor)
        tension = np.maximum(length - self.details["slack_m"], 0.0)
        if remembered is not None:
            tension = tension + self.details["memory"] * (length - remembered)
        softness = np.where(np.arange(arm.n) >= 3, WRIST_SOFTER, 1.0)
        slopes = np.empty_like(q)
        for j in range(arm.n):
            step = np.zeros(arm.n)
            step[j] = STEP
            slopes[:, j] = (_length(arm, q + step, anchor) - _length(arm, q - step, anchor)) / (2 * STEP)
        return -self.details["factor"] * softness * tension[:, None] * slopes


def _length(arm: Arm, q: Array, anchor: Array) -> Array:
    """Return the distance (N,) [m] between the anchor and the sensor's origin."""
    return np.linalg.norm(arm.sensor_frames(q)[1] - anchor, axis=1)


def relaxed(length: Array, time: Array, tau: float) -> Array:
    """Return the length r on arrival at each pose (N,) [m], if the hose kept each length until the arrival at the next pose."""
    remembered = np.empty_like(length)
    remembered[0] = length[0]
    for k in range(1, len(length)):
        share = 1.0 - np.exp(-(time[k] - time[k - 1]) / tau)
        remembered[k] = remembered[k - 1] + share * (length[k - 1] - remembered[k - 1])
    return remembered
