"""Print the side-by-side figures: ``make bench``, or ``python -m benchmarks`` with one BLAS thread."""

from __future__ import annotations

import argparse
import os
from dataclasses import replace

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")


from benchmarks.contestants import Contest, Result  # noqa: E402
from benchmarks.correction import correction  # noqa: E402
from benchmarks.growth import growth  # noqa: E402
from benchmarks.large import large  # noqa: E402
from benchmarks.limit import limits  # noqa: E402
from benchmarks.other_solvers import OURS, YARDSTICK, distance, other_solvers  # noqa: E402
from benchmarks.scenes import paper_scene, repeated  # noqa: E402
from benchmarks.seeds import seeds_of_one_configuration  # noqa: E402
from benchmarks.simulation import simulation  # noqa: E402
from benchmarks.start_up import start_up  # noqa: E402
from benchmarks.timing import Times, interleaved, line, ratio  # noqa: E402
from scalar.estimation.calibrate import calibrate  # noqa: E402
from scalar.units import MS  # noqa: E402

THROUGH_LMFIT = "scalar through lmfit, its report written"
FIT = "  of which the fit"
WHOLE, WHOLE_IN_NUMPY = "scalar calibrate: guess, SVD, reweighting, fit", "  the same without a C compiler"
TARGETS = {FIT: 300.0, THROUGH_LMFIT: 30.0}  # times faster than the yardstick
WHOLE_TARGET = 6.0  # ms
POINTS = (10, 100, 1000)
LARGE = 100  # times 120 poses


def row(name: str, times: Times, yardstick: Times, result: Result, best: Result) -> str:
    """Return a line of the table: times, how many times faster, evaluations, distance from our optimum."""
    faster = ratio(yardstick, times)
    return f"{line(name, times)}{faster:9.1f}{result.evaluations:8d}{distance(result, best):12.1e}"


def headline(rounds: int) -> None:
    """Print the ways to the optimum of the headline scene."""
    contest = Contest(paper_scene())
    residuals = contest.compressed_residuals()
    ways = {
        YARDSTICK: contest.all_points_finite_differences,
        "the same, shared products taken once": contest.factored_finite_differences,
        "the same, compressed": contest.compressed_finite_differences,
        "SciPy, finite differences, all points": contest.scipy_all_points,
        "SciPy, analytic, compressed": contest.scipy_compressed_analytic,
        "published, 43 parameters, clip, all points": contest.published,
        THROUGH_LMFIT: contest.proposed_through_lmfit,
        "scalar: the same without a C compiler": contest.proposed_in_numpy,
        OURS: contest.proposed,
        FIT: lambda: contest.fit_proposed(residuals),
    }
    # A new dataset each time: nothing that a dataset remembers of an earlier call helps.
    whole = {WHOLE: lambda: calibrate(replace(contest.dataset)), WHOLE_IN_NUMPY: contest.calibrate_in_numpy}
    times = interleaved({**ways, **whole}, rounds)
    best = contest.proposed()
    print(f"3N = 120, M = 100: one fit with standard errors, processor time [ms], {rounds} rounds")
    print(f"{'':48s}{'median':>9s}{'least':>9s}{'faster':>9s}{'evals':>8s}{'off [sd]':>12s}")
    for name, way in ways.items():
        print(row(name, times[name], times[YARDSTICK], way(), best))
    for name in whole:
        print(line(name, times[name]) + f"{ratio(times[YARDSTICK], times[name]):9.1f}")
    for name, target in TARGETS.items():
        reached = ratio(times[YARDSTICK], times[name])
        print(
            f"{name.strip()}: {reached:.0f} times faster than the yardstick; at least {target:.0f} is asked for"
        )
    print(f"all of calibrate: {times[WHOLE].median / MS:.1f} ms; below {WHOLE_TARGET:.0f} is asked for\n")


def points_a_scan(rounds: int) -> None:
    """Print what the fit and the compression cost for different M."""
    contests = {m: Contest(paper_scene(points_per_scan=m)) for m in POINTS}
    residuals = {m: contest.compressed_residuals() for m, contest in contests.items()}
    fits = interleaved({str(m): lambda m=m: contests[m].fit_proposed(residuals[m]) for m in POINTS}, rounds)
    compressions = interleaved({str(m): contests[m].compressed_residuals for m in POINTS}, rounds)
    print("3N = 120, any M: the fit after the scan is read, and reading it into rows [ms, median]")
    print(f"{'M':>8s}{'fit':>9s}{'evals':>8s}{'a call':>9s}{'compress':>10s}")
    for m in POINTS:
        evaluations = contests[m].fit_proposed(residuals[m]).evaluations
        fit_ms, read_ms = fits[str(m)].median / MS, compressions[str(m)].median / MS
        print(f"{m:8d}{fit_ms:9.1f}{evaluations:8d}{fit_ms / evaluations:9.2f}{read_ms:10.1f}")
    print()


def many_poses(with_yardstick: bool) -> None:
    """Print one fit of 12,000 poses."""
    contest = Contest(repeated(paper_scene(), LARGE))
    residuals = contest.compressed_residuals()
    ways = {"compress": contest.compressed_residuals, "fit": lambda: contest.fit_proposed(residuals)}
    if with_yardstick:
        ways[YARDSTICK] = contest.all_points_finite_differences
    times = interleaved(ways, 1 if with_yardstick else 3)
    print(f"{contest.dataset.n_poses} poses, M = 100 [ms]")
    for name, each in times.items():
        print(line(name, each))


def main() -> None:
    """Run what is asked for."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("--rounds", type=int, default=15, help="how often each is timed (15)")
    parser.add_argument(
        "--all",
        action="store_true",
        help="time the yardstick at 12,000 poses (a minute), calibrate at 100,000, and the outer split, as well",
    )
    parser.add_argument(
        "--figure",
        action="store_true",
        help="only measure time and memory over the numbers of poses and points, by all solvers, and draw them (ten minutes)",
    )
    arguments = parser.parse_args()
    if arguments.figure:
        from benchmarks.figure import figure  # matplotlib, which nothing else here needs

        figure()
        return
    print("processor time; other work on this machine moves the times, and the ratios little\n")
    start_up(arguments.rounds)
    correction(arguments.rounds)
    headline(arguments.rounds)
    other_solvers(arguments.rounds)
    limits(arguments.rounds)
    points_a_scan(arguments.rounds)
    seeds_of_one_configuration()
    many_poses(arguments.all)
    simulation(arguments.rounds)
    growth(arguments.all)
    large(arguments.all)


if __name__ == "__main__":
    main()
