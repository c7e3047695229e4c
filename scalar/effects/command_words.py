"""Read the words that follow an effect's name on a command line: joints, orders of a series, planes, the pose at which a change begins."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset


def joints_named(dataset: Dataset, words: Sequence[str]) -> list[int]:
    """Return the joint that the first word names, or all joints where there is no word.

    Raises:
        ValueError: The robot has no such joint.
    """
    n = dataset.robot.n_joints
    if not words:
        return list(range(1, n + 1))
    if not words[0].isdecimal() or not 1 <= int(words[0]) <= n:
        raise ValueError(f"'{words[0]}' is no joint; this robot has joints 1 to {n}")
    return [int(words[0])]


def turning_named(dataset: Dataset, words: Sequence[str]) -> list[int]:
    """Return the joint that the first word names, or all joints that turn where there is no word.

    Raises:
        ValueError: The robot has no such joint, or it slides.
    """
    slides = dataset.robot.slides
    if not words:
        return [j for j in joints_named(dataset, words) if not slides[j - 1]]
    named = joints_named(dataset, words)
    if slides[named[0] - 1]:
        raise ValueError(f"joint {named[0]} slides, and this effect is one of joints that turn")
    return named


def all_turning_named(dataset: Dataset, words: Sequence[str]) -> tuple[int, ...]:
    """Return the joints that the words name, ascending, or all joints that turn where there is no word.

    Raises:
        ValueError: The robot has no such joint, or it slides.
    """
    if not words:
        return tuple(turning_named(dataset, words))
    return tuple(sorted({joint for word in words for joint in turning_named(dataset, [word])}))


def orders_named(words: Sequence[str], first: int, last: int) -> tuple[int, ...]:
    """Return the orders of a series that words name, ascending.

    Raises:
        ValueError: A word is no order between the first and the last.
    """
    wrong = [word for word in words if not word.isdecimal() or not first <= int(word) <= last]
    if wrong:
        raise ValueError(f"'{wrong[0]}' is no order; there are orders {first} to {last}")
    return tuple(sorted({int(word) for word in words}))


def start_named(word: str) -> float:
    """Return the order of acquisition at which a change begins, as a word states it.

    Raises:
        ValueError: It is no finite number.
    """
    try:
        value = float(word)
    except ValueError:
        value = np.nan
    if not np.isfinite(value):
        raise ValueError(f"'{word}' is no order of acquisition; say from which pose on, as a number")
    return value


def planes_named(dataset: Dataset, words: Sequence[str]) -> list[str]:
    """Return the plane that the first word names, or all planes where there is no word.

    Raises:
        ValueError: The dataset has no such plane, or none at all.
    """
    names = [plane.name for plane in dataset.planes]
    if not names:
        raise ValueError(f"this effect needs target planes, and a {dataset.sensor.kind} measures none")
    if not words:
        return names
    if words[0] not in names:
        raise ValueError(f"no plane '{words[0]}'; there are {', '.join(names)}")
    return [words[0]]
