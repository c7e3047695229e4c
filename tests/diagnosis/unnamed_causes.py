"""Workcells with a cause that no effect of the catalogue describes; a diagnosis must call it unattributed."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from tests.diagnosis.cases import draw, unit
from tests.effects.injected import Cell, Flaws, PoseData, make_cell, on_joint


def unnamed(seed: int, **settings: Any) -> tuple[Cell, str, dict[str, Any]]:
    """Joint 3 errs with the product of two other joints' angles."""
    error = on_joint(3, lambda at: 5e-4 * np.sin(at.q[:, 1] * at.q[:, 4]))
    return make_cell(Flaws(joints=error), seed=seed, **settings), "unattributed", {"depends_on": {"q2", "q5"}}


def along_one_joint(seed: int, curve: Callable[[np.ndarray, np.random.Generator], np.ndarray]) -> Flaws:
    """A joint errs along its own angle, neither as a gear does nor in proportion."""
    rng = draw(seed)
    j = int(rng.integers(1, 6))
    state = rng.bit_generator.state

    def error(at: PoseData) -> np.ndarray:
        again = np.random.default_rng()
        again.bit_generator.state = state
        return curve(at.q[:, j - 1], again)

    return Flaws(joints=on_joint(j, error))


def worn_teeth(q: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """An error of 4e-4 rad over a quarter of a radian, with flanks of another quarter."""
    return 4e-4 * np.clip(1.5 - np.abs(q - rng.uniform(-0.5, 0.5)) / 0.25, 0.0, 1.0)


def lost_count(q: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """An error of 3e-4 rad beyond one angle."""
    return 3e-4 * (q > rng.uniform(-0.4, 0.4))


def bent_scale(q: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """A scale error of 6e-4 rad per radian whose sign changes at one angle."""
    return 6e-4 * np.abs(q - rng.uniform(-0.4, 0.4))


def belt(q: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """A sawtooth of 6e-4 rad whose period is no whole part of a turn."""
    period = rng.uniform(0.5, 1.0)
    return 6e-4 * (np.mod(q, period) / period - 0.5)


def late_jump(seed: int) -> Flaws:
    """A joint that is off by 5e-4 rad from some moment on."""
    rng = draw(seed)
    j, share = int(rng.integers(2, 6)), rng.uniform(0.3, 0.7)
    return Flaws(
        joints=on_joint(j, lambda at: 5e-4 * (at.columns["time"] > share * at.columns["time"].max()))
    )


def swaying_floor(seed: int) -> Flaws:
    """A base that sways by 0.3 mm a few times in a run."""
    rng = draw(seed)
    way, periods = 3e-4 * unit(rng), rng.uniform(2.0, 6.0)

    def sway(at: PoseData) -> np.ndarray:
        T = np.tile(np.eye(4), (len(at.q), 1, 1))
        share = at.columns["time"] / at.columns["time"].max()
        T[:, :3, 3] = np.sin(2 * np.pi * periods * share + 1.0)[:, None] * way
        return T

    return Flaws(base=sway)


UNNAMED: dict[str, Callable[[int], Flaws]] = {
    "worn teeth": lambda seed: along_one_joint(seed, worn_teeth),
    "lost count": lambda seed: along_one_joint(seed, lost_count),
    "bent scale": lambda seed: along_one_joint(seed, bent_scale),
    "belt": lambda seed: along_one_joint(seed, belt),
    "late jump": late_jump,
    "swaying floor": swaying_floor,
}
