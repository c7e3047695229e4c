"""Calibrations for tests of ``scalar compare``."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from scalar.effects import Effect
from scalar.effects.joint_compliance import JointCompliance
from scalar.estimation.result import load_calibration
from scalar.geometry.robot import Robot
from tests.calibrated_arms import calibrated
from tests.robot_configs import robot_mapping


def save_calibrations(folder: Path) -> Path:
    """Save two calibrations of one arm, between which a zero changed by a milliradian, one with a bent tool, and two of other arms."""

    def save(name: str, robot: str, **by: float) -> None:
        made = calibrated(Robot.from_mapping(robot_mapping(robot)), np.random.default_rng(1))
        vector = made.model.vector.copy()
        for parameter, step in by.items():
            vector[made.model.names.index(parameter)] += step
        free = ("a_3", "theta_3", "alpha_4", "sensor_x")
        made = replace(made, model=made.model.with_vector(vector), free=free, covariance=np.eye(4) * 1e-10)
        made.save(folder / name)

    save("a.json", "vs060")
    save("b.json", "vs060", theta_3=1e-3)
    save("bent.json", "vs060", sensor_x=1e-3)
    save("puma.json", "puma560")
    save("panda.json", "panda")
    return folder


def save_with(
    path: Path, *effects: Effect, free: bool = True, fixed: Sequence[str] = (), **summary: Any
) -> Path:
    """Save ``a.json`` of the same folder with effects, and return its path.

    Args:
        path: Where it is saved.
        effects: The effects.
        free: Whether their coefficients were estimated, with small standard errors.
        fixed: Parameters of the geometry that are fixed then, in addition to those that are anyway.
        summary: Further entries of its summary.
    """
    made = load_calibration(path.parent / "a.json")
    made = replace(made, model=replace(made.model, effects=effects), summary={**made.summary, **summary})
    if free:
        names = [name for name in made.free if name not in fixed]
        names += [name for of_effect in made.model.effect_names for name in of_effect]
        made = replace(made, free=tuple(names), covariance=np.eye(len(names)) * 1e-12)
    made.save(path)
    return path


def softer(
    path: Path,
    terms: tuple[tuple[int, int], ...],
    size: float | Sequence[float],
    free: bool = True,
    **summary: Any,
) -> Path:
    """Save a calibration whose joints give way, by terms and a coefficient [rad] that are given, and return its path."""
    coefficients = np.broadcast_to(size, 2 * len(terms))
    return save_with(path, JointCompliance(terms, coefficients=coefficients), free=free, **summary)
