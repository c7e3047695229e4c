"""The parameters of the arm in two calibrations: their difference, its covariance, and what one of the two does not know.

The two campaigns are independent, so the covariance of the difference is the sum of both. Sensor, planes and tracker frames belong to a
campaign; their covariance with the arm's parameters is in the marginal covariance, and they are left out otherwise.
"""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from scalar.effects.effect import Effect
from scalar.estimation.fixed_parameter import NO_LENGTH_KNOWN
from scalar.estimation.model import Model
from scalar.estimation.result import Calibration
from scalar.geometry.robot import GEOMETRY, LENGTHS
from scalar.geometry.se3 import Array

_TERMS = ("order", "orders")  # of a target or of settings: they say which terms an effect has
_STRUCTURAL = "structural"


@dataclass(frozen=True, eq=False)
class ArmParameters:
    """The arm's P parameters in two calibrations A and B.

    Attributes:
        model: The model of A with the arm's own effects, those of B that A has not with coefficients of zero.
        names: ``(P,)``, as in ``model.names``, the arm's alone.
        columns: ``(P,)``, where they stand in ``model.names``.
        units: ``(P,)``.
        difference: ``(P,)``, B minus A.
        covariance: ``(P, P)`` of the difference; zero for what was fixed in both.
        unknown: ``{name: reason}`` of the parameters that one of the two does not determine.
        fixed_in_both: ``(P,)`` bool, fixed at one value in both, and not by the choice of a frame.
        scale_unknown: Whether one of the two leaves the scale of the arm open.
        effects_differ: Whether one of the two was calibrated without an effect of the other.
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
    effects_differ: bool


def arm_parameters(a: Calibration, b: Calibration) -> ArmParameters:
    """Return the arm's parameters of two calibrations of one arm."""
    identities = [_effect_terms(calibration.model) for calibration in (a, b)]
    added = [e for e in effects_of_the_arm(b.model) if not set(_terms(e)) <= set(identities[0])]
    zero = [effect.with_coefficients(0 * effect.coefficients) for effect in added]
    union = replace(a.model, effects=(*effects_of_the_arm(a.model), *zero))
    places = _geometry_places(union) | _effect_terms(union)
    own = [_geometry_places(c.model) | terms for c, terms in zip((a, b), identities, strict=True)]
    P = len(places)
    value, covariance, known = np.zeros((2, P)), np.zeros((P, P)), np.zeros((2, P), dtype=bool)
    for k, (calibration, where) in enumerate(zip((a, b), own, strict=True)):
        vector, names = calibration.model.vector, calibration.model.names
        free = {name: i for i, name in enumerate(calibration.free)}
        here = [(i, where[key]) for i, key in enumerate(places) if key in where]
        for i, column in here:
            value[k, i] = vector[column]
            known[k, i] = names[column] in free
        estimated = [(i, free[names[column]]) for i, column in here if names[column] in free]
        at, source = (np.array(x, dtype=int) for x in zip(*estimated, strict=True))
        covariance[np.ix_(at, at)] += calibration.covariance[np.ix_(source, source)]
    names = [union.names[column] for column in places.values()]
    present = np.array([[key in where for key in places] for where in own])
    unknown = _unknown(names, known, present, value, (a, b))
    in_frames = {entry["held"] for c in (a, b) for entry in c.gauge if entry.get("cause") == _STRUCTURAL}
    return ArmParameters(
        model=union,
        names=names,
        columns=np.array(list(places.values()), dtype=int),
        units=[union.units[column] for column in places.values()],
        difference=value[1] - value[0],
        covariance=covariance,
        unknown=unknown,
        fixed_in_both=~known.any(axis=0) & np.array([name not in in_frames for name in names]),
        scale_unknown=any(entry["reason"] == NO_LENGTH_KNOWN for c in (a, b) for entry in c.gauge),
        effects_differ=not present.all(),
    )


def scale_direction(model: Model) -> Array:
    """Return by how much every geometric parameter changes ``(5 n,)`` [m] if all lengths of the arm grow in proportion."""
    lengths = np.array([[kind in LENGTHS] for kind in GEOMETRY])
    return (model.robot.geometry * lengths).ravel()


def _unknown(
    names: list[str], known: Array, present: Array, value: Array, both: tuple[Calibration, Calibration]
) -> dict[str, str]:
    """Return what cannot be compared because one of two calibrations does not determine it, with the reason."""
    unknown: dict[str, str] = {}
    for letter, calibration in zip("AB", both, strict=True):
        for entry in calibration.gauge:
            if entry.get("cause") != _STRUCTURAL:
                for name in (entry["held"], *entry["moves_with"]):
                    unknown.setdefault(name, f"the poses of {letter} do not determine it")
    in_frames = {entry["held"] for c in both for entry in c.gauge if entry.get("cause") == _STRUCTURAL}
    for i, name in enumerate(names):
        for k, letter in enumerate("AB"):
            if not present[k, i]:
                unknown[name] = f"{letter} was calibrated without this effect"
            elif known[1 - k, i] and not known[k, i] and name not in in_frames:
                unknown.setdefault(name, f"it was fixed in {letter}")
        if not known[:, i].any() and value[0, i] != value[1, i]:
            unknown.setdefault(name, "it was fixed in both, at different values")
    return {name: reason for name, reason in unknown.items() if name in names}


def _geometry_places(model: Model) -> dict[tuple[str, ...], int]:
    names = model.robot.parameter_names
    return {(name,): model.names.index(name) for name in names}


def effects_of_the_arm(model: Model) -> tuple[Effect, ...]:
    """Return the effects of a model that another campaign with the same arm would show as well."""
    return tuple(effect for effect in model.effects if effect.stays_with_arm)


def _effect_terms(model: Model) -> dict[tuple[str, ...], int]:
    """Return where each term of the effects of the arm stands in the vector of a model, by what it is."""
    where: dict[tuple[str, ...], int] = {}
    for effect, names in zip(model.effects, model.effect_names, strict=True):
        if effect.stays_with_arm:
            for term, name in zip(_terms(effect), names, strict=True):
                where.setdefault(term, model.names.index(name))
    return where


def _terms(effect: Effect) -> list[tuple[str, ...]]:
    """Return what tells every coefficient of an effect from all others: the kind, its settings without the list of terms, the term."""

    def rest(mapping: dict[str, Any]) -> str:
        return json.dumps({k: v for k, v in mapping.items() if k not in _TERMS}, sort_keys=True, default=str)

    return [(effect.name, rest(effect.target), rest(effect.to_mapping()), term) for term in effect.term_names]
