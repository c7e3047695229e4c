"""Processor time of short commands where Python may not write bytecode, compared with importing NumPy and pandas alone."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

from benchmarks.scenes import write_paper_scene
from benchmarks.timing import interleaved, ratio
from scalar.units import MS

YARDSTICK = "python -c 'import numpy, pandas'"


def start_up(rounds: int) -> None:
    """Print the processor time of short commands, each a process of its own that may write no bytecode."""
    with tempfile.TemporaryDirectory() as name:
        dataset = write_paper_scene(Path(name))
        ways = {
            "python -c pass": ["-c", "pass"],
            YARDSTICK: ["-c", "import numpy, pandas"],
            "python -c 'import scalar'": ["-c", "import scalar"],
            "scalar --version": ["-m", "scalar.cli", "--version"],
            "scalar --help": ["-m", "scalar.cli", "--help"],
            "scalar validate, 120 poses": ["-m", "scalar.cli", "validate", str(dataset)],
        }
        calls = {name: lambda arguments=arguments: _run(arguments) for name, arguments in ways.items()}
        times = interleaved(calls, rounds, _time_of_children)
    print(f"start-up: processor time of a process that may write no bytecode [ms], {rounds} rounds")
    print(f"{'':48s}{'median':>9s}{'least':>9s}{'share':>9s}")
    for name, each in times.items():
        share = 1 / ratio(times[YARDSTICK], each)
        print(f"{name:48s}{each.median / MS:9.0f}{each.least / MS:9.0f}{share:9.2f}")
    print()


def _run(arguments: list[str]) -> None:
    environment = {**os.environ, "PYTHONDONTWRITEBYTECODE": "1"}
    subprocess.run([sys.executable, *arguments], env=environment, check=True, stdout=subprocess.DEVNULL)


def _time_of_children() -> float:
    """Return the processor time of all processes that this one has started and seen end [s]."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime
