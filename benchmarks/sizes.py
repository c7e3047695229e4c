"""Measure time and peak memory of a fit, and of all of ``calibrate``, over the number of poses N and of points a scan M, by several solvers.

Each way runs in a process of its own at each size, so that its peak memory is its own; imports and the dataset in memory are part of it. More
poses than the 120 of the headline scene are those over and over, as much work as that many. ``python -m benchmarks --figure`` measures all
sizes into ``benchmarks/measured.csv``; ``python -m benchmarks.sizes FOLDER WAY POSES`` is one process.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from benchmarks.contestants import Contest
from benchmarks.other_solvers import CERES, JAX, OURS, YARDSTICK
from benchmarks.peak_memory import peak_bytes
from benchmarks.scenes import write_paper_scene
from benchmarks.solvers.external import (
    Answer,
    MissingSolverError,
    Program,
    ceres_command,
    jax_command,
    problem_of,
)
from scalar.data.dataset import Dataset, read_dataset
from scalar.estimation.calibrate import calibrate
from scalar.estimation.least_squares import fit
from scalar.estimation.prepare import prepare
from scalar.units import MS

POSES = (60, 120, 400, 1200, 4000, 12_000)
POINTS = (10, 30, 100, 300, 1000)
AT_POSES, AT_POINTS = 120, 100  # at which the other of the two numbers is varied
WHOLE = "scalar: all of calibrate"
ENOUGH_SECONDS, MOST_ROUNDS = 1.0, 15
_KIB = 1024


@dataclass(frozen=True)
class Cell:
    """Median processor time [ms] and peak memory of the process [MiB] of one way at one size."""

    way: str
    poses: int
    points: int
    ms: float
    mib: float


def of_size(scene: Dataset, poses: int) -> Dataset:
    """Return a dataset of so many poses: some of the scene, evenly spaced, or all of them over and over."""
    if poses < scene.n_poses:
        return scene.subset(np.arange(poses) * scene.n_poses // poses)
    return scene.subset(np.arange(poses) % scene.n_poses)


def _ours(dataset: Dataset) -> Callable[[], Any]:
    prepared = prepare(dataset)
    model = prepared.initial.model
    return lambda: fit(prepared.residuals.reweighted(model), model, prepared.free).covariance


OWN: dict[str, Callable[[Dataset], Callable[[], Any]]] = {
    YARDSTICK: lambda dataset: Contest(dataset).all_points_finite_differences,
    OURS: _ours,
    WHOLE: lambda dataset: (
        lambda: calibrate(replace(dataset))
    ),  # nothing that a dataset remembers of an earlier call helps
}
"""For each way of this process what prepares a dataset and returns the call that is timed; it makes nothing that the call does not need."""


def median_time(call: Callable[[], float]) -> float:
    """Return the median of times that a call returns [s]: of so many calls as take a second, fifteen at most, and one at least."""
    first = call()  # warms up whatever is made once
    seconds = [first] if first > ENOUGH_SECONDS else []
    while len(seconds) < MOST_ROUNDS and sum(seconds) < ENOUGH_SECONDS:
        seconds.append(call())
    return float(np.median(seconds))


def own_cell(folder: Path, way: str, poses: int) -> dict[str, float]:
    """Return the median time [s] and the peak memory [bytes] of this process for one way of it."""
    call = OWN[way](of_size(read_dataset(folder), poses))

    def timed() -> float:
        start = time.process_time()
        call()
        return time.process_time() - start

    return {"seconds": median_time(timed), "bytes": peak_bytes()}


def own_cells(folder: Path, poses: int, points: int) -> Iterator[Cell]:
    """Yield what each way of this process takes at one size, each in a process of its own."""
    for way in OWN:
        run = subprocess.run(
            [sys.executable, "-m", "benchmarks.sizes", str(folder), way, str(poses)],
            check=True,
            capture_output=True,
            text=True,
        )
        found = json.loads(run.stdout)
        yield Cell(way, poses, points, found["seconds"] / MS, found["bytes"] / _KIB**2)


def other_cells(folder: Path, poses: int, points: int) -> Iterator[Cell]:
    """Yield what each way of another solver takes at one size, each in a program of its own; one that is missing is named."""
    problem = problem_of(Contest(of_size(read_dataset(folder), poses)))
    with tempfile.TemporaryDirectory() as other:
        path = Path(other) / "problem.bin"
        problem.write(path)
        commands: dict[tuple[str, str], Callable[[], list[str]]]
        commands = dict.fromkeys(CERES.items(), partial(ceres_command, problem, path))
        commands |= dict.fromkeys(JAX.items(), partial(jax_command, path))
        for (word, way), command in commands.items():
            try:
                seconds, peak = fits_of_a_program(command, word)
            except MissingSolverError as missing:
                print(f"{way}, {poses} poses: left out: {missing}", file=sys.stderr)
            else:
                yield Cell(way, poses, points, seconds / MS, peak / _KIB**2)


def fits_of_a_program(command: Callable[[], list[str]], word: str) -> tuple[float, int]:
    """Return the median time [s] and the peak memory [bytes] of a program that is asked for the same fit again and again."""
    answers: list[Answer] = []

    def timed() -> float:
        answers.append(program.fit(word))
        return answers[-1].seconds

    with Program(command()) as program:
        return median_time(timed), answers[-1].peak_bytes


def measure_sizes() -> pd.DataFrame:
    """Return a table with a row for each way and size, printed as it grows."""
    sizes = sorted({(n, AT_POINTS) for n in POSES} | {(AT_POSES, m) for m in POINTS})
    cells: list[Cell] = []
    print(f"{'poses':>8s}{'points a scan':>16s}{'ms':>12s}{'MiB':>9s}  way")
    with tempfile.TemporaryDirectory() as folder:
        scenes = {m: write_paper_scene(Path(folder) / str(m), m) for m in POINTS}
        for poses, points in sizes:
            for measured in (own_cells, other_cells):
                for cell in measured(scenes[points], poses, points):
                    print(
                        f"{cell.poses:8d}{cell.points:16d}{cell.ms:12.2f}{cell.mib:9.0f}  {cell.way}",
                        flush=True,
                    )
                    cells.append(cell)
    return pd.DataFrame(cells)


if __name__ == "__main__":
    print(json.dumps(own_cell(Path(sys.argv[1]), sys.argv[2], int(sys.argv[3]))))
