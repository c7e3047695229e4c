"""What a fit of a sweep takes, amortised over the seeds of one configuration, as the sweep makes them: each seed calibrated in turn in one process.

``python -m benchmarks.seeds`` prints this table alone.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from benchmarks.contestants import Contest
from benchmarks.scenes import CONFIG, GUESS
from scalar.estimation.calibrate import calibrate
from scalar.simulation import load_config, simulate
from scalar.units import MS

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset

SEEDS = 200
MOST_MS = 0.4  # of a fit, amortised: the goal
ROUNDS = 3  # of which the fastest counts, since other work only adds to a sum


def datasets(seeds: Sequence[int]) -> list[Dataset]:
    """Return the datasets of the paper's scene for some seeds, as a sweep makes them in memory."""
    from study.common.in_memory import dataset_in_memory

    config = load_config(CONFIG)
    config["plane_guess"].update(GUESS)
    config["truth_poses"] = 1
    return [dataset_in_memory(simulate(config | {"seed": seed}, base_dir=CONFIG.parent)) for seed in seeds]


def seeds_of_one_configuration(count: int = SEEDS) -> None:
    """Print the processor time of a seed, amortised: all of its calibration, and the parts that the contest of one fit has as well."""
    own = datasets(range(1, count + 1))
    contests = [Contest(dataset) for dataset in own]
    residuals = [contest.compressed_residuals() for contest in contests]
    ways: dict[str, Callable[[], object]] = {
        "all of calibrate, as in the sweep": lambda: [calibrate(_anew(each), explain=False) for each in own],
        "  start, SVD and rows": lambda: [Contest(_anew(each)) for each in own],
        "  the fit with standard errors": lambda: [
            contest.fit_proposed(rows) for contest, rows in zip(contests, residuals, strict=True)
        ],
    }
    print(
        f"{count} seeds of one configuration in turn, processor time of one, amortised [ms]; {MOST_MS} is asked for"
    )
    for name, way in ways.items():
        print(f"{name:48s}{_least(way) / count / MS:9.2f}")
    print(flush=True)


def _anew(dataset: Dataset) -> Dataset:
    """Return a copy that remembers nothing of an earlier call."""
    return replace(dataset)


def _least(way: Callable[[], object]) -> float:
    """Return the least processor time of some rounds [s]."""
    way()
    spent = np.empty(ROUNDS)
    for k in range(ROUNDS):
        start = time.process_time()
        way()
        spent[k] = time.process_time() - start
    return float(spent.min())


if __name__ == "__main__":
    seeds_of_one_configuration()
