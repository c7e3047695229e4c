"""The parameters of the arm in two calibrations: their difference, its covariance, and those that one of the two does not determine.

The two campaigns are independent, so the covariance of the difference is the sum of both covariances. Sensor, planes and tracker frames
belong to a campaign and are left out; the marginal covariance of the arm's parameters accounts for their uncertainty.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from scalar.effects.effect import Effect
from scalar.estimation.fixed_parameter import NO_LENGTH_KNOWN
from scalar.estimation.model import Model
from scalar.estimation.result import Calibration
from scalar.geometry.robot import GEOMETRY, LENGTHS
from scalar.geometry.se3 import Array

_TERMS = ("order", "orders")  # keys of an effect's target or settings that list its terms
_STRUCTURAL = "structural"  # cause of a fixed parameter: no poses could determine it, so fixing it is the choice of a frame


@dataclass(frozen=True, eq=False)
class ArmParameters:
    """The arm's P parameters in two calibrations A and B.

    Attributes:
        model: The model of A with the arm's effects of both; those that only B has have coefficients of zero.
        names: ``(P,)``, names of the arm's parameters, as in ``model.names``.
        columns: ``(P,)``, their positions in ``model.names``.
        units: ``(P,)``, their units.
        difference: ``(P,)``, values of B minus those of A, in these units.
        covariance: ``(P, P)`` of the difference; zero for what was fixed in both.
        unknown: ``{name: reason}`` of the parameters that cannot be compared because one of the two does not determine them.
        fixed_in_both: ``(P,)`` bool, fixed in both, and not by the choice of a frame.
        scale_unknown: Whether one of the two does not determine the scale of the arm.
        only_in: The parameters that only A estimated or contains, and those that only B does; a choice of frames does not count.
        effects_differ: Whether one of the two was calibrated without an effect of the arm that the other has.
    """

    model: Model
    names: list[str]
    columns: Array
    units: list[str]
    difference: Array
    covariance: Array
    unknown: dict[str, str]
    fixed_in_both: Array
    scale_unknown: bool
    only_in: tuple[tuple[str, ...], tuple[str, ...]]
    effects_differ: bool


def arm_parameters(a: Calibration, b: Calibration) -> ArmParameters:
    """Return the arm's parameters of two calibrations of one arm."""
    term_columns = [effect_terms(calibration.model) for calibration in (a, b)]
    added = [e for e in effects_of_the_arm(b.model) if not set(_terms(e)) <= set(term_columns[0])]
    zero = [effect.with_coefficients(0 * effect.coefficients) for effect in added]
    union = replace(a.model, effects=(*effects_of_the_arm(a.model), *zero))
    # Parameters of A, B and their union are matched by identity: the name of a geometric parameter, or the term of an effect.
    union_columns = _geometry_columns(union) | effect_terms(union)
    own_columns = [_geometry_columns(c.model) | terms for c, terms in zip((a, b), term_columns, strict=True)]
    P = len(union_columns)
    value, covariance, free = np.zeros((2, P)), np.zeros((P, P)), np.zeros((2, P), dtype=bool)
    for k, (calibration, own) in enumerate(zip((a, b), own_columns, strict=True)):
        vector, names = calibration.model.vector, calibration.model.names
        row_of = {name: i for i, name in enumerate(calibration.free)}
        matched = [(i, own[key]) for i, key in enumerate(union_columns) if key in own]
        for i, column in matched:
            value[k, i] = vector[column]
            free[k, i] = names[column] in row_of
        estimated = [(i, row_of[names[column]]) for i, column in matched if names[column] in row_of]
        to, source = (np.array(x, dtype=int) for x in zip(*estimated, strict=True))
        covariance[np.ix_(to, to)] += calibration.covariance[np.ix_(source, source)]
    names = [union.names[column] for column in union_columns.values()]
    present = np.array([[key in own for key in union_columns] for own in own_columns])
    unknown = _unknown(names, free, present, value, (a, b))
    by_frames = _fixed_by_frames((a, b))
    return ArmParameters(
        model=union,
        names=names,
        columns=np.array(list(union_columns.values()), dtype=int),
        units=[union.units[column] for column in union_columns.values()],
        difference=value[1] - value[0],
        covariance=covariance,
        unknown=unknown,
        fixed_in_both=~free.any(axis=0) & np.array([name not in by_frames for name in names]),
        scale_unknown=any(entry["reason"] == NO_LENGTH_KNOWN for c in (a, b) for entry in c.gauge),
        only_in=_only_in(names, free, present, by_frames),
        effects_differ=not present.all(),
    )


