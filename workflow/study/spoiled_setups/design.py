"""The design of the spoiled set-ups: what is drawn for each set from the design's seed and the set's number.

The kinds of spoiling are taken in turn, so that each is equally frequent; everything else is drawn. The first sets of a longer design are those of a
shorter one.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from scalar.robots import arm_names
from study.blind_trials.stratified_design import checked_config, job_names

SCHEMA = Path(__file__).parent / "schemas/spoiled_setups.schema.json"
SCANNER, TRACKER = "line-laser", "tracker"
ONLY_WITH = {"mirrored": TRACKER, "swapped_labels": SCANNER}
"""Kinds that need a sensor: a mirrored scan is the same as one of a scanner that is turned by 180 degrees, and a tracker sees no planes."""


@dataclass(frozen=True)
class SetUp:
    """All that the simulation of a sound campaign needs.

    Attributes:
        number: Number of the set, from 0.
        attempt: How many set-ups of this number were drawn before and left out.
        kind: How it is spoiled, a key of ``study.spoiled_setups.spoilings.SPOILINGS``.
        sensor: ``line-laser`` or ``tracker``.
        arm: Name of the arm in the library.
        poses: Number of poses.
        noise_m: Standard deviation of a range or of a coordinate, which the dataset states.
        states_pose: Whether the dataset states the sensor's pose on the flange; before a tracker it has to.
        standard: Whether the table of joints is standard DH; else it is modified DH.
        named: Whether the dataset states the maker's name of the arm.
    """

    number: int
    attempt: int
    kind: str
    sensor: str
    arm: str
    poses: int
    noise_m: float
    states_pose: bool
    standard: bool
    named: bool


@dataclass(frozen=True)
class Design:
    """The spoiled set-ups of a config, whose content is ``content``."""

    content: Mapping[str, Any]

    def jobs(self) -> list[str]:
        """Return the names of the jobs; ``0000-0009`` are the first ten sets."""
        return job_names(self.content["sets"], self.content["sets_per_job"])

    def drawn(self, number: int, attempt: int) -> tuple[SetUp, np.random.Generator]:
        """Return a set and the random numbers for its simulation and spoiling, drawn from the seed, its number and the attempt alone."""
        content = self.content
        rng = np.random.default_rng([content["seed"], number, attempt])
        kind = content["kinds"][number % len(content["kinds"])]
        sensor = ONLY_WITH.get(kind) or str(rng.choice([SCANNER, TRACKER]))
        setup = SetUp(
            number=number,
            attempt=attempt,
            kind=kind,
            sensor=sensor,
            arm=str(rng.choice(arm_names())),
            poses=int(rng.integers(content["poses"][sensor][0], content["poses"][sensor][1] + 1)),
            noise_m=float(rng.choice(content["noise_m"])),
            states_pose=bool(rng.random() < content["states_pose"]) or sensor == TRACKER,
            standard=bool(rng.random() < content["standard"]),
            named=bool(rng.random() < content["named"]),
        )
        return setup, rng


def load_spoiled(path: str | Path) -> Design:
    """Return the design that a YAML file describes; ``extends`` is explained at ``study.blind_trials.stratified_design.checked_config``.

    Raises:
        InvalidInput: The file is at fault; every fault is listed.
    """
    return Design(checked_config(path, SCHEMA))
