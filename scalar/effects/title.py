"""The titles of effects: the place where an effect acts, then its kind, as in ``joint 4: backlash``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from scalar.data.poses import is_joint
from scalar.effects.wording import columns_in_words, listed, orders

ORDERS_IN_TITLE, ORDERS_IN_SENTENCE = 12, 3


def titled(kind: str, target: Mapping[str, Any], depends_on: Sequence[str] = ()) -> str:
    """Return the title of an effect.

    Args:
        kind: Two or three words.
        target: As ``diagnosis.json`` writes it.
        depends_on: Columns that the effect varies with; used if the target states no place.
    """
    if "joints" in target:
        return f"{joints_in_words(target['joints'])}: {kind}"
    if "source" in target:
        return f"joint {target['joint']}: {kind} from joint {target['source']}"
    if "orders" in target:
        return f"joint {target['joint']}: {kind}, {orders(target['orders'], ORDERS_IN_TITLE)}"
    if "order" in target and "joint" in target:
        return f"joint {target['joint']}: {kind}, order {target['order']}"
    if "joint" in target:
        return f"joint {target['joint']}: {kind}"
    if "plane" in target:
        return f"target plane {target['plane']}: {kind}{_since(target)}"
    if depends_on:
        return f"{kind}, varying with {columns_in_words(depends_on)}"
    return f"{kind}{_since(target)}"


def joints_of(target: Mapping[str, Any]) -> list[int]:
    """Return the numbers of the joints that a target names, from 1."""
    return [*target.get("joints", ()), *(target[key] for key in ("joint", "source") if key in target)]


def only_joint(target: Mapping[str, Any], depends_on: Sequence[str] = ()) -> int | None:
    """Return the joint, from 1, of which an effect is an error or with whose position it varies; None if it concerns none or several.

    Args:
        target: As ``diagnosis.json`` writes it.
        depends_on: Columns that the effect varies with.
    """
    joints = {*joints_of(target), *(int(name[1:]) for name in depends_on if is_joint(name))}
    return joints.pop() if len(joints) == 1 else None


def joints_in_words(joints: Sequence[int]) -> str:
    """Return ``joint 2`` or ``joints 2 and 3``."""
    return f"joint{'s' if len(joints) > 1 else ''} {listed([str(j) for j in joints])}"


def _since(target: Mapping[str, Any]) -> str:
    at = target.get("at")
    return f", from order {at['order']:.0f} on" if at and at.get("order") is not None else ""
