"""The library of arms: ``arms/<name>.yaml``, each with Denavit-Hartenberg parameters, joint limits and the sources of its numbers.

An arm is *verified* where two published sources, of different authors or in different documents of the maker, give the same position
of the flange in random postures, to the length that its file states. Otherwise it is *unverified*, and its note says why.
The files hold no masses, and no deviations of single arms from their data sheets, which are what a calibration finds.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache, cached_property, lru_cache
from importlib import resources
from typing import Any

from scalar.data.io.plain_yaml import load_yaml
from scalar.errors import Fault, InvalidInput
from scalar.geometry.robot import Robot

VERIFIED, UNVERIFIED = "verified", "unverified"
_MOST_SUGGESTIONS = 5
"""Most names in a suggestion, so that they fit in a line."""
_LEAST_NAME = 4
"""Fewest letters and digits of a user's name that may be a part of the library's: shorter ones, such as `kr6`, are shared by several models."""
_LEAST_SIMILARITY = 0.5
"""Least similarity (``difflib`` ratio, 0 to 1) of a name that is suggested. With it, 'kuka kr6' finds the KR 6 arms, and 'toaster' finds none."""


@dataclass(frozen=True)
class LibraryArm:
    """An arm of the library.

    Attributes:
        name: Name in the library.
        maker: Name of the maker.
        model: The maker's name of the arm.
        verified: Whether two sources agree.
        agreement: Most by which the flange's position differs between the sources [m]; None for an unverified arm.
        sources: Sources of the geometry; the numbers were taken from the first.
        limits_source: Source of the joint limits.
        reach: Largest distance of ``reach_at`` from axis 1, as the maker states it [m].
        reach_at: The point whose reach that is: ``wrist centre`` (the origin of the last frame but one) or ``flange``.
        reach_tolerance: Most by which the reach of this geometry may differ from the stated one [m].
        payload: Rated payload [kg] as the name of the model states it; None if the name does not.
        note: What a user of the arm should know; empty where there is nothing.
        controller_joints: How the joints follow from those that the maker's controller shows, as in ``q3 = J3 + J2``; empty where they are the same.
        axis_names: The maker's name of the axis of each joint, as in ``S, L, U, R, B, T``; empty where no source states them.
        axis_names_source: Where these names stand.
        mapping: The ``robot:`` block of a dataset.
    """

    name: str
    maker: str
    model: str
    verified: bool
    agreement: float | None
    sources: tuple[str, ...]
    limits_source: str
    reach: float
    reach_at: str
    reach_tolerance: float
    payload: float | None
    note: str
    controller_joints: str
    axis_names: tuple[str, ...]
    axis_names_source: str
    mapping: Mapping[str, Any]

    @cached_property
    def robot(self) -> Robot:
        """Return the arm as a robot."""
        return Robot.from_mapping(self.mapping)


def arm_names() -> list[str]:
    """Return the names of all arms, sorted."""
    folder = resources.files("scalar.robots").joinpath("arms")
    return sorted(
        entry.name.removesuffix(".yaml") for entry in folder.iterdir() if entry.name.endswith(".yaml")
    )


def read_arm(name: str) -> LibraryArm:
    """Return the arm of a name, of a model, or of a maker and model; case, blanks and punctuation do not matter.

    Raises:
        InvalidInput: The library has no arm of this name; the message suggests similar names.
    """
    if not has_arm(name):
        raise InvalidInput(Fault("--robot", _unknown(name)))
    return _read(_own_names()[_plain(name)])


def has_arm(name: str) -> bool:
    """Return whether the library has an arm of a name, as ``read_arm`` takes it."""
    return _plain(name) in _own_names()


@lru_cache(maxsize=16)  # a calibration asks twice for the name of its arm
def resembling(name: str) -> tuple[LibraryArm, ...]:
    """Return the arms whose name in the library resembles the name that a user gave an arm; none if that name says nothing of the model.

    All words of one name have to stand in the other one after the other, where the library's may lack the maker, and one of them has to have a digit:
    `my UR5e` resembles ur5e, and `kr6 r900` two arms of KUKA; `irb 1200` is no irb120.
    """
    wanted = _plain(name)
    models = {own: _words(own.partition("_")[2] or own) for own in arm_names()}
    exact = [own for own in models if wanted and wanted in (_plain(own), _plain(own.partition("_")[2]))]
    given = _words(name)
    parts = [own for own in models if len(wanted) >= _LEAST_NAME and _stands_in(given, _words(own))]
    contained = {own: len(model) for own, model in models.items() if _stands_in(model, given)}
    longest = [own for own, length in contained.items() if length == max(contained.values())]
    return tuple(_read(own) for own in exact or parts or longest)


def _words(name: str) -> list[str]:
    """Return the words of a name in small letters; a number belongs to the letters before it, whatever separates them (`KR 6` is `kr6`)."""
    return re.findall(r"[a-z0-9]+", re.sub(r"(?<=[a-z])[^a-z0-9]+(?=[0-9])", "", name.lower()))


def _stands_in(some: list[str], words: list[str]) -> bool:
    """Return whether some words, one of them with a digit, stand among others one after the other."""
    n = len(some)
    has_digit = any(character.isdigit() for word in some for character in word)
    return has_digit and any(words[k : k + n] == some for k in range(len(words) - n + 1))


def largest_payload(name: str) -> float | None:
    """Return the largest rated payload [kg] of the arms whose name resembles one that a user gave; None if one of their names does not state it."""
    stated = [arm.payload for arm in resembling(name)]
    known = [payload for payload in stated if payload is not None]
    return max(known) if known and len(known) == len(stated) else None


@cache
def _read(name: str) -> LibraryArm:
    file = resources.files("scalar.robots").joinpath("arms", f"{name}.yaml")
    with resources.as_file(file) as path:
        content = load_yaml(path)
    reach = content["reach"]
    return LibraryArm(
        name=name,
        maker=content["maker"],
        model=str(content["model"]),
        verified=content["status"] == VERIFIED,
        agreement=content.get("agreement"),
        sources=tuple(content["sources"]),
        limits_source=content["limits_source"],
        reach=reach["stated"],
        reach_at=reach["at"],
        reach_tolerance=reach["tolerance"],
        payload=content.get("payload"),
        note=content.get("note", "").strip(),
        controller_joints=content.get("controller_joints", ""),
        axis_names=tuple(content.get("axis_names", ())),
        axis_names_source=content.get("axis_names_source", ""),
        mapping=content["robot"],
    )


def _keys() -> dict[str, tuple[str, ...]]:
    """Return what each arm may be called: its name, its model, and its maker with its model."""
    arms = {name: _read(name) for name in arm_names()}
    return {name: (name, arm.model, f"{arm.maker} {arm.model}") for name, arm in arms.items()}


@cache
def _own_names() -> dict[str, str]:
    """Return the name of the arm that each key of ``_keys`` calls, all keys in plain letters."""
    return {_plain(key): own for own, keys in _keys().items() for key in keys}


def _plain(name: str) -> str:
    return re.sub(r"[\W_]+", "", name).casefold()


def similar_names(name: str) -> list[str]:
    """Return the names in the library that resemble a name which it does not have, the most similar first; few, or none."""
    wanted = _plain(name)
    plain = {own: [_plain(key) for key in keys] for own, keys in _keys().items()}
    similarity = {
        own: max(difflib.SequenceMatcher(None, wanted, key).ratio() for key in keys)
        for own, keys in plain.items()
    }
    close = [own for own, keys in plain.items() if any(wanted in key for key in keys)] if wanted else []
    close = close or [own for own, ratio in similarity.items() if ratio >= _LEAST_SIMILARITY]
    close.sort(key=lambda own: (-similarity[own], own))
    return close[:_MOST_SUGGESTIONS]


def _unknown(name: str) -> str:
    """Return the message for a name that the library does not have."""
    listed = ", ".join(similar_names(name))
    suggestion = f"did you mean {listed}? " if listed else ""
    return f"{name!r} is no arm of the library; {suggestion}`scalar init --list` lists all arms; describe any other by --urdf or --dh"
