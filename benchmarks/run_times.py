"""The time of a finished run by rule, and how busy the cores were, from the times that Snakemake records for each output.

``python -m benchmarks.run_times [FOLDER]`` prints the table for a folder in which the workflow ran; jobs that were not run there are left out.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

CORES = 2


@dataclass(frozen=True)
class Job:
    """One job of a run: its rule, and when it started and ended [s since 1970]."""

    rule: str
    start: float
    end: float

    @property
    def seconds(self) -> float:
        """Return how long it took [s]."""
        return self.end - self.start


def jobs_of(records: Iterable[dict[str, Any]]) -> list[Job]:
    """Return the jobs of Snakemake's records, sorted by their start; a job with several outputs counts once."""
    found: dict[tuple[str, ...], Job] = {}
    for record in records:
        rule, start, end = (record.get(key) for key in ("rule", "starttime", "endtime"))
        if rule and start and end:
            found[rule, *record.get("log", ())] = Job(rule, start, end)  # every job has a log of its own
    return sorted(found.values(), key=lambda job: job.start)


def table(jobs: Sequence[Job], cores: int = CORES) -> str:
    """Return the table: a line for each rule, the most seconds first, then the whole run and the share of time in which cores had no job."""
    rules = sorted({job.rule for job in jobs})
    seconds = {rule: [job.seconds for job in jobs if job.rule == rule] for rule in rules}
    lines = [f"{'rule':36s}{'jobs':>6s}{'sum [s]':>10s}{'longest [s]':>13s}"]
    lines += [
        f"{rule:36s}{len(own):6d}{sum(own):10.1f}{max(own):13.1f}"
        for rule, own in sorted(seconds.items(), key=lambda entry: -sum(entry[1]))
    ]
    wall = max(job.end for job in jobs) - jobs[0].start
    total = sum(job.seconds for job in jobs)
    lines.append(f"{'all':36s}{len(jobs):6d}{total:10.1f}{max(job.seconds for job in jobs):13.1f}")
    lines.append(
        f"from the first start to the last end {wall:.1f} s; the sum on {cores} cores would take {total / cores:.1f} s, "
        f"so {100 * (1 - total / cores / wall):.0f} % of the cores' time was without a job"
    )
    return "\n".join(lines)


def main() -> None:
    """Print the table of a folder."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.run_times", description=__doc__)
    parser.add_argument(
        "folder", nargs="?", default=".", type=Path, help="where the workflow ran (this folder)"
    )
    folder = parser.parse_args().folder / ".snakemake" / "metadata"
    records = [json.loads(path.read_text(encoding="utf-8")) for path in folder.rglob("*") if path.is_file()]
    jobs = jobs_of(records)
    if not jobs:
        sys.exit(f"{folder}: no finished job is recorded here; run snakemake there first")
    print(table(jobs))


if __name__ == "__main__":
    main()
