"""Time and peak memory of all of ``calibrate`` over the number of poses; each size runs in a process of its own.

``python -m benchmarks.growth POSES`` measures one size: the headline scene repeated to that many poses of 100 points.
"""

from __future__ import annotations

import subprocess
import sys
import time

import numpy as np

from benchmarks.peak_memory import peak_bytes
from benchmarks.scenes import paper_scene
from scalar.estimation.calibrate import calibrate
from scalar.units import MS

SIZES = (120, 1200, 12_000)
LARGEST = 100_000
MOST_BYTES = 3 * 1024**3  # the goal for the largest
_KIB = 1024


def measured(poses: int) -> str:
    """Return a line: poses, processor time of ``calibrate`` [ms], peak memory of the process [GiB]."""
    scene = paper_scene()
    dataset = scene.subset(np.arange(poses) % scene.n_poses)
    calibrate(scene)  # what is imported and made once
    start = time.process_time()
    calibrate(dataset)
    taken = time.process_time() - start
    return f"{poses:10d}{taken / MS:12.1f}{taken / poses / MS:14.4f}{peak_bytes() / _KIB**3:12.2f}"


def growth(with_largest: bool) -> None:
    """Print the table."""
    print("all of calibrate, M = 100, each size in a process of its own")
    print(f"{'poses':>10s}{'time [ms]':>12s}{'a pose [ms]':>14s}{'peak [GiB]':>12s}")
    for poses in (*SIZES, LARGEST) if with_largest else SIZES:
        run = subprocess.run(
            [sys.executable, "-m", "benchmarks.growth", str(poses)],
            check=True,
            capture_output=True,
            text=True,
        )
        print(run.stdout.rstrip(), flush=True)
    print(f"below {MOST_BYTES / _KIB**3:.0f} GiB is asked for at {LARGEST} poses\n")


if __name__ == "__main__":
    print(measured(int(sys.argv[1])))
