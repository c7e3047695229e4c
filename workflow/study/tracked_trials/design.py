"""The design of the tracked trials: what is drawn for each set from the design's seed, the kind of sensor and the set's number.

The levels at which the noise is stated are taken in turn, so that every kind of sensor has each level equally often; everything else is drawn. The
first sets of a longer design are those of a shorter one.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from study.blind_trials.stratified_design import checked_config, job_names
from study.tracked_trials.workcell import Workcell, load_workcell

SCHEMA = Path(__file__).parent / "schemas/tracked_trials.schema.json"
SENSORS = ("tracker", "targets", "probe")
STATED = {"right": 1.0, "fifth": 0.2, "three_times": 3.0, "none": None}
"""``{level: ratio of the stated noise to the true one}``; None: no noise is stated."""
NARROWEST, WIDEST = 0.5, 0.9  # bounds of the share of the joints' ranges that is used
RECORDS_TIME, RECORDS_APPROACH = 0.6, 0.5
"""Probabilities that the time, and the approach of the joints, are recorded if no injected effect needs them."""


@dataclass(frozen=True)
class Trial:
    """All that the simulation of one set needs.

    Attributes:
        sensor: One of ``SENSORS``.
        number: Number of the set among those of its sensor, from 0.
        seed: Seed of the arm's true geometry, the poses and the noise.
        robot: Name of a robot of ``configs/robots``.
        share_of_range: Share of the joints' ranges that the poses use.
        poses: Number of poses that are planned; with a probe, some of them reach no contact and are left out.
        unseen: Number of unseen poses, over which errors are taken.
        causes: What is injected into the arm, each with ``name``, ``target`` and ``size``, and a harmonic with ``phase``.
        noise_m: Standard deviation of a measured coordinate, or of a contact along the normal.
        stated: Level at which it is stated in the dataset, one of ``STATED``.
        turn_noise_rad: Standard deviation of a measured orientation about each axis; None: positions alone are measured.
        turn_stated: Level at which it is stated in the dataset, one of ``STATED``.
        repeatability_rad: Standard deviation of each joint's angle at each pose.
        sessions: Number of sessions; in each the tracker has another place.
        records_time: Whether the dataset has the column ``time``.
        records_approach: Whether the dataset has the columns of the approach.
        workcell: The planes that a probe touches, and the compliance of the joints.
    """

    sensor: str
    number: int
    seed: int
    robot: str
    share_of_range: float
    poses: int
    unseen: int
    causes: tuple[Mapping[str, Any], ...]
    noise_m: float
    stated: str
    turn_noise_rad: float | None
    turn_stated: str
    repeatability_rad: float
    sessions: int
    records_time: bool
    records_approach: bool
    workcell: Workcell

    @property
    def stated_noise_m(self) -> float | None:
        """Return the noise [m] that the dataset states; None if it states none."""
        factor = STATED[self.stated]
        return None if factor is None else factor * self.noise_m

    @property
    def stated_turn_noise_rad(self) -> float | None:
        """Return the noise of orientations [rad] that the dataset states; None if it states none."""
        factor = STATED[self.turn_stated]
        return None if factor is None or self.turn_noise_rad is None else factor * self.turn_noise_rad


@dataclass(frozen=True)
class Design:
    """The tracked trials of a config.

    Attributes:
        content: Content of the config.
        workcell: What every set has in common: planes, and the joints in which causes act.
    """

    content: Mapping[str, Any]
    workcell: Workcell = field(default_factory=load_workcell)

    def jobs(self) -> list[tuple[str, str]]:
        """Return the sensor and the sets of each job; ``0000-0009`` are the first ten sets, as ``numbers_of`` reads it."""
        size = self.content["sets_per_job"]
        return [
            (sensor, job) for sensor, sets in self.content["sets"].items() for job in job_names(sets, size)
        ]

    def trial(self, sensor: str, number: int) -> Trial:
        """Return one set, drawn from the seed, its sensor and its number alone."""
        content = self.content
        rng = np.random.default_rng([content["seed"], SENSORS.index(sensor), number])
        robot = str(rng.choice(content["robots"]))
        names = rng.choice(list(content["effects"]), rng.choice(content["together"]), replace=False)
        causes = tuple(self._cause(str(name), rng) for name in names)
        several = sensor == "targets"
        turn_noise = content["turn_noise_rad"] if several and rng.random() < 0.5 else None
        return Trial(
            sensor=sensor,
            number=number,
            seed=int(rng.integers(2**31)),
            robot=robot,
            share_of_range=float(rng.uniform(NARROWEST, WIDEST)),
            poses=int(rng.choice(content["poses"][sensor])),
            unseen=content["unseen_poses"],
            causes=causes,
            noise_m=float(rng.choice(content["noise_m"])),
            stated=content["stated"][number % len(content["stated"])],
            turn_noise_rad=turn_noise,
            turn_stated=str(rng.choice(content["stated"])),
            repeatability_rad=float(rng.choice(content["repeatability_rad"])),
            sessions=int(rng.integers(1, 3)) if several else 1,
            records_time=bool(rng.random() < RECORDS_TIME) or "thermal_drift" in names,
            records_approach=bool(rng.random() < RECORDS_APPROACH) or "joint_backlash" in names,
            workcell=self.workcell,
        )

    def _cause(self, name: str, rng: np.random.Generator) -> dict[str, Any]:
        """Return an injected cause with a drawn size and target."""
        size = float(rng.uniform(*self.content["effects"][name]))
        joint = int(rng.choice(self.workcell.joints))
        entry: dict[str, Any] = {"name": name, "target": {}, "size": size}
        if name == "joint_harmonic":
            target = {"joint": joint, "order": int(rng.choice(self.content["orders"]))}
            return entry | {"target": target, "phase": float(rng.uniform(0, 2 * np.pi))}
        if name == "joint_compliance":
            return entry | {"target": {"joints": list(self.workcell.relative_compliance)}}
        if name == "joint_coupling":
            return entry | {"target": dict(self.workcell.coupled_joints)}
        if name == "joint_scale":
            return entry | {"target": {"joint": joint}, "size": size * float(rng.choice([-1, 1]))}
        if name in ("joint_backlash", "pose_lag", "unknown"):
            return entry | {"target": {"joint": joint}}
        return entry


def load_tracked(path: str | Path) -> Design:
    """Return the design that a YAML file describes; ``extends`` is explained at ``study.blind_trials.stratified_design.checked_config``.

    Raises:
        InvalidInput: The file is at fault; every fault is listed.
    """
    return Design(checked_config(path, SCHEMA))
