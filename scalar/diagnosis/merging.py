"""When two effects are one: terms that merge, and answers that would be reported as the same."""

from __future__ import annotations

from collections.abc import Sequence

from scalar.effects.base import BaseCompliance
from scalar.effects.effect import Effect
from scalar.effects.joints import JointCompliance, JointHarmonic
from scalar.effects.sensor import SensorSlip
from scalar.effects.surface import PlaneMoved


def merged(effects: Sequence[Effect], new: Effect) -> tuple[Effect, ...]:
    """Return effects with a new one: terms of the same compliance and orders of the same joint become one effect."""
    result = list(effects)
    for i, old in enumerate(result):
        if (
            isinstance(old, JointHarmonic)
            and isinstance(new, JointHarmonic)
            and type(old) is type(new)
            and old.joint == new.joint
        ):
            result[i] = _with_known(type(old)(old.joint, tuple(sorted({*old.orders, *new.orders}))), old)
            return tuple(result)
        if isinstance(old, JointCompliance) and isinstance(new, JointCompliance):
            result[i] = _with_known(JointCompliance(tuple(sorted({*old.terms, *new.terms}))), old)
            return tuple(result)
        if isinstance(old, BaseCompliance) and isinstance(new, BaseCompliance):
            frames = tuple(sorted({*old.frames, *new.frames}))
            result[i] = _with_known(BaseCompliance(frames, old.alike and new.alike), old)
            return tuple(result)
    return (*result, new)


def _with_known(effect: Effect, old: Effect) -> Effect:
    known = dict(zip(_full_names(old), old.coefficients, strict=True))
    return effect.with_coefficients([known.get(name, 0.0) for name in _full_names(effect)])


def _full_names(effect: Effect) -> list[str]:
    if isinstance(effect, JointHarmonic):
        return [f"{f}{k}" for k in effect.orders for f in ("sin", "cos")]
    return effect.coefficient_names


def label(effect: Effect) -> str:
    """Return name and target as one text; the same for effects that would be reported as the same."""
    if isinstance(effect, (JointCompliance, BaseCompliance)):
        return effect.name
    if isinstance(effect, (SensorSlip, PlaneMoved)):
        return effect.key
    return f"{effect.name} {effect.target}"


def same_place(a: Effect, b: Effect) -> bool:
    """Return whether two effects are the same but for their terms: orders of one joint, frames of a compliance, nearby moments."""
    if type(a) is not type(b):
        return False
    if (
        isinstance(a, JointHarmonic)
        and isinstance(b, JointHarmonic)
        and min(len(a.orders), len(b.orders)) > 1
    ):
        return a.joint == b.joint
    if isinstance(a, PlaneMoved) and isinstance(b, PlaneMoved):
        return a.plane == b.plane
    return isinstance(a, (SensorSlip, BaseCompliance, JointCompliance)) or label(a) == label(b)


def same_answer(a: Effect, b: Effect) -> bool:
    """Return whether two effects say the same but for details: the same place, or orders of one joint that overlap."""
    if isinstance(a, JointHarmonic) and isinstance(b, JointHarmonic) and a.joint == b.joint:
        return bool(set(a.orders) & set(b.orders))
    return same_place(a, b)