def scale_direction(model: Model) -> Array:
    """Return by how much every geometric parameter changes ``(5 n,)`` [m] if all lengths of the arm double; angles do not change."""
    lengths = np.array([[kind in LENGTHS] for kind in GEOMETRY])
    return (model.robot.geometry * lengths).ravel()


def _unknown(
    names: list[str], free: Array, present: Array, value: Array, both: tuple[Calibration, Calibration]
) -> dict[str, str]:
    """Return the parameters that cannot be compared because one of two calibrations does not determine them, with the reason.

    Args:
        names: ``(P,)``, the arm's parameters.
        free: ``(2, P)`` bool, whether A and B estimated each.
        present: ``(2, P)`` bool, whether the models of A and B have each.
        value: ``(2, P)``, their values in A and in B.
        both: A and B.
    """
    unknown: dict[str, str] = {}
    for letter, calibration in zip("AB", both, strict=True):
        for entry in calibration.gauge:
            if entry.get("cause") != _STRUCTURAL:
                for name in (entry["held"], *entry["moves_with"]):
                    unknown.setdefault(name, f"the poses of {letter} do not determine it")
    by_frames = _fixed_by_frames(both)
    for i, name in enumerate(names):
        for k, letter in enumerate("AB"):
            if not present[k, i]:
                unknown[name] = f"{letter} was calibrated without this effect"
            elif free[1 - k, i] and not free[k, i] and name not in by_frames:
                unknown.setdefault(name, f"it was fixed in {letter}")
        if not free[:, i].any() and value[0, i] != value[1, i]:
            unknown.setdefault(name, "it was fixed in both, at different values")
    return {name: reason for name, reason in unknown.items() if name in names}


def _only_in(
    names: list[str], free: Array, present: Array, by_frames: set[str]
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the names of the parameters that only A estimated or contains, and of those that only B does; arguments as in ``_unknown``."""
    by_choice = np.array([name in by_frames for name in names], dtype=bool)
    one, other = (
        (present[k] & ~present[1 - k]) | (free[k] & ~free[1 - k] & ~by_choice) for k in range(len(free))
    )
    return tuple(np.array(names)[one].tolist()), tuple(np.array(names)[other].tolist())


def _fixed_by_frames(both: tuple[Calibration, Calibration]) -> set[str]:
    """Return the names of the parameters that either calibration fixed by the choice of a frame."""
    return {entry["held"] for c in both for entry in c.gauge if entry.get("cause") == _STRUCTURAL}


def _geometry_columns(model: Model) -> dict[tuple[str, ...], int]:
    """Return the position of every geometric parameter in the vector of a model."""
    names = model.robot.parameter_names
    return {(name,): model.names.index(name) for name in names}


def effects_of_the_arm(model: Model) -> tuple[Effect, ...]:
    """Return the effects of a model that another campaign with the same arm would show as well."""
    return tuple(effect for effect in model.effects if effect.stays_with_arm)


def effect_terms(model: Model, chosen: Sequence[Effect] | None = None) -> dict[tuple[str, ...], int]:
    """Return the position of each term of the arm's effects in the vector of a model, by the identity that ``_terms`` gives.

    Args:
        model: With the effects.
        chosen: Those of its effects that are wanted; None for all.
    """
    columns: dict[tuple[str, ...], int] = {}
    for effect, names in zip(model.effects, model.effect_names, strict=True):
        if effect.stays_with_arm and (chosen is None or any(effect is one for one in chosen)):
            for term, name in zip(_terms(effect), names, strict=True):
                columns.setdefault(term, model.names.index(name))
    return columns


def _terms(effect: Effect) -> list[tuple[str, ...]]:
    """Return the identity of every coefficient of an effect: the effect's name, target and settings without lists of terms, and the term."""

    def without_terms(mapping: dict[str, Any]) -> str:
        return json.dumps({k: v for k, v in mapping.items() if k not in _TERMS}, sort_keys=True, default=str)

    target, settings = without_terms(effect.target), without_terms(effect.to_mapping())
    return [(effect.name, target, settings, term) for term in effect.term_names]
