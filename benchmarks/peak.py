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
        subprocess.CalledProcessError: The command failed.
    """
    run = subprocess.run(
        [sys.executable, "-S", __file__, *command], check=True, stdout=subprocess.PIPE, text=True
    )
    return int(run.stdout.split()[-1]) * 1024


if __name__ == "__main__":
    subprocess.run(sys.argv[1:], check=True, stdout=subprocess.DEVNULL)
    print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)
