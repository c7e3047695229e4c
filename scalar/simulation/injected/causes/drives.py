"""Errors of drives: a belt on two eccentric pulleys, an encoder's interpolation, a gear with two slopes of stiffness."""

from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np
import pandas as pd

from scalar.simulation.injected.causes.base import Cause, scaled
from scalar.simulation.injected.stage import Stage
from scalar.simulation.transforms import Array
from scalar.simulation.world import World

ECCENTRICITY = 1e-3  # over the radius; with so small a value the error is proportional to it, and can be scaled afterwards
TURNS = (2.2, 6.8)  # turns of the driven pulley in one turn of the joint
PULLEYS = (1.4, 2.6)  # turns of the driving pulley in one turn of the driven pulley
NOT_WHOLE = 0.15  # least distance of the numbers of turns from a whole number, since designers choose teeth without common factors
ROUNDS = 20  # rounds of the fixed-point iteration for the belt's equation
LINES = 512  # lines on the disc of an encoder at the joint
SIGNAL_FAULT = 0.02  # standard deviation of the errors of gain, quadrature and offset of its two signals
FIRST_SLOPE_ENDS = (0.25, 0.5)  # torque at which the first slope ends, over the largest torque in the scene
STIFFER = (3.0, 5.0)  # stiffness of the second slope over that of the first


@dataclass(frozen=True, eq=False)
class DriveCause(Cause):
    """An error of one joint, a function of its own angle or torque alone."""

    of_a_joint: ClassVar[bool] = True

    def joint_errors(self, world: World, q: Array, poses: pd.DataFrame) -> Array:
        """Return dq (N, n) [rad]."""
        dq = np.zeros_like(q)
        j = self.target["joint"] - 1
        dq[:, j] = self.details["factor"] * self.raw(world, q, j)
        return dq

    def raw(self, world: World, q: Array, j: int) -> Array:
        """Return the error of the joint with index j, from 0, before it is scaled (N,)."""
        raise NotImplementedError

    @classmethod
    def _scaled_to_size(
        cls, target: dict[str, Any], size: float, stage: Stage, depends_on: list[str], **details: Any
    ) -> Self:
        """Return the cause with the factor that makes its largest error in the scene `size`."""
        unscaled = cls(target, size, cls.details_of(depends_on, factor=1.0, **details))
        with World() as world:
            world.place_arm(stage.arm)
            _, factor = scaled(unscaled.raw(world, stage.q, target["joint"] - 1), size)
        return cls(target, size, unscaled.details | {"factor": factor})


@dataclass(frozen=True, eq=False)
class TwoPulleyBelt(DriveCause):
    """A belt over two eccentric pulleys.

    The belt does not stretch: r2(theta2) dtheta2 = r1(theta1) dtheta1 with r = R (1 + e cos(theta + phi)), so
    theta2 + e2 sin(theta2 + phi2) = (theta1 + e1 sin(theta1 + phi1)) / ratio. The driven pulley does not turn a whole number of times in
    a turn of the joint, nor the driving one in a turn of the driven.
    """

    kind: ClassVar[str] = "two_pulley_belt"

    @classmethod
    def drawn(cls, target: dict[str, Any], size: float, stage: Stage, rng: np.random.Generator) -> Self:
        """Draw joint, turns and phases."""
        joint = target.get("joint", stage.draw_joint(rng))
        turns = _not_whole(rng, *TURNS)
        details = {
            "turns": turns,
            "ratio": _not_whole(rng, *PULLEYS),
            "shares": rng.uniform(0.3, 1.0, 2).tolist(),
        }
        phases = rng.uniform(0.0, 2 * np.pi, 2).tolist()
        return cls._scaled_to_size({"joint": joint}, size, stage, [f"q{joint}"], **details, phases_rad=phases)

    def raw(self, world: World, q: Array, j: int) -> Array:
        """Return the difference of the driven pulley's angle from that with ideal pulleys, as a joint angle (N,) [rad]."""
        d = self.details
        e1, e2 = ECCENTRICITY * np.array(d["shares"])
        driving = d["turns"] * d["ratio"] * q[:, j]
        ideal = driving / d["ratio"]
        fed = (driving + e1 * np.sin(driving + d["phases_rad"][0])) / d["ratio"]
        driven = ideal
        for _ in range(ROUNDS):
            driven = fed - e2 * np.sin(driven + d["phases_rad"][1])
        return (driven - ideal) / d["turns"]


def _not_whole(rng: np.random.Generator, low: float, high: float) -> float:
    """Return a random number from `low` to `high` that is not near a whole number."""
    while True:
        value = float(rng.uniform(low, high))
        if abs(value - round(value)) > NOT_WHOLE:
            return value


@dataclass(frozen=True, eq=False)
class EncoderInterpolation(DriveCause):
    """An encoder with 512 lines whose sine and cosine signals have errors of gain, quadrature and offset.

    The angle within a line is the arc tangent of the two signals. Its error repeats 512 times a turn, so often that poses at random
    angles cannot resolve it.
    """

    kind: ClassVar[str] = "encoder_interpolation"

    @classmethod
    def drawn(cls, target: dict[str, Any], size: float, stage: Stage, rng: np.random.Generator) -> Self:
        """Draw joint and signal faults."""
        joint = target.get("joint", stage.draw_joint(rng))
        faults = (SIGNAL_FAULT * rng.standard_normal(4)).tolist()
        return cls._scaled_to_size(
            {"joint": joint}, size, stage, [f"q{joint}"], lines=LINES, signal_faults=faults
        )

    def raw(self, world: World, q: Array, j: int) -> Array:
        """Return the interpolated angle minus the true one (N,) [rad]."""
        gain, quadrature, offset_sine, offset_cosine = self.details["signal_faults"]
        phase = self.details["lines"] * q[:, j]
        sine = (1.0 + gain) * np.sin(phase + quadrature) + offset_sine
        cosine = np.cos(phase) + offset_cosine
        read = np.arctan2(sine, cosine)
        return np.angle(np.exp(1j * (read - phase))) / self.details["lines"]


@dataclass(frozen=True, eq=False)
class TwoSlopeGear(DriveCause):
    """A gear that is stiffer above a torque T1, as strain wave gears are: stiffness K1 up to T1, then K2, for either sign."""

    kind: ClassVar[str] = "two_slope_gear"

    @classmethod
    def drawn(cls, target: dict[str, Any], size: float, stage: Stage, rng: np.random.Generator) -> Self:
        """Draw a joint that carries weight, the torque at the bend and the second slope."""
        joint = target.get("joint", stage.draw_joint(rng, stage.loaded, "no joint carries weight"))
        bend = float(rng.uniform(*FIRST_SLOPE_ENDS) * np.abs(stage.torques[:, joint - 1]).max())
        stiffer = float(rng.uniform(*STIFFER))
        depends_on = [f"q{j}" for j in range(2, stage.arm.n + 1)]
        return cls._scaled_to_size({"joint": joint}, size, stage, depends_on, bend_n_m=bend, stiffer=stiffer)

    def raw(self, world: World, q: Array, j: int) -> Array:
        """Return the wind-up (N,) times the stiffness K1 [N m]."""
        torque = world.gravity_torques(q)[:, j]
        bend = self.details["bend_n_m"]
        soft = np.clip(np.abs(torque), 0.0, bend)
        return np.sign(torque) * (soft + (np.abs(torque) - soft) / self.details["stiffer"])
