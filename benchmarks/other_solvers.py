"""The headline fit by Ceres (C++, automatic differentiation) and JAX (compiled, forward-mode) beside lmfit and ``scalar``.

``python -m benchmarks.other_solvers`` prints the table alone. All minimise the same weighted sum of squares over the same free coordinates from
the same start, and give standard errors. A time begins with the points in memory, so that compression counts where there is any. Ceres and JAX
run as programs of their own that measure their own processor time; they take turns with the others. A solver that is not there is
said to be missing, and the others are compared all the same.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.contestants import Contest, Result
from benchmarks.limit import limits
from benchmarks.scenes import paper_scene
from benchmarks.solvers.external import (
    CERES_WAYS,
    JAX_WAYS,
    MissingSolverError,
    Program,
    ceres_command,
    jax_command,
    problem_of,
)
from benchmarks.timing import in_turns, middle_half, ratio
from scalar.units import MS

YARDSTICK, OURS = "lmfit, finite differences, all points", "scalar: compressed, analytic"
CERES = {
    "point": "Ceres, a block a point",
    "pose": "Ceres, a block a pose",
    "compressed": "Ceres, compressed",
}
JAX = {"points": "JAX, all points", "compressed": "JAX, compressed"}


@dataclass(frozen=True, eq=False)
class Timed:
    """A result, the processor time that it took [s], and the processor time of compiling it before [s]."""

    result: Result
    seconds: float
    compile_seconds: float = 0.0


Way = Callable[[], Timed]


def own_ways(contest: Contest) -> dict[str, Way]:
    """Return the yardstick and the fit of ``scalar``, timed in this process."""

    def timed(call: Callable[[], Result]) -> Timed:
        start = time.process_time()
        result = call()
        return Timed(result, time.process_time() - start)

    return {
        YARDSTICK: lambda: timed(contest.all_points_finite_differences),
        OURS: lambda: timed(contest.proposed),
    }


def other_ways(
    contest: Contest, folder: Path, open_programs: ExitStack, *, build: bool = True
) -> dict[str, Way | str]:
    """Return every way of another solver, or in a word why it is not to be had here.

    Args:
        contest: What is fitted.
        folder: Where the problem is written for the programs.
        open_programs: Ends the programs.
        build: Whether the program of Ceres is compiled if it has not been.
    """
    problem, path = problem_of(contest), folder / "problem.bin"
    problem.write(path)
    solvers: tuple[tuple[dict[str, str], tuple[str, ...], Callable[[], list[str]]], ...] = (
        (CERES, CERES_WAYS, lambda: ceres_command(problem, path, build=build)),
        (JAX, JAX_WAYS, lambda: jax_command(path)),
    )
    ways: dict[str, Way | str] = {}
    for names, words, command in solvers:
        try:
            program = open_programs.enter_context(Program(command()))
        except MissingSolverError as missing:
            ways |= {names[word]: str(missing) for word in words}
            continue
        for word in words:
            way = _way(contest, program, word)
            try:
                way()
            except MissingSolverError as missing:
                ways[names[word]] = str(missing)
            else:
                ways[names[word]] = way
    return ways


def _way(contest: Contest, program: Program, word: str) -> Way:
    def call() -> Timed:
        found = program.fit(word)
        result = Result(found.vector[contest.arm], found.std[: len(contest.arm)], found.evaluations)
        return Timed(result, found.seconds, found.compile_seconds)

    return call


def distance(result: Result, best: Result) -> float:
    """Return the largest difference of a parameter of the arm from that of another result, in its standard errors."""
    return float(np.max(np.abs(result.values - best.values) / best.std))


def other_solvers(rounds: int, contest: Contest | None = None) -> None:
    """Print the table."""
    contest = Contest(paper_scene()) if contest is None else contest
    with tempfile.TemporaryDirectory() as folder, ExitStack() as programs:
        ways: dict[str, Way | str] = own_ways(contest) | other_ways(contest, Path(folder), programs)
        there = {name: way for name, way in ways.items() if callable(way)}
        times = in_turns({name: lambda way=way: way().seconds for name, way in there.items()}, rounds)
        last = {name: way() for name, way in there.items()}
    n, points = contest.dataset.n_poses, len(contest.x)
    print(
        f"3N = {n}, {points} points, by other solvers: one fit with standard errors, processor time [ms], {rounds} rounds"
    )
    print(
        f"{'':40s}{'median':>9s}{'least':>9s}{'faster':>9s}{'ours, and half of the rounds':>30s}{'evals':>8s}{'off [sd]':>12s}{'compile':>9s}"
    )
    for name, way in ways.items():
        if isinstance(way, str):
            print(f"{name:40s}  left out: {way}")
            continue
        result, each = last[name].result, times[name]
        low, high = middle_half(each, times[OURS])
        spread = f"{ratio(each, times[OURS]):.2f} ({low:.2f} to {high:.2f})"
        print(
            f"{name:40s}{each.median / MS:9.2f}{each.least / MS:9.2f}{ratio(times[YARDSTICK], each):9.1f}"
            f"{spread:>30s}{result.evaluations:8d}{distance(result, last[OURS].result):12.1e}"
            f"{last[name].compile_seconds / MS:9.0f}"
        )
    print(
        "faster: than the first row; ours: how many times faster scalar is; compile: once, and no part of the time\n"
    )


def main() -> None:
    """Print the table and how far the fit is from what the machine could do."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.other_solvers", description=__doc__)
    parser.add_argument("--rounds", type=int, default=15, help="how often each is timed (15)")
    rounds = parser.parse_args().rounds
    other_solvers(rounds)
    limits(rounds)


if __name__ == "__main__":
    main()
