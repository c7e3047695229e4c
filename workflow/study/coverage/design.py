"""The design of the study of coverage: what is drawn for each workcell from the design's seed and the workcell's number.

Kinds of sensor, numbers of poses (few or many) and origins of the prior are taken in turn, so that all combinations are equally frequent.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from scalar.robots import arm_names
from study.blind_trials.stratified_design import checked_config, job_names

SCHEMA = Path(__file__).parent / "schemas/coverage.schema.json"
SCANNER, TRACKER = SENSORS = "line-laser", "tracker"
SIZES = ("few", "many")
PRIORS = ("stated", "learned")
"""Where the standard deviations of the prior come from: the maker's tolerances in the dataset, or the arm itself."""
COMBINATIONS = tuple(product(SENSORS, SIZES, PRIORS))


@dataclass(frozen=True)
class Case:
    """All that the simulation of a workcell needs.

    Attributes:
        number: Number of the workcell, from 0.
        sensor: ``line-laser`` or ``tracker``.
        size: ``few`` or ``many`` poses.
        prior: ``stated`` or ``learned``.
        arm: Name of the arm in the library.
        poses: Number of poses.
        share: Share of each joint's range in which poses are measured.
        noise_m: Standard deviation of a range or of a coordinate, which the dataset states.
        length_std_m, angle_std_rad: Standard deviations of the errors of the table, which are the tolerances where these are stated.
        predicted: Number of poses that are predicted in each region.
    """

    number: int
    sensor: str
    size: str
    prior: str
    arm: str
    poses: int
    share: float
    noise_m: float
    length_std_m: float
    angle_std_rad: float
    predicted: int


@dataclass(frozen=True)
class Design:
    """The study of a config, whose content is ``content``."""

    content: Mapping[str, Any]

    def jobs(self) -> list[str]:
        """Return the names of the jobs; ``0000-0099`` are the first hundred workcells."""
        return job_names(self.content["workcells"], self.content["workcells_per_job"])

    def drawn(self, number: int, attempt: int) -> tuple[Case, np.random.Generator]:
        """Return a workcell and the random numbers for its simulation, drawn from the seed, its number and the attempt alone."""
        content = self.content
        rng = np.random.default_rng([content["seed"], number, attempt])
        sensor, size, prior = COMBINATIONS[number % len(COMBINATIONS)]
        fewest, most = content["poses"][sensor][size]
        case = Case(
            number=number,
            sensor=sensor,
            size=size,
            prior=prior,
            arm=str(rng.choice(arm_names())),
            poses=int(rng.integers(fewest, most + 1)),
            share=content["measured_share"][sensor],
            noise_m=float(rng.choice(content["noise_m"])),
            length_std_m=content["length_std_m"],
            angle_std_rad=content["angle_std_rad"],
            predicted=content["predicted"],
        )
        return case, rng


def load_coverage(path: str | Path) -> Design:
    """Return the design that a YAML file describes; ``extends`` is explained at ``study.blind_trials.stratified_design.checked_config``.

    Raises:
        InvalidInput: The file is at fault; every fault is listed.
    """
    return Design(checked_config(path, SCHEMA))
