"""The true arm of the tracked trials with injected causes (compliance, gear errors, play, lag, warming), by elementary mechanics.

Links are point masses at the origins of their frames, joints and the base are linear springs. The cause ``unknown``, a square wave
of a weighted sum of two joint angles, stands for causes that are not in the catalogue of effects.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from study.common import kinematics
from study.tracked_trials.tracked_arm import TrackedArm

GRAVITY = 9.81  # m/s2
HEAVIEST, LIGHTEST, PAYLOAD = 8.0, 1.5, 4.0
"""Masses [kg]: those of the links decrease from the base to the flange, which carries the payload."""
STEP = 1e-4  # rad, step of the numerical derivative of the potential energy
WAVES = (3.3, 2.1)  # the square wave is the sign of sin(3.3 q_j + 2.1 q_(j+1)), q in rad

Cause = Mapping[str, Any]
"""An injected cause: ``name``, ``target``, ``size`` and, for a harmonic, ``phase``."""


@dataclass(frozen=True, eq=False)
class Acquisition:
    """What happens while N poses are measured, in their order.

    Attributes:
        time: ``(N,)`` [s], time of each pose.
        settling: Time constant of the warming [s].
        approach: ``(N, n)``, +1 or -1, the direction in which each joint arrived.
        jitter: ``(N, n)`` [rad], random errors of the joints at each pose (repeatability).
    """

    time: np.ndarray
    settling: float
    approach: np.ndarray
    jitter: np.ndarray

    def of(self, keep: np.ndarray) -> Acquisition:
        """Return the acquisition of some of the poses alone, ``keep`` ``(N,)`` bool."""
        return Acquisition(self.time[keep], self.settling, self.approach[keep], self.jitter[keep])


@dataclass(frozen=True, eq=False)
class FlawedArm:
    """A true arm and its injected causes; joints in targets are counted from 1.

    Play, lag and warming act only during an acquisition, the other causes always.

    Attributes:
        arm: The true arm without the causes.
        causes: The injected causes.
        relative_compliance: ``{joint: its compliance relative to the size of an injected joint_compliance}``; a joint without an entry has that size.
    """

    arm: TrackedArm
    causes: Sequence[Cause]
    relative_compliance: Mapping[int, float] = field(default_factory=dict[int, float])

    def flange(self, q: np.ndarray, during: Acquisition | None = None) -> np.ndarray:
        """Return where the flange is ``(N, 4, 4)`` in the base frame, if the encoders read ``(N, n)`` [rad].

        Args:
            q: Joint angles as the encoders read them.
            during: The acquisition; None: a cold arm at rest, without play and random errors.
        """
        by_name = {cause["name"]: cause["size"] for cause in self.causes}
        geometry = self.arm.geometry
        if during is not None and "thermal_drift" in by_name:
            growth = by_name["thermal_drift"] * (1 - np.exp(-during.time / during.settling))
            geometry = np.repeat(geometry[:, :, None], len(q), axis=2)
            geometry[[0, 2]] *= 1 + growth
        T = kinematics.chain(geometry, self.angles(q, during)) @ self.arm.T_n_flange
        if "base_compliance" in by_name:
            x, y = self.moments(q)[1].T
            # The base tilts about the horizontal axis (-y, x) of the moment. This axis is rotated onto x, the base is tilted about
            # x, and the rotation is undone.
            tilt, heading = by_name["base_compliance"] * np.hypot(x, y), np.arctan2(x, -y)
            T = (
                kinematics.rotation(2, heading)
                @ kinematics.rotation(0, tilt)
                @ kinematics.rotation(2, -heading)
                @ T
            )
        return T

    def angles(self, q: np.ndarray, during: Acquisition | None) -> np.ndarray:
        """Return the true joint angles ``(N, n)`` [rad]; the arguments are those of ``flange``."""
        true = q.copy()
        for cause in self.causes:
            name, size, target = cause["name"], cause["size"], cause["target"]
            j = target.get("joint", 1) - 1
            if name == "joint_harmonic":
                true[:, j] += size * np.sin(target["order"] * q[:, j] + cause["phase"])
            elif name == "joint_scale":
                true[:, j] += size * q[:, j]
            elif name == "joint_coupling":
                true[:, j] += size * q[:, target["source"] - 1]
            elif name == "unknown":
                true[:, j] += size * np.sign(np.sin(WAVES[0] * q[:, j] + WAVES[1] * q[:, j + 1]))
            elif name == "joint_compliance":
                for joint in target["joints"]:
                    step = STEP * np.eye(q.shape[1])[joint - 1]
                    torque = (self.moments(q + step)[0] - self.moments(q - step)[0]) / (2 * STEP)
                    true[:, joint - 1] -= size * self.relative_compliance.get(joint, 1.0) * torque
            elif name == "joint_backlash" and during is not None:
                true[:, j] += size / 2 * during.approach[:, j]
            elif name == "pose_lag" and during is not None:
                true[1:, j] -= size * np.diff(q[:, j])
        return true if during is None else true + during.jitter

    def moments(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the potential energy ``(N,)`` [J], and the sum of the weights times their x and y in the base frame ``(N, 2)`` [N m]."""
        masses = np.linspace(HEAVIEST, LIGHTEST, q.shape[1])
        masses[0] = 0.0  # turns about an upright axis and does not move
        masses[-1] += PAYLOAD
        places = np.stack([T[:, :3, 3] for T in kinematics.links(self.arm.geometry, q)])
        weighted = np.einsum("i,ink->nk", GRAVITY * masses, places)
        return weighted[:, 2], weighted[:, :2]
