"""A parameter that is fixed because no measurement determines it, with the reason in a sentence that a roboticist understands."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from scalar.effects.title import joints_in_words
from scalar.geometry.robot import GEOMETRY
from scalar.geometry.se3 import Array

AS_ASKED = "fixed as asked"
NO_LENGTH_KNOWN = "no length is known in these data, so the whole workcell may be scaled: every length is relative to this one"
"""The reason of a parameter that is fixed because nothing shows the scale."""
BASE_NOT_SHOWN = (
    "the data do not show where the base is: if base and target moved together, no measurement would change"
)
"""The reason of parameters of joint 1 that are fixed because the place of the base is not measured."""

_WORTH_NAMING = 0.02  # of the largest component: below it a parameter is not named in a direction
_LEAST = 1e-4  # likewise where no other parameter is worth naming: below it nothing takes up a change [m/rad, or a ratio]
_SHORTEST_LENGTH = 0.01  # m: shorter lengths do not show whether a direction stretches them in proportion
_SAME_RATIO = 0.05  # of the largest: ratios that differ by less are taken as equal


@dataclass(frozen=True)
class FixedParameter:
    """A parameter that is fixed at its nominal value, and why.

    Attributes:
        name: Of the parameter.
        reason: A sentence.
        moves_with: Names of the parameters that would take up a change of it.
        cause: ``structural`` if no poses at all would determine it, ``still`` if a joint that never moves hides it,
            ``poses`` if other poses would determine it.
    """

    name: str
    reason: str
    moves_with: tuple[str, ...]
    cause: str


def explain(
    names: tuple[str, ...],
    index: int,
    direction: Array,
    still: list[int],
    values: dict[str, float],
    cause: str,
    prismatic: Sequence[int] = (),
) -> FixedParameter:
    """Return a fixed parameter with the reason in a sentence.

    Args:
        names: ``(C,)``, of the candidates.
        index: Which of them is fixed.
        direction: ``(C,)``, the null direction that fixing it removes, its own component being 1.
        still: Joints, counted from 1, that never move.
        values: Values [m or rad] by name, of all parameters except the other fixed ones.
        cause: As in ``FixedParameter``.
        prismatic: Joints that slide, from 0.
    """
    weight = np.abs(direction)
    order = np.argsort(-weight, kind="stable")
    others = [i for i in order[weight[order] > _WORTH_NAMING * weight.max()].tolist() if i != index]
    if not others:  # lengths are small numbers beside an angle: a tip 12 mm off an axis takes up its zero by 0.012 m for each radian
        others = [i for i in order[weight[order] > _LEAST * weight.max()].tolist() if i != index]
    moves_with = tuple(names[i] for i in others)
    name = names[index]
    joint = int(name.rsplit("_", 1)[1]) if name.rsplit("_", 1)[-1].isdigit() else 0
    in_target = any(not _is_robot(other) and not other.startswith("sensor_") for other in moves_with)
    if in_target and _is_scale(names, direction, values):
        reason = NO_LENGTH_KNOWN
    elif cause == "still":
        which = f"{joints_in_words(still)} never move{'' if len(still) > 1 else 's'}"
        consequence = (
            f"only its combination with {_listed(moves_with)} is determined"
            if others
            else "no residual depends on it"
        )
        reason = f"{which} in these data, so {consequence}"
    elif joint - 1 in prismatic and cause == "structural" and name.split("_")[0] in ("a", "d"):
        reason = (
            f"joint {joint} slides, so the direction of its axis matters and its place does not: "
            f"only the combination of that place with {_listed(moves_with)} is determined"
            if others
            else f"joint {joint} slides, so the place of its axis does not matter"
        )
    elif not others:
        reason = "no residual depends on it"
    elif joint == 1 and in_target:
        reason = BASE_NOT_SHOWN
    else:
        reason = f"only its combination with {_listed(moves_with)} is determined"
        if cause == "poses":
            reason += " at these poses; other poses would separate them"
    return FixedParameter(name, reason, moves_with, cause)


def _is_robot(name: str) -> bool:
    kind, _, number = name.rpartition("_")
    return kind in GEOMETRY and number.isdigit()


def _listed(names: tuple[str, ...], most: int = 4) -> str:
    shown = list(names[:most]) + ([f"{len(names) - most} more"] if len(names) > most else [])
    return shown[0] if len(shown) == 1 else ", ".join(shown[:-1]) + " and " + shown[-1]


def _is_scale(names: tuple[str, ...], direction: Array, values: dict[str, float]) -> bool:
    """Return whether a direction stretches every length of the arm beyond the first joint in proportion.

    That alone does not make it the scale: where two lengths lie along one line, and one is the negative of the other within a few percent,
    exchanging one for the other stretches both in proportion, but not the target. ``values`` leaves out the other fixed parameters, which stay
    where they are in every direction but their own.
    """
    ratios, moved = [], 0.0
    for i in _lengths_beyond_first(names):
        name = names[i]
        if abs(values.get(name, 0.0)) > _SHORTEST_LENGTH:
            ratios.append(direction[i] / values[name])
            moved = max(moved, float(abs(direction[i])))
    return (
        len(ratios) >= 2
        and moved > _WORTH_NAMING * float(np.abs(direction).max())  # else these are ratios of rounding errors
        and min(np.abs(ratios)) > 0
        and float(np.ptp(ratios)) < _SAME_RATIO * float(np.max(np.abs(ratios)))
    )


@lru_cache
def _lengths_beyond_first(names: tuple[str, ...]) -> list[int]:
    """Return the indices of the lengths of the arm beyond the first joint."""
    split = [name.rpartition("_") for name in names]
    return [i for i, (kind, _, k) in enumerate(split) if kind in ("a", "d") and k.isdigit() and int(k) > 1]
