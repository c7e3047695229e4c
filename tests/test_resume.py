"""Killed anywhere and resumed, the workflow gives the same bytes.

Run by hand, on a machine with nothing else to do: `SCALAR_KILLS=3 pytest tests/test_resume.py` kills a small run;
`SCALAR_KILLS=10 SCALAR_KILL_CONFIG=configs/smoke.yaml pytest tests/test_resume.py` the whole smoke run, ten times.
"""

import hashlib
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.checkouts import UNREPEATABLE, copy_checkout, snakemake

KILLS = int(os.environ.get("SCALAR_KILLS", "2"))
CONFIG = os.environ.get("SCALAR_KILL_CONFIG", "")
SMALL = """
results: results/small
first_seed: 1
seeds_per_job: 1
studies:
  headline:
    {scene: configs/scenes/paper.yaml, grid: configs/grids/smoke.csv, seeds: 2, methods: [baseline-clip, proposed]}
sweeps:
  seeds: 2
  seeds_per_job: 1
  methods: [baseline-clip, proposed]
  walls: {upright: configs/scenes/paper.yaml}
  axes:
    noise: {grid: configs/grids/smoke_noise.csv, key: noise.range_noise_std_m, label: "noise of a point [mm]", factor: 1000}
"""
TARGETS = [f"results/small/{name}" for name in ("headline/numbers.json", "sweeps/numbers.json")]
TARGETS += ["results/small/sweeps/noise/figures/upright.png"]


def contents(folder: Path) -> dict[str, str]:
    """Return the checksum of every file of the results that does not hold times."""
    results = folder / "results"
    paths = [path for path in results.rglob("*") if path.is_file() and path.name != ".snakemake_timestamp"]
    return {
        str(path.relative_to(results)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in paths
        if path.relative_to(results).parts[1] not in UNREPEATABLE
    }


def killed(folder: Path, arguments: list[str], after: float, how: signal.Signals, whole_group: bool) -> bool:
    """Start the workflow and kill it after some seconds, alone or with all its jobs; False if it had ended by then."""
    command = [
        sys.executable,
        "-m",
        "snakemake",
        "--cores",
        "2",
        "--nocolor",
        *arguments,
    ]
    with open(folder / "output.txt", "w") as output:
        running = subprocess.Popen(command, cwd=folder, stdout=output, stderr=output, start_new_session=True)
        try:
            assert running.wait(after) == 0, (folder / "output.txt").read_text()
            return False
        except subprocess.TimeoutExpired:
            (os.killpg if whole_group else os.kill)(running.pid, how)
            running.wait()
            return True


@pytest.mark.slow
@pytest.mark.skipif("SCALAR_KILLS" not in os.environ, reason="by hand: SCALAR_KILLS=3")
def test_killed_anywhere_and_resumed_it_gives_the_same_bytes(tmp_path):
    """After SIGKILL or SIGTERM at random moments, to Snakemake alone or to its jobs too, a plain call completes the run with the same bytes."""
    folders = [copy_checkout(tmp_path / name) for name in ("whole", "killed")]
    arguments = ["--configfile", CONFIG] if CONFIG else [*TARGETS, "--configfile", "configs/small.yaml"]
    for folder in folders:
        (folder / "configs/small.yaml").write_text(SMALL)
    started = time.monotonic()
    ran = snakemake(folders[0], *arguments)
    assert ran.returncode == 0, ran.stdout
    length = time.monotonic() - started
    expected = contents(folders[0])
    rng = random.Random(KILLS)
    kills = 0
    while kills < KILLS:
        # Each time it gets on a little; the moments spread over the run, whatever is left of it.
        how, whole_group = rng.choice([signal.SIGKILL, signal.SIGTERM]), rng.random() < 0.5
        moment = rng.uniform(0.0, 1.0) * length * max(2.0 / KILLS, 0.2)
        if killed(folders[1], arguments, moment, how, whole_group):
            kills += 1
        else:
            assert contents(folders[1]) == expected
            assert snakemake(folders[1], "--delete-all-output", *arguments).returncode == 0
    ran = snakemake(folders[1], *arguments)
    assert ran.returncode == 0, ran.stdout
    print(f"killed {kills} times in a run of {length:.0f} s, {len(expected)} files the same")
    assert contents(folders[1]) == expected
