"""Which parameters three planes leave undetermined for the six-axis arms of the library, and whether the original's list fixes them.

The original paper names seven parameters to fix, for its own arm. Whether other arms need the same ones depends on their axes alone. Every arm is
given the original's scanner, a floor and two upright walls in proportion to its reach, and random poses within its joint limits. The Jacobian
of perfect measurements is taken there, so that neither noise nor what a scanner would see matters.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd

from scalar.data.declared import PlaneGuess, Sensor
from scalar.data.sensor_formats import sensor_formats
from scalar.estimation.identifiability import analyse
from scalar.estimation.prepare import candidate_mask
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import Array
from scalar.planning.information import linearised_at
from scalar.planning.workcell import Workcell
from scalar.robots import LibraryArm, arm_names, read_arm

JOINTS = 6
POSES_PER_PLANE = 40
"""As in the original's headline."""
_WALL = 0.7  # distance of the walls, as a share of the reach
_NOISE = 1e-4  # m; the scanner has to state one, and the null space does not depend on it


def arms_table(T_flange_sensor: Array, published: Sequence[str]) -> pd.DataFrame:
    """Return a row for each six-axis arm of the library with revolute joints.

    Columns: ``arm``, ``maker``, ``model``; ``columns``, the number of parameters with a column of their own; ``zero_singular_values``; ``held``, the
    parameters to fix, separated by spaces; ``left_by_published``, how many directions stay undetermined if the original's list is fixed
    instead; and ``same_set``, whether both lists are the same.

    Args:
        T_flange_sensor: ``(4, 4)``, the scanner on the flange.
        published: The parameters that the original fixes.
    """
    rows: list[dict[str, Any]] = []
    for arm in map(read_arm, arm_names()):
        robot = Robot.from_mapping(arm.mapping)
        if robot.n_joints != JOINTS or any(robot.prismatic):
            continue
        workcell = _workcell(arm, robot, T_flange_sensor)
        low, high = robot.limits.T
        plane = np.repeat(np.arange(len(workcell.planes)), POSES_PER_PLANE)
        q = np.random.default_rng(0).uniform(low, high, (len(plane), JOINTS))
        residuals, model = linearised_at(workcell.model, workcell.dataset(q, plane), measured=False)
        found = analyse(residuals, model, candidate_mask(model))
        with_published = analyse(residuals, model, candidate_mask(model, tuple(published)))
        rows.append(
            {
                "arm": arm.name,
                "maker": arm.maker,
                "model": arm.model,
                "columns": len(found.names),
                "zero_singular_values": found.n_null,
                "held": " ".join(found.fixed_names),
                "left_by_published": with_published.n_null,
                "same_set": set(found.fixed_names) == set(published),
            }
        )
    return pd.DataFrame(rows)


def _workcell(arm: LibraryArm, robot: Robot, T_flange_sensor: Array) -> Workcell:
    """Return a floor and two walls about an arm, in proportion to its reach."""
    wall = _WALL * float(arm.reach)
    planes = (
        PlaneGuess("floor", np.array([0.0, 0.0, 1.0]), 0.0),
        PlaneGuess("wall_x", np.array([1.0, 0.0, 0.0]), wall),
        PlaneGuess("wall_y", np.array([0.0, 1.0, 0.0]), wall),
    )
    scanner = next(kind for kind, format in sensor_formats().items() if format.scans)
    return Workcell.of(robot, Sensor(scanner, T_flange_sensor, _NOISE), planes)


def arms_numbers(table: pd.DataFrame) -> dict[str, Any]:
    """Return what the paper quotes: how many arms there are, how many need the original's list, and what the others need besides."""
    others: Any = table[~table["same_set"]]
    common = set.intersection(*(set(held.split()) for held in table["held"]))
    return {
        "arms": len(table),
        "makers": len(set(table["maker"])),
        "same_set": sum(map(bool, table["same_set"])),
        "others": len(others),
        "others_makers": sorted(set(others["maker"])),
        "others_hold_also": sorted({name for held in others["held"] for name in held.split()} - common),
        "others_zero_singular_values": sorted(set(map(int, others["zero_singular_values"]))),
    }
