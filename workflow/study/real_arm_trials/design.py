"""The design of the real-arm trials: every effect at every size, alone and beside two others, and sets without any effect.

The sets of an instrument repeat one list of *conditions*: an effect, its size and its company, and as many times no effect as the config says. So a
longer design begins with a shorter one, and a run that was stopped goes on. Everything else of a set is drawn from the design's seed, the instrument
and the number of the set.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from study.blind_trials.stratified_design import checked_config, job_names

SCHEMA = Path(__file__).parent / "schemas/real_arm_trials.schema.json"
INSTRUMENTS = ("tracker", "rail", "scanner")
"""A tracker before an arm, a tracker before an arm on a linear axis, and a line scanner on an arm among target planes."""
SIZES = {"third": 1 / 3, "natural": 1.0, "three_times": 3.0}
"""``{level: size of the effect over its natural size}``."""
NONE = "none"  # stands for the effect of a set without effects
COMPANIONS = 2  # effects beside the one that is judged, where it is not alone
COMPANION_SIZES = (0.7, 1.5)  # their sizes over the natural ones are drawn between these
JOINTS = (1, 2, 3, 4)  # of which one is drawn for an error of one joint
COMPLIANT, SPRING_JOINTS = [2, 3], (2, 3)
ORDERS = (1, 2, 3, 5, 9, 16)  # waves a turn of a harmonic
TRAVEL_RAD, TRAVEL_M = 0.3, 0.1  # mean travel after which friction slips
SPRING = "forearm_spring"
NEEDS = {
    "torque_compliance": {"payload", "torque"},
    "payload_deflection": {"payload"},
    "restarted_warm_up": {"time"},
    "target_drift": {"time"},
}
"""``{effect: columns of poses.csv that are recorded if it is injected}``; each other column is recorded with the probability ``RECORDS``."""
COLUMNS = ("payload", "time", "torque")
RECORDS, TWO_SESSIONS, STOPS = 0.5, 0.3, 0.5
"""Probabilities of a column, of two sessions, and of two stops of half an hour; sets without effects have all of these."""
ALIKE = {"torque_compliance": "payload_deflection", "payload_deflection": "torque_compliance"}
"""``{effect: companion that it does not get}``: a payload acts in both."""


@dataclass(frozen=True)
class Trial:
    """All that the simulation of one set needs.

    Attributes:
        instrument: One of ``INSTRUMENTS``.
        number: Number of the set among those of its instrument, from 0.
        seed: Seed of the workcell, the poses and the noise.
        robot: Name of an arm, of which configs/scenes has a scene.
        poses: Number of poses.
        unseen: Number of unseen poses, over which errors are taken.
        effect: Name of the effect that is judged; ``NONE`` for none.
        size: Its level, one of ``SIZES``; ``NONE`` without one.
        company: Number of further effects in the set.
        causes: Entries of a scene's key ``injected``, the effect that is judged first. On a rail, those with ``on_rail`` act in the
            linear axis, and the joints of the others are counted without it.
        noise_m: Standard deviation of a measured coordinate, or of a range.
        states_noise: Whether the dataset states it.
        repeatability_rad: Standard deviation of each joint's angle at each pose.
        record: Columns of poses.csv that are recorded, of ``COLUMNS``.
        sessions: Number of sessions; in each the tracker has another place.
        stops: Number of stops of half an hour.
    """

    instrument: str
    number: int
    seed: int
    robot: str
    poses: int
    unseen: int
    effect: str
    size: str
    company: int
    causes: tuple[Mapping[str, Any], ...]
    noise_m: float
    states_noise: bool
    repeatability_rad: float
    record: tuple[str, ...]
    sessions: int
    stops: int


@dataclass(frozen=True)
class Design:
    """The real-arm trials of a config.

    Attributes:
        content: Content of the config.
    """

    content: Mapping[str, Any]

    def conditions(self, instrument: str) -> list[tuple[str, str, int]]:
        """Return effect, size and company of the sets of one repetition."""
        one = self.content["instruments"][instrument]
        crossed = [
            (effect, size, company)
            for effect in one["effects"]
            for size in SIZES
            for company in (0, COMPANIONS)
        ]
        return crossed + one["nulls"] * [(NONE, NONE, 0)]

    def jobs(self) -> Iterator[tuple[str, str]]:
        """Yield the instrument and the sets of each job; ``0000-0009`` are the first ten sets, as ``numbers_of`` reads it."""
        for instrument, one in self.content["instruments"].items():
            sets = one["repetitions"] * len(self.conditions(instrument))
            for job in job_names(sets, self.content["sets_per_job"]):
                yield instrument, job

    def trial(self, instrument: str, number: int, attempt: int = 0) -> Trial:
        """Return one set, drawn from the seed, its instrument, its number, and how many scenes of it could not be simulated."""
        content, one = self.content, self.content["instruments"][instrument]
        rng = np.random.default_rng([content["seed"], INSTRUMENTS.index(instrument), number, attempt])
        conditions = self.conditions(instrument)
        effect, size, company = conditions[number % len(conditions)]
        causes = self._causes(instrument, effect, size, company, rng)
        names = [effect, *(cause.get("kind", cause["effect"]) for cause in causes)]
        null, on_rail, scans = effect == NONE, instrument == "rail", instrument == "scanner"
        needed = set().union(*(NEEDS.get(name, set()) for name in names))
        possible = ("time",) if on_rail else COLUMNS
        drawn = {column for column in possible if rng.random() < RECORDS or null or column in needed}
        several = (rng.random() < TWO_SESSIONS or null) and not scans
        stands = rng.random() < STOPS or null or "restarted_warm_up" in names
        return Trial(
            instrument=instrument,
            number=number,
            seed=int(rng.integers(2**31)),
            robot=str(rng.choice(one["robots"])),
            poses=int(rng.choice(content["poses"])),
            unseen=content["unseen_poses"],
            effect=effect,
            size=size,
            company=company,
            causes=causes,
            noise_m=float(rng.choice(one["noise_m"])),
            states_noise=bool(rng.random() < content["states_noise"]),
            repeatability_rad=float(rng.choice(content["repeatability_rad"])),
            record=tuple(sorted(drawn | ({"time"} if scans else set()))),
            sessions=2 if several else 1,
            stops=2 if stands else 0,
        )

    def _causes(
        self, instrument: str, effect: str, size: str, company: int, rng: np.random.Generator
    ) -> tuple[dict[str, Any], ...]:
        """Return the effect that is judged and its companions, with drawn sizes and joints."""
        if effect == NONE:
            return ()
        one = self.content["instruments"][instrument]
        left = [name for name in one["companions"] if name not in (effect, ALIKE.get(effect))]
        others: list[str] = []
        while len(others) < company:
            others.append(str(rng.choice(left)))
            left = [name for name in left if name not in (others[-1], ALIKE.get(others[-1]))]
        sizes = [SIZES[size] * one["effects"][effect]]
        sizes += [float(rng.uniform(*COMPANION_SIZES)) * one["companions"][name] for name in others]
        names = [effect, *others]
        if instrument == "rail":
            rest = [entry_of(name, value, rng, JOINTS) for name, value in zip(others, sizes[1:], strict=True)]
            return (rail_entry(effect, sizes[0]), *rest)
        joints = list(map(int, rng.permutation(JOINTS)))
        if SPRING in names:
            joints.remove(of_spring := int(rng.choice(SPRING_JOINTS)))
        entries = []
        for name, value in zip(names, sizes, strict=True):
            joint = of_spring if name == SPRING else joints.pop()
            entries.append(entry_of(name, value, rng, [joint]))
        return tuple(entries)


def entry_of(name: str, size: float, rng: np.random.Generator, joints: Sequence[int]) -> dict[str, Any]:
    """Return an entry of a scene's key ``injected``; an error of one joint acts in one of ``joints``."""
    joint = {"joint": int(rng.choice(joints))}
    entry: dict[str, Any] = {"effect": name, "size": size}
    if name == SPRING:
        return {"effect": "unknown", "kind": SPRING, "target": joint, "size": size}
    if name in ("torque_compliance", "payload_deflection", "joint_compliance"):
        return entry | {"target": {"joints": list(COMPLIANT)}}
    if name == "joint_harmonic":
        return entry | {"target": joint | {"order": int(rng.choice(ORDERS))}}
    if name == "joint_backlash":
        return entry | {"target": joint, "by_moves": True}
    if name == "joint_hysteresis":
        return entry | {"target": joint, "travel_rad": TRAVEL_RAD}
    if name in ("pose_lag", "joint_scale"):
        return entry | {"target": joint}
    return entry


def rail_entry(name: str, size: float) -> dict[str, Any]:
    """Return an entry for the linear axis, whose size is in metres where that of a joint that turns is in radians."""
    entry = {"effect": name, "size": size, "target": {"joint": 1}, "on_rail": True}
    if name == "joint_backlash":
        return entry | {"by_moves": True}
    return entry | ({"travel_rad": TRAVEL_M} if name == "joint_hysteresis" else {})


def load_real_arm(path: str | Path) -> Design:
    """Return the design that a YAML file describes; ``extends`` is explained at ``study.blind_trials.stratified_design.checked_config``.

    Raises:
        InvalidInput: The file is at fault; every fault is listed.
    """
    return Design(checked_config(path, SCHEMA))
