"""All lengths of an arm that differ by one factor: the instruments of two campaigns have different scales, or the arm was warmer in one of them.

A scanner whose ranges are 0.1 % too long, or a tracker with wrong refraction, stretches the whole calibrated arm and leaves no residual, so neither
calibration knows. The factor is a candidate of its own in addition to the single parameters. If it explains the difference, no single length is said
to have changed.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from scalar.comparison.arm_parameters import ArmParameters, scale_direction
from scalar.comparison.changes import Candidate, Change
from scalar.comparison.invariants import Invariants
from scalar.comparison.moved import Moved
from scalar.geometry.se3 import Array

SCALE = "scale of all lengths"
"""Name of the candidate."""


@dataclass(frozen=True, eq=False)
class Stretch:
    """By what share all lengths of B are longer than those of A, beyond chance.

    Attributes:
        value, std: The share and its standard error.
        p_value: Probability that chance alone makes any of the candidates explain as much.
        moved: How far it moves predicted positions.
    """

    value: float
    std: float
    p_value: float
    moved: Moved

    def to_mapping(self) -> Mapping[str, Any]:
        """Return its entry in ``comparison.json``."""
        return {
            "share": self.value,
            "std": self.std,
            "p_value": self.p_value,
            "moves_positions": self.moved.to_mapping(),
        }


def with_scale(
    arm: ArmParameters, compared: Invariants, candidates: list[Candidate]
) -> tuple[Invariants, list[Candidate]]:
    """Return the comparable functions with their response to the scale in a last column, and the candidates with the scale as the last."""
    response = np.column_stack([compared.response, compared.response @ _along(arm)])
    return Invariants(compared.difference, response), [*candidates, Candidate(SCALE, (len(arm.names),))]


def without_scale(
    arm: ArmParameters, changes: list[Change], columns: Array
) -> tuple[list[Change], Stretch | None]:
    """Return the changes of parameters and effects, and the change of the scale if it is among them.

    Args:
        arm: The arm's parameters.
        changes: As found among the candidates of ``with_scale``.
        columns: ``(3 K, P)`` [m per unit], derivatives of predicted positions by the arm's parameters.
    """
    found = [change for change in changes if change.candidate.name == SCALE]
    if not found:
        return changes, None
    value, std = float(found[0].value[0]), float(found[0].std[0])
    stretch = Stretch(value, std, found[0].p_value, Moved.of(columns @ _along(arm) * value))
    return [change for change in changes if change is not found[0]], stretch


def _along(arm: ArmParameters) -> Array:
    """Return by how much every parameter of the arm changes ``(P,)`` if all lengths double."""
    along = np.zeros(len(arm.names))
    geometry = scale_direction(arm.model)
    along[: len(geometry)] = geometry
    return along
