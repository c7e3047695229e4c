"""How a sound campaign is spoiled: one thing about its set-up is made wrong, and what has to be named is noted."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from scalar.robots import arm_names, arms_with_axes_of, read_arm
from scalar.units import DEG
from study.spoiled_setups.campaign import MODIFIED, STANDARD, Campaign, flange_frames
from study.spoiled_setups.workcell import Workcell

LEAST_ZERO, MOST_ZERO = 10.0, 180.0  # degrees
INCH = 25.4  # mm
GRAD = 0.9 * DEG
ANGLE_UNITS = {
    "degrees": (1 / DEG, "degrees"),
    "grads": (1 / GRAD, "grads"),
    "radians taken for degrees": (DEG, "radians"),
    "grads taken for degrees": (DEG / GRAD, "grads"),
    "degrees taken for grads": (GRAD / DEG, "degrees"),
}
"""``{how the angles are written: (factor, word that the right sentence contains)}``."""
FARTHEST = 5  # rows by which rows are shifted


@dataclass(frozen=True)
class Truth:
    """What has to be named.

    Attributes:
        whats: Values of ``Suspicion.what`` that are right.
        where: Value of ``Suspicion.where``; empty: any.
        words: Words of which one has to stand in the sentence; none: any sentence will do.
        arms: Names of the library of which one has to stand in the sentence, if it names any.
    """

    whats: tuple[str, ...]
    where: str = ""
    words: tuple[str, ...] = ()
    arms: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class Spoiled:
    """A campaign with one thing wrong.

    Attributes:
        campaign: As its files have it.
        done: What was done, in words.
        truth: What has to be named.
        right, wrong: Frames of the flange ``(N, 4, 4)`` of the true arm at the measured poses, and by the wrong description of the true arm; None
            where it is the measurements that are wrong, and no move of base or sensor can undo it.
    """

    campaign: Campaign
    done: str
    truth: Truth
    right: np.ndarray | None = None
    wrong: np.ndarray | None = None


def spoil(kind: str, workcell: Workcell, rng: np.random.Generator) -> Spoiled:
    """Return the campaign of a workcell, spoiled in a way that is drawn among those of a kind (a key of ``SPOILINGS``)."""
    return SPOILINGS[kind](workcell, rng)


def _with_angles(workcell: Workcell, q: np.ndarray, done: str, truth: Truth) -> Spoiled:
    """Return a campaign with wrong joint angles ``(N, n)``."""
    sound, robot = workcell.campaign, workcell.true_robot
    frames = flange_frames(robot, sound.q), flange_frames(robot, q)
    return Spoiled(replace(sound, q=q), done, truth, *frames)


def _joint_sign(workcell: Workcell, rng: np.random.Generator) -> Spoiled:
    q = workcell.campaign.q.copy()
    j = int(rng.integers(q.shape[1]))
    q[:, j] = -q[:, j]
    return _with_angles(workcell, q, f"q{j + 1} counts back", Truth(("joint_sign",), f"joint {j + 1}"))


def _joint_zero(workcell: Workcell, rng: np.random.Generator) -> Spoiled:
    q = workcell.campaign.q.copy()
    j = int(rng.integers(q.shape[1]))
    off = float(rng.uniform(LEAST_ZERO, MOST_ZERO) * rng.choice([-1, 1]))
    q[:, j] += off * DEG
    truth = Truth(("joint_zero",), f"joint {j + 1}")
    return _with_angles(workcell, q, f"q{j + 1} is {off:.1f} degrees too large", truth)


def _convention(workcell: Workcell, rng: np.random.Generator) -> Spoiled:
    del rng
    sound, true = workcell.campaign, workcell.true_robot
    other = {STANDARD: MODIFIED, MODIFIED: STANDARD}[true["convention"]]
    wrong = flange_frames({**true, "convention": other}, sound.q)
    robot = {**sound.robot, "convention": other}
    return Spoiled(
        replace(sound, robot=robot), f"the table is {true['convention']} and called {other}",
        Truth(("convention",)), flange_frames(true, sound.q), wrong,
    )  # fmt: skip


def _angle_unit(workcell: Workcell, rng: np.random.Generator) -> Spoiled:
    name = str(rng.choice(list(ANGLE_UNITS)))
    factor, word = ANGLE_UNITS[name]
    return _with_angles(
        workcell, workcell.campaign.q * factor, name, Truth(("angle_unit",), "poses.csv", (word,))
    )


def _length_unit(workcell: Workcell, rng: np.random.Generator) -> Spoiled:
    small = bool(rng.integers(2))
    factor = 1 / INCH if small else INCH
    points = tuple(points * factor for points in workcell.campaign.points)
    done = "inches taken for millimetres" if small else "millimetres taken for inches"
    return Spoiled(
        replace(workcell.campaign, points=points), done, Truth(("length_unit",), words=("inches",))
    )


def _mirrored(workcell: Workcell, rng: np.random.Generator) -> Spoiled:
    how = np.eye(3)
    kept = int(rng.integers(3))
    if rng.integers(2):
        how[kept, kept] = -1.0
        done = f"{'xyz'[kept]} counts back"
    else:
        first, second = (k for k in range(3) if k != kept)
        how[[first, second]] = how[[second, first]]
        done = f"{'xyz'[first]} and {'xyz'[second]} are exchanged"
    points = tuple(points @ how for points in workcell.campaign.points)
    return Spoiled(replace(workcell.campaign, points=points), done, Truth(("mirrored",)))


def _swapped_labels(workcell: Workcell, rng: np.random.Generator) -> Spoiled:
    names = [plane["name"] for plane in workcell.campaign.planes]
    a, b = sorted(rng.choice(len(names), 2, replace=False))
    other = {names[a]: names[b], names[b]: names[a]}
    labels = tuple(other.get(name, name) for name in workcell.campaign.labels)
    where = f"planes {names[a]} and {names[b]}"
    return Spoiled(
        replace(workcell.campaign, labels=labels),
        f"{where} are exchanged",
        Truth(("swapped_planes",), where),
    )


def _swapped_joints(workcell: Workcell, rng: np.random.Generator) -> Spoiled:
    q = workcell.campaign.q.copy()
    i, j = sorted(rng.choice(q.shape[1], 2, replace=False))
    q[:, [i, j]] = q[:, [j, i]]
    where = f"joints {i + 1} and {j + 1}"
    return _with_angles(
        workcell, q, f"q{i + 1} and q{j + 1} are exchanged", Truth(("swapped_joints",), where)
    )


def _shifted_rows(workcell: Workcell, rng: np.random.Generator) -> Spoiled:
    return _shifted(workcell, int(rng.integers(2, FARTHEST + 1) * rng.choice([-1, 1])), rng)


def _off_by_one(workcell: Workcell, rng: np.random.Generator) -> Spoiled:
    return _shifted(workcell, int(rng.choice([-1, 1])), rng)


def _shifted(workcell: Workcell, rows: int, rng: np.random.Generator) -> Spoiled:
    """Return the campaign in which each measurement stands with the angles of a pose some rows after its own; negative: before."""
    sound = workcell.campaign
    measured = np.arange(max(0, -rows), min(len(sound.q), len(sound.q) - rows))
    angles = measured + rows
    go_along = bool(rng.integers(2))
    spoiled = sound.of_rows(angles, measured, angles if go_along else measured)
    right, wrong = (flange_frames(workcell.true_robot, sound.q[index]) for index in (measured, angles))
    side = "before" if rows > 0 else "after"
    words = f"pose {side}" if abs(rows) == 1 else f"{abs(rows)} rows {side}"
    labels = ", labels as well" if sound.labels and go_along else ""
    return Spoiled(
        spoiled, f"angles moved by {rows} rows{labels}",
        Truth(("shifted_poses",), "poses.csv", (words,)), right, wrong,
    )  # fmt: skip


def _other_arm(workcell: Workcell, rng: np.random.Generator) -> Spoiled:
    sound, n = workcell.campaign, workcell.campaign.q.shape[1]
    true = workcell.true_robot["name"]
    others = [arm for arm in map(read_arm, arm_names()) if arm.robot.n_joints == n and arm.name != true]
    arm = others[int(rng.integers(len(others)))]
    block: dict[str, Any] = {
        **arm.mapping,
        "name": sound.robot["name"] if sound.robot["name"] == "arm" else arm.name,
    }
    alike = arms_with_axes_of(read_arm(true).robot)
    frames = flange_frames(workcell.true_robot, sound.q), flange_frames(block, sound.q)
    truth = Truth(("other_arm", "robot"), arms=tuple(one.name for one in alike))
    return Spoiled(replace(sound, robot=block), f"{true} with the table of {arm.name}", truth, *frames)


SPOILINGS: dict[str, Callable[[Workcell, np.random.Generator], Spoiled]] = {
    "joint_sign": _joint_sign,
    "joint_zero": _joint_zero,
    "convention": _convention,
    "angle_unit": _angle_unit,
    "length_unit": _length_unit,
    "mirrored": _mirrored,
    "swapped_labels": _swapped_labels,
    "swapped_joints": _swapped_joints,
    "shifted_rows": _shifted_rows,
    "off_by_one": _off_by_one,
    "other_arm": _other_arm,
}
"""``{kind: what spoils a workcell so}``."""
