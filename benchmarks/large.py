"""Diagnose a tracked arm with 12,000 poses and two effects, an eccentric gear of one joint and a scale error of another, with every candidate.

The dataset comes from the tests' own kinematics (``tests/random_scene.py``), which share nothing with what is fitted. The diagnosis runs in a
process of its own, so that its memory is its own as well.
"""

from __future__ import annotations

import json
import resource
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from tests.random_scene import make_scene
from tests.workcell import Scene

POSES = 12_000
NOISE = 2e-5  # m, along each axis
MOST_SECONDS, MOST_BYTES = 60.0, 2 * 1024**3  # the goals
_ROUNDS = 20  # of the fixed-point iteration that finds what the encoder reads for a given true angle


@dataclass(frozen=True)
class Run:
    """What a diagnosis took, and what it named."""

    seconds: float
    peak_bytes: int
    named: list[str]


def tracked(poses: int = POSES, seed: int = 1) -> Scene:
    """Return the scene: joint 2 errs by 0.3 mrad five times a turn, joint 4 by one part in a thousand."""
    scene = make_scene(kind="tracker", seed=seed, poses_per_plane=poses // 3, noise=NOISE)
    q2, q4 = scene.dataset.q[:, 1], scene.dataset.q[:, 3]
    read = q2.copy()
    for _ in range(_ROUNDS):
        read = q2 - 3e-4 * np.sin(5 * read)
    table = scene.dataset.poses.assign(q2=read, q4=q4 / (1 + 1e-3))
    return replace(scene, dataset=replace(scene.dataset, poses=table))


def diagnosed(scene: Scene) -> Run:
    """Return what ``scalar diagnose`` takes for a scene's dataset, its reading and its report included."""
    with tempfile.TemporaryDirectory() as folder:
        dataset, out = scene.write(Path(folder) / "dataset"), Path(folder) / "out"
        command = [sys.executable, "-m", "scalar.cli", "diagnose", str(dataset), "-o", str(out)]
        start = time.perf_counter()
        subprocess.run(command, check=True, capture_output=True)
        seconds = time.perf_counter() - start
        found = json.loads((out / "diagnosis.json").read_text(encoding="utf-8"))
    peak = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss * 1024  # the largest child's
    return Run(seconds, peak, [effect["name"] for effect in found["effects"]])


def large() -> None:
    """Print what the diagnosis of 12,000 tracked poses takes."""
    scene = tracked()
    run = diagnosed(scene)
    print(
        f"scalar diagnose, {scene.dataset.n_poses} tracked poses, every candidate, report included; asked for in brackets"
    )
    print(f"{'seconds':48s}{run.seconds:9.1f}   (below {MOST_SECONDS:.0f})")
    print(f"{'peak memory [GiB]':48s}{run.peak_bytes / 1024**3:9.2f}   (below {MOST_BYTES / 1024**3:.0f})")
    print(f"{'named':48s}  {', '.join(run.named)}\n")
