"""Print how calibration packages do on tracker data: ``make bench-trackers``, or ``python -m benchmarks.trackers``."""

from __future__ import annotations

import argparse
import sys

from benchmarks.trackers.contest import WAYS, nominal_score, outcome, own_python
from benchmarks.trackers.environments import interpreter
from benchmarks.trackers.scene import TEST, TRAINING, tracked_scene
from benchmarks.trackers.table import errors, row, table

KINDS = {"errors that a DH table describes": False, "axis 3 also tilted out of the plane of the table": True}


def contest(seeds: range, tilted: bool) -> str:
    """Return the table of the scenes of one kind."""
    scenes = [tracked_scene(seed, tilted=tilted) for seed in seeds]
    rows: list[tuple[str, ...]] = [("nominal arm", "", *errors([nominal_score(scene) for scene in scenes]))]
    for way in WAYS:
        python = own_python() if way.package is None else interpreter(way.package)
        print(f"{way.title} ...", file=sys.stderr, flush=True)
        rows.append(row(way.title, [outcome(way, scene, python) for scene in scenes]))
    return table(rows)


def main() -> None:
    """Run what is asked for."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.trackers", description=__doc__)
    parser.add_argument("--scenes", type=int, default=5, help="arms that are drawn for each table (5)")
    options = parser.parse_args()
    for title, tilted in KINDS.items():
        print(f"\n{title}: {options.scenes} arms, {TRAINING} measured poses, {TEST} test poses each\n")
        print(contest(range(1, options.scenes + 1), tilted), flush=True)


if __name__ == "__main__":
    main()
