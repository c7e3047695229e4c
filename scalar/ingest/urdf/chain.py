"""The joints between two links of a robot description, from the base to the tip.

Joints and links outside the chain (grippers, cameras) are ignored, but all links have to form a tree.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from scalar.data.description import MAX_JOINTS
from scalar.data.located_table import NUMBER, did_you_mean, shorten
from scalar.data.unit_suspicions import MAX_BASE
from scalar.errors import Fault, InvalidInput
from scalar.geometry.robot import DEFAULT_LIMIT, DEFAULT_TRAVEL
from scalar.geometry.roll_pitch_yaw import rotation_from_rpy
from scalar.geometry.se3 import Array, inverse, transform
from scalar.ingest.urdf.document import UrdfDocument

TURNING = ("revolute", "continuous")
SLIDING = "prismatic"
LEAST_AXIS = 1e-6
"""Shortest axis that counts as having a direction; descriptions write axes of length one."""


@dataclass(frozen=True, eq=False)
class ChainJoint:
    """One joint of a chain, ``T_parent_child = T_origin Rot(axis, q)``, or ``T_origin Trans(axis q)`` where it slides.

    Attributes:
        name: Name of the joint.
        child: Name of the link that it carries.
        moves: Whether it is revolute, continuous or prismatic; else it is fixed.
        slides: Whether it is prismatic.
        T_origin: ``(4, 4)``, the child's frame in the parent's frame at q = 0.
        axis: ``(3,)``, of unit length, in the child's frame.
        limits: ``(lowest, highest)`` [rad; m where it slides].
        states_limits: Whether the description states them; else they are assumed.
        element: The element ``<joint>`` of the description.
    """

    name: str
    child: str
    moves: bool
    slides: bool
    T_origin: Array
    axis: Array
    limits: tuple[float, float]
    states_limits: bool
    element: Any


@dataclass(frozen=True, eq=False)
class Chain:
    """The joints from a base link to a tip link, fixed ones included.

    Attributes:
        base, tip: Names of the links.
        joints: In order from the base.
        T_start: ``(4, 4)``, the frame of the first joint's parent in the base's frame. It is the identity unless the base is a link that is not
            in the chain but fixed to its first link.
    """

    base: str
    tip: str
    joints: tuple[ChainJoint, ...]
    T_start: Array

    @property
    def moving(self) -> list[ChainJoint]:
        """Return the joints that turn or slide, in order from the base."""
        return [joint for joint in self.joints if joint.moves]


def chain_between(
    document: UrdfDocument, base: str | None = None, tip: str | None = None, *, may_be_fixed: bool = False
) -> Chain:
    """Return the chain from a base link to a tip link.

    Args:
        document: The description.
        base: Name of the link at the base; None for the root.
        tip: Name of the link at the tip; None for the only link without a child.
        may_be_fixed: Whether a chain without a moving joint is accepted.

    Raises:
        InvalidInput: A link is missing, the links make no tree, no chain leads from base to tip, or one of its joints cannot
            be calibrated.
    """
    links = document.named("link")
    by_child = _tree(document, links)
    base = (
        _existing(document, links, base, "--base")
        if base is not None
        else _only_root(document, links, by_child)
    )
    tip = (
        _existing(document, links, tip, "--tip")
        if tip is not None
        else _only_leaf(document, links, by_child, base)
    )
    start, T_start = _carrier(document, by_child, base, tip)
    elements: list[Any] = []
    link = tip
    while link != start:
        elements.append(by_child[link])
        link = _link_of(document, by_child[link], "parent")
    joints = tuple(_joint(document, element) for element in reversed(elements))
    n = sum(joint.moves for joint in joints)
    if not (0 if may_be_fixed else 1) <= n <= MAX_JOINTS:
        message = f"{n} joints move between {shorten(base)} and {shorten(tip)}; choose --base and --tip with 1 to {MAX_JOINTS}"
        raise InvalidInput(Fault(document.file, message))
    return Chain(base, tip, joints, T_start)


def _carrier(document: UrdfDocument, by_child: dict[str, Any], base: str, tip: str) -> tuple[str, Array]:
    """Return the link that carries the tip and to which the base is fixed, and its frame in the base's frame ``(4, 4)``.

    It is the base itself, unless the base is not in the chain but only fixed to it, like the link ``base`` of Universal Robots' arms.
    """
    link, T_link_base = base, np.eye(4)
    while not _is_above(by_child, link, tip):
        above = by_child.get(link)
        if above is None or above.get("type") != "fixed":
            exchanged = _is_above(by_child, tip, base)
            hint = "exchange --base and --tip" if exchanged else "choose a --tip that the --base carries"
            message = f"no chain leads from the link {shorten(base)} to {shorten(tip)}; {hint}"
            raise InvalidInput(Fault(document.file, message))
        T_link_base = _joint(document, above).T_origin @ T_link_base
        link = _link_of(document, above, "parent")
    return link, inverse(T_link_base)


def _tree(document: UrdfDocument, links: dict[str, Any]) -> dict[str, Any]:
    """Return the joint above every link that has one."""
    by_child: dict[str, Any] = {}
    for name, element in document.named("joint").items():
        for end in ("parent", "child"):
            link = _link_of(document, element, end)
            if link not in links:
                hint = did_you_mean(link, list(links))
                message = f"the {end} of joint {shorten(name)} is {shorten(link)}, and there is no such link; {hint}correct it"
                raise document.refusal(element, message)
        child = _link_of(document, element, "child")
        if child in by_child:
            other = by_child[child].get("name")
            message = (
                f"the link {shorten(child)} is the child of joint {shorten(other)} and of {shorten(name)}: a closed loop, "
                "which is no serial chain; remove one of the two joints"
            )
            raise document.refusal(element, message)
        by_child[child] = element
    sound: set[str] = set()  # links from which the chain of parents is known to end
    for start in by_child:
        above: set[str] = set()
        link = start
        while link in by_child and link not in sound:
            if link in above:
                message = f"the link {shorten(link)} is above itself: a closed loop, which is no serial chain; correct the parents"
                raise document.refusal(by_child[link], message)
            above.add(link)
            link = _link_of(document, by_child[link], "parent")
        sound |= above
    return by_child


def _link_of(document: UrdfDocument, element: Any, end: str) -> str:
    """Return the name of the link at one end of a joint, ``parent`` or ``child``."""
    found = element.find(end)
    link = None if found is None else found.get("link")
    if not link:
        message = f'joint {shorten(element.get("name"))} has no {end}; write <{end} link="name"/>'
        raise document.refusal(element, message)
    return str(link)


def _existing(document: UrdfDocument, links: dict[str, Any], name: str, option: str) -> str:
    """Return the name of a link that an option gives, if there is such a link."""
    if name not in links:
        hint = did_you_mean(name, list(links)) or f"the links are {_few(list(links))}; "
        raise InvalidInput(Fault(document.file, f"no link is called {shorten(name)}; {hint}correct {option}"))
    return name


def _only_root(document: UrdfDocument, links: dict[str, Any], by_child: dict[str, Any]) -> str:
    """Return the one link that has no parent."""
    roots = [name for name in links if name not in by_child]
    if len(roots) != 1:
        message = f"{len(roots)} links have no parent ({_few(roots)}); choose one with --base"
        raise InvalidInput(Fault(document.file, message))
    return roots[0]


def _only_leaf(document: UrdfDocument, links: dict[str, Any], by_child: dict[str, Any], base: str) -> str:
    """Return the one link below the base that has no child."""
    parents = {_link_of(document, element, "parent") for element in by_child.values()}
    leaves = [name for name in links if name not in parents and _is_above(by_child, base, name)]
    if len(leaves) != 1:
        message = f"the chain from {shorten(base)} ends in {len(leaves)} links ({_few(leaves)}); choose one with --tip"
        raise InvalidInput(Fault(document.file, message))
    return leaves[0]


def _is_above(by_child: dict[str, Any], upper: str, lower: str) -> bool:
    while lower != upper and lower in by_child:
        lower = by_child[lower].find("parent").get("link")
    return lower == upper


def _few(names: list[str]) -> str:
    shown = ", ".join(shorten(name) for name in names[:8])
    return f"{shown} and {len(names) - 8} more" if len(names) > 8 else shown


def _joint(document: UrdfDocument, element: Any) -> ChainJoint:
    """Return the joint of an element of the document, in metres and radians."""
    name, kind = str(element.get("name")), element.get("type")
    called = f"joint {shorten(name)}"
    if kind not in (*TURNING, SLIDING, "fixed"):
        what = f"is {kind}" if kind in ("planar", "floating") else f"has the unknown type {shorten(kind)}"
        message = (
            f"{called} {what}; the joints of a chain have to be revolute, continuous, prismatic or fixed: "
            "choose --base and --tip without it"
        )
        raise document.refusal(element, message)
    slides = kind == SLIDING
    moves = slides or kind in TURNING
    mimic = element.find("mimic")
    if moves and mimic is not None:
        message = f"{called} mimics {shorten(mimic.get('joint'))} and has no position of its own; choose --base and --tip without it"
        raise document.refusal(element, message)
    origin, axis = element.find("origin"), element.find("axis")
    xyz = _vector(document, origin, "xyz", called) if origin is not None else np.zeros(3)
    rpy = _vector(document, origin, "rpy", called) if origin is not None else np.zeros(3)
    if np.max(np.abs(xyz)) > MAX_BASE:
        message = (
            f"{called} is {np.max(np.abs(xyz)):g} m from its parent; are these millimetres? write metres"
        )
        raise document.refusal(origin, message)
    direction = np.array([1.0, 0.0, 0.0])  # the default of the format
    if moves and axis is not None:
        direction = _vector(document, axis, "xyz", called, default=direction)
        direction = direction / max(np.max(np.abs(direction)), 1.0)  # so that the length does not overflow
        length = float(np.linalg.norm(direction))
        if not length > LEAST_AXIS:
            raise document.refusal(axis, f"the axis of {called} has no direction; write it as in 0 0 1")
        direction = direction / length
    default, unit = (DEFAULT_TRAVEL, "m") if slides else (DEFAULT_LIMIT, "rad")
    states_limits = moves and kind != "continuous" and element.find("limit") is not None
    limits = _limits(document, element, called, unit) if states_limits else (-default, default)
    child = _link_of(document, element, "child")
    T_origin = transform(rotation_from_rpy(rpy), xyz)
    return ChainJoint(name, child, moves, slides, T_origin, direction, limits, states_limits, element)


def _limits(document: UrdfDocument, element: Any, called: str, unit: str) -> tuple[float, float]:
    """Return the limits of a joint, in the unit that is given for the message."""
    limit = element.find("limit")
    low, high = (
        _numbers(document, limit, key, called, limit.get(key, "0"), 1)[0] for key in ("lower", "upper")
    )
    if not low < high:
        message = f"the limits of {called} are {low:g} and {high:g} {unit}; write lower below upper, or make the joint fixed"
        raise document.refusal(limit, message)
    return float(low), float(high)


def _vector(
    document: UrdfDocument, element: Any, key: str, called: str, default: Array | None = None
) -> Array:
    """Return the three numbers ``(3,)`` of an attribute; the default, or zeros, if it is absent."""
    text = element.get(key)
    if text is None:
        return np.zeros(3) if default is None else default
    return _numbers(document, element, key, called, text, 3)


def _numbers(document: UrdfDocument, element: Any, key: str, called: str, text: str, size: int) -> Array:
    """Return so many finite numbers ``(size,)`` as the text of an attribute holds."""
    words = text.split()
    if (
        len(words) != size
        or not all(NUMBER.fullmatch(word) for word in words)
        or not np.all(np.isfinite([float(w) for w in words]))
    ):
        form = "a number" if size == 1 else "three numbers"
        message = f"{key} of <{element.tag}> in {called} is {shorten(text)}; write {form}"
        raise document.refusal(element, message)
    return np.array([float(word) for word in words])
