"""Diagnose tracked arms with 12,000 poses, every candidate and the report included: once with ``--quick``, and with the outer split.

Two arms: one of six joints with two effects, an eccentric gear of one joint and a scale error of another; and, for the worst case of memory, one of
seven joints, of which one has so many orders that all of them may be fitted at once, and another follows a curve that no candidate has.

The datasets come from the tests' own kinematics (``tests/random_scene.py``), which share nothing with what is fitted. Each diagnosis runs in a
process of its own, so that its memory is its own as well. ``python -m benchmarks.large`` prints this table alone.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from benchmarks.peak import peak_memory
from tests.random_scene import make_scene
from tests.workcell import Scene

POSES = 12_000
NOISE = 2e-5  # m, along each axis
MOST_SECONDS, MOST_TIMES, MOST_BYTES = 15.0, 4.0, 2 * 1024**3
"""The goals: seconds with ``--quick``, how many times as long with the outer split, and the memory of the largest process."""
ORDERS = {
    1: 2e-4,
    2: 3e-4,
    3: 1.5e-4,
    4: 1e-4,
    5: 2e-4,
    6: 1e-4,
    7: 1e-4,
    9: 8e-5,
}  # amplitudes [rad] of the worst case
CURVE = 2e-4  # rad, of an angle's error that follows the tangent hyperbolic of two others' product
_ROUNDS = 20  # of the fixed-point iteration that finds what the encoder reads for a given true angle
_GIB = 1024**3


@dataclass(frozen=True)
class Run:
    """What a diagnosis took, and what it named."""

    seconds: float
    peak_bytes: int
    named: list[str]


def tracked(poses: int = POSES, seed: int = 1) -> Scene:
    """Return the scene of six joints: joint 2 errs by 0.3 mrad five times a turn, joint 4 by one part in a thousand."""
    scene = make_scene(kind="tracker", seed=seed, poses_per_plane=poses // 3, noise=NOISE)
    return _erring(scene, {5: 3e-4}, 0.0)


def worst(poses: int = POSES, seed: int = 1) -> Scene:
    """Return the scene of seven joints: joint 2 errs by eight orders, joint 4 by one part in a thousand, joint 6 by a curve of joints 1 and 3."""
    scene = make_scene("panda", kind="tracker", seed=seed, poses_per_plane=poses // 3, noise=NOISE)
    return _erring(scene, ORDERS, CURVE)


def _erring(scene: Scene, orders: dict[int, float], curve: float) -> Scene:
    """Return a scene whose encoders read what their true angles are not.

    Args:
        scene: The scene without errors.
        orders: Of joint 2: amplitudes of the sine of so many periods a turn of what is read [rad].
        curve: Amplitude of an error of joint 6 that depends on joints 1 and 3 [rad].
    """
    q1, q2, q3, q4, q6 = (scene.dataset.q[:, k] for k in (0, 1, 2, 3, 5))
    read = q2.copy()
    for _ in range(_ROUNDS):
        read = q2 - sum(size * np.sin(order * read) for order, size in orders.items())
    table = scene.dataset.poses.assign(
        q2=read, q4=q4 / (1 + 1e-3), q6=q6 - curve * np.tanh(3.0 * q1 * q3) if curve else q6
    )
    return replace(scene, dataset=replace(scene.dataset, poses=table))


def diagnosed(scene: Scene, *options: str) -> Run:
    """Return what ``scalar diagnose`` takes for a scene's dataset, its reading and its report included; the memory is that of its largest process."""
    with tempfile.TemporaryDirectory() as folder:
        dataset, out = scene.write(Path(folder) / "dataset"), Path(folder) / "out"
        command = [sys.executable, "-m", "scalar.cli", "diagnose", str(dataset), "-o", str(out), *options]
        start = time.perf_counter()
        peak = peak_memory(command)
        seconds = time.perf_counter() - start
        found = json.loads((out / "diagnosis.json").read_text(encoding="utf-8"))
    return Run(seconds, peak, [effect["name"] for effect in found["effects"]])


def large(with_split: bool) -> None:
    """Print what the diagnosis of 12,000 tracked poses takes; with the outer split as well if asked for, which takes two minutes."""
    print(f"scalar diagnose, {POSES} tracked poses, every candidate, report included; asked for in brackets")
    for arm, make in (("six joints, two effects", tracked), ("seven joints, all orders of one", worst)):
        _print_runs(arm, make, with_split)
    print()


def _print_runs(arm: str, make: Callable[[], Scene], with_split: bool) -> None:
    """Print the lines of one arm."""
    scene = make()
    quick = diagnosed(scene, "--quick")
    timed = f"   (below {MOST_SECONDS:.0f})" if make is tracked else ""
    most = f"(below {MOST_BYTES / _GIB:.0f})"
    print(f"{arm + ', --quick [s]':48s}{quick.seconds:9.1f}{timed}")
    print(f"{'  peak memory [GiB]':48s}{quick.peak_bytes / _GIB:9.2f}   {most}", flush=True)
    run = quick
    if with_split:
        run = diagnosed(scene)
        times = run.seconds / quick.seconds
        print(
            f"{'  with the outer split [s]':48s}{run.seconds:9.1f}   {times:.1f} times (at most {MOST_TIMES:.0f})"
        )
        print(f"{'  peak memory of the largest process [GiB]':48s}{run.peak_bytes / _GIB:9.2f}   {most}")
    print(f"{'  named':48s}  {', '.join(run.named)}", flush=True)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(prog="python -m benchmarks.large")
    parser.add_argument("--split", action="store_true", help="with the outer split as well")
    large(parser.parse_args().split)
