"""Diagnose a fleet of small campaigns: time, memory, files and rows, with a kill in the middle and a resumption, and one damaged folder in ten.

python -m benchmarks.fleet --campaigns 1000 --kill-after 120
"""

from __future__ import annotations

import argparse
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

import pandas as pd

from benchmarks.peak import peak_command
from tests.random_scene import make_scene

POSES_PER_CAMPAIGN = 18
DAMAGED = 10  # one folder in so many
_DAMAGES = ("no table of points", "a word for a number", "an empty description")


def write_fleet(folder: Path, campaigns: int) -> None:
    """Write campaigns of a tracker, each of another arm; every tenth is damaged in one of three ways."""
    for k in range(campaigns):
        place = folder / f"arm-{k:05d}"
        scene = make_scene("vs060", "tracker", seed=k, poses_per_plane=POSES_PER_CAMPAIGN // 3, noise=2e-5)
        scene.write(place)
        if k % DAMAGED == DAMAGED - 1:
            _damage(place, k // DAMAGED % len(_DAMAGES))


def _damage(place: Path, kind: int) -> None:
    """Damage a dataset in one of the ways of ``_DAMAGES``."""
    if kind == 0:
        (place / "points.csv").unlink()
    elif kind == 1:
        table = (place / "poses.csv").read_text(encoding="utf-8").splitlines()
        table[2] = "2,one" + table[2][table[2].index(",", 2) :]
        (place / "poses.csv").write_text("\n".join(table) + "\n", encoding="utf-8")
    else:
        (place / "dataset.yaml").write_text("", encoding="utf-8")


def fleet(campaigns: int, kill_after: float | None) -> None:
    """Print what a batch takes; with ``kill_after`` [s] it is killed then, and continued by a plain second call."""
    with tempfile.TemporaryDirectory() as name:
        data, out = Path(name) / "campaigns", Path(name) / "fleet"
        write_fleet(data, campaigns)
        command = [
            sys.executable,
            "-m",
            "scalar.cli",
            "diagnose",
            "--batch",
            str(data),
            "-o",
            str(out),
            "--quick",
        ]
        if kill_after is not None:
            _killed(command, kill_after)
            done = sum(1 for _ in out.glob("*/diagnosis.json"))
            print(f"killed after {kill_after:.0f} s with {done} campaigns done", flush=True)
        for call in ("to the end", "once more"):
            start, before = time.perf_counter(), os.times()
            status, peak = peak_command(command)
            spent, after = time.perf_counter() - start, os.times()
            cpu = after.children_user - before.children_user + after.children_system - before.children_system
            table = pd.read_csv(out / "fleet.csv")
            print(
                f"{call}: exit status {status}, {spent:.0f} s, processor time {cpu:.0f} s, largest process {peak / 1024**2:.0f} MiB, "
                f"{len(table)} rows",
                flush=True,
            )
        files = [path for path in out.rglob("*") if path.is_file()]
        size = sum(path.stat().st_size for path in files)
        print(
            f"{len(files)} files, {size / 1024**2:.0f} MiB; hidden: {sum(f.name.startswith('.') for f in files)}"
        )
        for column in ("status", "verdict"):
            if column in table:
                print(column, dict(Counter(table[column].fillna("none"))))
        print("columns:", ", ".join(table.columns))


def _killed(command: list[str], after: float) -> None:
    """Start a command and kill its whole group after some seconds."""
    process = subprocess.Popen(
        command, start_new_session=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    try:
        process.wait(after)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()


if __name__ == "__main__":
    parser = argparse.ArgumentParser(prog="python -m benchmarks.fleet")
    parser.add_argument("--campaigns", type=int, default=1000)
    parser.add_argument("--kill-after", type=float, help="seconds after which the first call is killed")
    wanted = parser.parse_args()
    fleet(wanted.campaigns, wanted.kill_after)
