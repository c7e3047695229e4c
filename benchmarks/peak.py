"""Run a command from a small process of its own, and print the peak memory of the largest process that it started.

A process that is started inherits the peak of the one that starts it, so a benchmark that holds a dataset must not start the command itself.
"""

from __future__ import annotations

import resource
import subprocess
import sys
from collections.abc import Sequence


def peak_memory(command: Sequence[str]) -> int:
    """Return the peak memory of the largest process of a command, its children included [bytes]; shared pages count in each process.

    Raises:
        RuntimeError: The command failed.
    """
    status, peak = peak_command(command)
    if status != 0:
        raise RuntimeError(f"the command ended with {status}: {' '.join(command)}")
    return peak


def peak_command(command: Sequence[str]) -> tuple[int, int]:
    """Return the exit status of a command, and the peak memory of its largest process [bytes]."""
    run = subprocess.run(
        [sys.executable, "-S", __file__, *command], check=True, stdout=subprocess.PIPE, text=True
    )
    status, peak = run.stdout.split()[-2:]
    return int(status), int(peak) * 1024


if __name__ == "__main__":
    ended = subprocess.run(sys.argv[1:], check=False, stdout=subprocess.DEVNULL).returncode
    print(ended, resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)
