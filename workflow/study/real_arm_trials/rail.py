"""A linear axis that carries an arm: what a user declares of it, how it truly lies, and the errors of its own that the simulator's classes make."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from study.common import kinematics

TRAVEL = (-0.2, 1.6)  # m, its limits
SKEW, DISPLACED, TILTED = 3e-3, 2e-3, 5e-3
"""Standard deviation of the components of the axis' direction; shift [m] and turn [rad] of the arm on its carriage."""
T_BASE_RAIL = np.array([[0.0, 0, 1, 0], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1]])
"""The frame whose z axis is the linear axis, along x of the base."""


def on_a_rail(robot: dict[str, Any]) -> dict[str, Any]:
    """Return the ``robot:`` block of an arm whose linear axis is joint 1 and slides along x of the base frame.

    Args:
        robot: The block of the arm alone, in modified DH, with joint 1 upright.
    """
    first = dict(robot["joints"][0])
    first |= {"alpha": first["alpha"] - np.pi / 2, "theta": first["theta"] - np.pi / 2}
    rail = {"a": 0.0, "alpha": 0.0, "d": 0.0, "theta": 0.0, "limits": list(TRAVEL), "type": "prismatic"}
    return robot | {
        "name": f"{robot['name']} on a rail",
        "joints": [rail, first, *robot["joints"][1:]],
        "base": kinematics.pose_mapping(T_BASE_RAIL),
    }


@dataclass(frozen=True, eq=False)
class Rail:
    """The true linear axis.

    Attributes:
        direction: ``(3,)``, unit vector in the base frame.
        T_carriage_arm: ``(4, 4)``, the arm on its carriage.
    """

    direction: np.ndarray
    T_carriage_arm: np.ndarray

    @classmethod
    def drawn(cls, rng: np.random.Generator) -> Rail:
        """Return an axis that lies and carries its arm a little otherwise than declared."""
        direction = np.array([1.0, *(SKEW * rng.standard_normal(2))])
        carried = kinematics.random_transform(rng, DISPLACED, TILTED)
        return cls(direction / np.linalg.norm(direction), carried)

    def carrying(self, travel: np.ndarray, T_arm: np.ndarray) -> np.ndarray:
        """Return frames ``T_arm`` ``(N, 4, 4)`` in the arm's base, in the base frame, where the carriage stands at ``travel`` ``(N,)`` [m]."""
        T = np.tile(np.eye(4), (len(travel), 1, 1))
        T[:, :3, 3] = travel[:, None] * self.direction
        return T @ self.T_carriage_arm @ T_arm


@dataclass(frozen=True, eq=False)
class RailStage:
    """What an error of the linear axis is injected into: a stage (``scalar.simulation.injected.stage``) of one joint, in metres.

    Attributes:
        q: ``(N, 1)`` [m], travels in their order.
        poses: The table of these poses.
    """

    q: np.ndarray
    poses: pd.DataFrame

    def draw_joint(self, rng: np.random.Generator) -> int:
        """Return 1, its only joint."""
        return 1
