"""The time of a finished run by rule, and how busy the cores were, from the times that Snakemake records for each output.

``python -m benchmarks.run_times [FOLDER]`` prints the table for a folder in which the workflow ran; jobs that were not run there are left out.
The goal of six minutes was set for the rules and numbers of jobs in ``frozen_rules.csv``, under their present names: those of a default run when its
times were first written down (commit da4786ef, 22 November 2026). Rules and jobs that were added later have lines and a sum of their own.
"""

from __future__ import annotations

import argparse
import csv
import json
import sys
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

CORES = 2
FROZEN = Path(__file__).with_name("frozen_rules.csv")


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


def frozen_rules(path: Path = FROZEN) -> dict[str, int]:
    """Return {rule: number of jobs} of the default run for which the goal was set."""
    with open(path, encoding="utf-8", newline="") as file:
        return {row["rule"]: int(row["jobs"]) for row in csv.DictReader(file)}


def table(jobs: Sequence[Job], frozen: Mapping[str, int], cores: int = CORES) -> str:
    """Return the table of a run.

    A line for each rule, the most seconds first, those of the frozen list and those that were added later apart; then the whole run, and the share of
    time in which cores had no job.

    Args:
        jobs: The jobs that were run.
        frozen: {rule: number of jobs} of the frozen list.
        cores: Number of cores on which the jobs ran.
    """
    lines = [f"{'rule':36s}{'jobs':>6s}{'frozen':>8s}{'sum [s]':>10s}{'longest [s]':>13s}"]
    parts = {
        "frozen": [job for job in jobs if job.rule in frozen],
        "added later": [job for job in jobs if job.rule not in frozen],
    }
    for name, own in parts.items():
        if own:
            lines += [*_lines_of_rules(own, frozen), _line(name, own, frozen), ""]
    lines += [_line("all", jobs, frozen), *_unlike_frozen(jobs, frozen)]
    wall = max(job.end for job in jobs) - jobs[0].start
    total, of_frozen = (sum(job.seconds for job in some) for some in (jobs, parts["frozen"]))
    lines.append(
        f"from the first start to the last end {wall:.1f} s; the sum on {cores} cores would take {total / cores:.1f} s, that of the frozen rules "
        f"{of_frozen / cores:.1f} s, so {100 * (1 - total / cores / wall):.0f} % of the cores' time was without a job"
    )
    return "\n".join(lines)


def _lines_of_rules(jobs: Sequence[Job], frozen: Mapping[str, int]) -> list[str]:
    """Return a line for each rule of some jobs, the most seconds first."""
    rules = sorted({job.rule for job in jobs})
    own = {rule: [job for job in jobs if job.rule == rule] for rule in rules}
    ordered = sorted(own.items(), key=lambda entry: -sum(job.seconds for job in entry[1]))
    return [_line(rule, some, frozen) for rule, some in ordered]


def _line(name: str, jobs: Sequence[Job], frozen: Mapping[str, int]) -> str:
    """Return the line of some jobs: their number, the number that the rules had in the frozen list, and their seconds."""
    seconds = [job.seconds for job in jobs]
    were = sum(frozen.get(rule, 0) for rule in {job.rule for job in jobs})
    return f"{name:36s}{len(jobs):6d}{were:8d}{sum(seconds):10.1f}{max(seconds):13.1f}"


def _unlike_frozen(jobs: Sequence[Job], frozen: Mapping[str, int]) -> list[str]:
    """Return sentences on frozen rules that were not run, and on those with another number of jobs than in the frozen list."""
    ran = Counter(job.rule for job in jobs)
    missing = [rule for rule in frozen if rule not in ran]
    unlike = [
        f"{rule} ({ran[rule]} of {count})" for rule, count in frozen.items() if ran[rule] not in (0, count)
    ]
    said = [f"frozen rules that were not run here: {', '.join(missing)}"] if missing else []
    return said + ([f"frozen rules with another number of jobs: {', '.join(unlike)}"] if unlike else [])


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
    print(table(jobs, frozen_rules()))


if __name__ == "__main__":
    main()
