"""Effects that these data cannot show: the model takes them up in its parameters, and the predictions are off all the same."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from scalar.diagnosis.candidate_set import CandidateEffect
from scalar.diagnosis.fitted_state import FittedState, whitened
from scalar.effects.effect import Effect, PointEffect
from scalar.geometry.se3 import Array
from scalar.units import DEG, MM

USUAL_SIZE = {
    "joint_compliance": 1e-3,
    "joint_harmonic": 3e-4,
    "joint_scale": 1e-3,
    "joint_coupling": 1e-3,
    "joint_backlash": 3e-4,
    "axis_nonparallel": 2e-3,
    "base_compliance": 5e-4,
    "range_scale": 1e-3,
    "range_offset": 3e-4,
}
"""What real arms and scanners have, in the unit of the coefficient (rad, rad/rad, m/m, m)."""


@dataclass(frozen=True)
class Unobservable:
    """An effect that leaves no residual here.

    Attributes:
        name, target: Of the effect.
        observability: ``|E'| / |E|``.
        consequence: What it would cost, in words.
    """

    name: str
    target: dict[str, Any]
    observability: float
    consequence: str

    def to_mapping(self) -> dict[str, Any]:
        """Return the entry of ``diagnosis.json``."""
        return {
            "name": self.name,
            "target": self.target,
            "observability": self.observability,
            "consequence": self.consequence,
        }


def unobservable_effects(state: FittedState, pool: Sequence[CandidateEffect]) -> list[Unobservable]:
    """Return the candidates that the data cannot show beside the model, with what they would cost unseen."""
    found_names = {effect.name for effect in state.effects}
    wanted = [c.effect for c in pool if c.effect.name in USUAL_SIZE and c.terms == 1]
    E = state.columns_of(wanted)
    background = state.background()
    J = whitened(state.whitening, state.linearised()[1])[: len(E)]
    left = E - background.Q @ (background.Q.T @ E)
    result = []
    start = 0
    for effect in wanted:
        where = slice(start, start + len(effect.coefficients))
        start = where.stop
        lengths = np.linalg.norm(E[:, where], axis=0)
        if not lengths.any() or effect.name in found_names:
            continue
        share = float(np.max(np.linalg.norm(left[:, where], axis=0)[lengths > 0] / lengths[lengths > 0]))
        if share < state.settings.observability.unobservable:
            shift = _hidden_shift(state, effect, E[:, where], J)
            result.append(Unobservable(effect.name, effect.target, share, _words(effect, shift)))
    return result


def _hidden_shift(state: FittedState, effect: Effect, E: Array, J: Array) -> float:
    """Return by how much predicted positions would be off [m] over these poses, the best rigid motion of the base removed."""
    size = USUAL_SIZE[effect.name] * np.eye(E.shape[1])[0]
    step = -np.linalg.lstsq(J, E @ size, rcond=1e-10)[0]
    kinematics = state.residuals.kinematics(state.model)
    screws = kinematics.screws()[:, :, state.free]
    o = kinematics.T_base_sensor[:, :3, 3]
    motion = screws @ step
    moved = motion[:, 3:] + np.cross(motion[:, :3], o)
    if not isinstance(effect, PointEffect):
        return 0.0
    lever = np.concatenate([-_skew_rows(o), np.tile(np.eye(3), (len(o), 1, 1))], axis=2).reshape(-1, 6)
    rest = moved.ravel() - lever @ np.linalg.lstsq(lever, moved.ravel(), rcond=None)[0]
    return float(np.sqrt(np.mean(np.sum(rest.reshape(-1, 3) ** 2, axis=1))))


def _skew_rows(p: Array) -> Array:
    S = np.zeros((len(p), 3, 3))
    S[:, 0, 1], S[:, 0, 2], S[:, 1, 2] = -p[:, 2], p[:, 1], -p[:, 0]
    S[:, 1, 0], S[:, 2, 0], S[:, 2, 1] = p[:, 2], -p[:, 1], p[:, 0]
    return S


def _words(effect: Effect, shift: float) -> str:
    unit = effect.coefficient_units[0]
    size = USUAL_SIZE[effect.name]
    text = (
        f"{size / DEG:.3g} deg"
        if unit == "rad"
        else (f"{size / MM:g} mm" if unit == "m" else f"{size:g} {unit}")
    )
    if shift > 0:
        return (
            f"an error of {text} would leave no residual and put predicted positions off by about {shift / MM:.2g} mm; "
            "a reference of known length would show it"
        )
    return f"an error of {text} would be taken up by the geometry: it leaves no residual, and does no harm where the data were taken"
