"""`make test-slurm`: a sweep on a real Slurm cluster gives the bytes of one machine, though a job and a node are killed on the way.

Not part of `make test`. ``CASES`` (200), ``IN_A_JOB`` (10) and ``SLURM_LOGS`` (results/slurm) may be set in the environment.
"""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from tests.checkouts import copy_checkout
from tests.slurm.cluster import Cluster, MissingPackages, cluster, copy_logs
from tests.test_resume import contents

CASES = int(os.environ.get("CASES", "200"))
IN_A_JOB = int(os.environ.get("IN_A_JOB", "10"))  # jobs of Snakemake, of a few cases each, in one of Slurm
LOGS = Path(os.environ.get("SLURM_LOGS", "results/slurm"))
SWEEP = """
results: results/slurm
first_seed: 1
seeds_per_job: 1
studies:
  headline:
    {scene: configs/scenes/paper.yaml, grid: configs/grids/smoke.csv, seeds: 1, methods: [proposed]}
sweeps:
  seeds: 1
  seeds_per_job: 1
  methods: [proposed]
  walls: {upright: configs/scenes/paper.yaml}
  axes:
    noise: {grid: configs/grids/many.csv, key: noise.range_noise_std_m, label: "noise of a point [mm]", factor: 1000}
"""
TARGET = "results/slurm/sweeps/noise/errors.csv"
PROFILE = ("--profile", "workflow/profiles/slurm", "--default-resources", "runtime=15", "mem_mb=500")
WITHOUT_DATABASE = (
    "--slurm-status-command", "squeue", "--slurm-init-seconds-before-status-checks", "2", "--slurm-no-account",
    "--seconds-between-status-checks", "2", "--latency-wait", "20",
)  # fmt: skip
# Without a limit of memory within a group, Snakemake asks for the cores and the memory of all of its jobs at once, which no node here has.
GROUPED = (
    "--groups", "sweep=cases", "--group-components", f"cases={IN_A_JOB}",
    "--resources", "mem_mb=500", "--set-resource-scopes", "mem_mb=local",
)  # fmt: skip


def write_sweep(folder: Path) -> None:
    """Write the config of a sweep and its grid."""
    (folder / "configs/slurm.yaml").write_text(SWEEP)
    lines = ["case,noise.range_noise_std_m,poses_per_plane,sensor.points_per_scan,truth_poses"]
    lines += [f"sigma-{k:03d},{1e-6 * (k + 1):.3g},14,20,100" for k in range(CASES)]
    (folder / "configs/grids/many.csv").write_text("\n".join(lines) + "\n")


def arguments(*more: str) -> list[str]:
    """Return the command line of Snakemake."""
    return [
        sys.executable,
        "-m",
        "snakemake",
        TARGET,
        "--configfile",
        "configs/slurm.yaml",
        "--nocolor",
        *more,
    ]


def say(text: str) -> None:
    """Print a line with the time."""
    print(f"{time.strftime('%H:%M:%S')} {text}", flush=True)


def disturbed(running: subprocess.Popen[bytes], slurm: Cluster) -> list[str]:
    """Kill a job and later a node while the workflow runs, and bring the node back; return what was done.

    Raises:
        RuntimeError: A job asks for more than any node has, and would wait for ever.
    """
    done: list[str] = []
    while running.poll() is None:
        time.sleep(2)
        if "PartitionConfig" in slurm.run("squeue", "-h", "-t", "PENDING", "-o", "%r"):
            raise RuntimeError(
                "a job asks for more cores or memory than any node has:\n"
                + slurm.run("scontrol", "show", "job")
            )
        busy = slurm.jobs()
        if not done and busy:
            time.sleep(3)
            slurm.run("scancel", "--signal=KILL", "--full", busy[0][0])
            done.append(f"job {busy[0][0]} killed on {busy[0][1]}")
            say(done[-1])
        elif len(done) == 1 and any(node == "second" for _, node in busy):
            time.sleep(3)
            slurm.kill_node("second")
            done.append("node second killed, with its jobs " + ", ".join(j for j, n in busy if n == "second"))
            say(done[-1])
            slurm.start_node("second")
            say("node second is back")
    return done


def main() -> int:
    """Return the exit status."""
    for number in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP):
        signal.signal(number, lambda *_: sys.exit(1))  # so that no daemon outlives this process
    folder = Path(tempfile.mkdtemp(prefix="slurm-", dir="/tmp"))  # sockets need short paths
    try:
        alone, spread, root = (folder / name for name in ("alone", "spread", "cluster"))
        root.mkdir()
        with cluster(root, ("first", "second"), cores=1) as slurm:
            try:
                say("slurmctld and two slurmd are up: " + slurm.run("sinfo", "--version").strip())
                for checkout in (alone, spread):
                    write_sweep(copy_checkout(checkout))
                started = time.monotonic()
                with open(folder / "alone.log", "wb") as log:
                    status = subprocess.run(
                        arguments("--cores", "2"), cwd=alone, stdout=log, stderr=log, check=False
                    ).returncode
                say(f"{CASES} cases on one machine: status {status}, {time.monotonic() - started:.0f} s")
                started = time.monotonic()
                with open(folder / "spread.log", "wb") as log:
                    running = subprocess.Popen(
                        arguments(*PROFILE, *WITHOUT_DATABASE, *GROUPED),
                        cwd=spread,
                        env=slurm.environment,
                        stdout=log,
                        stderr=log,
                    )
                    try:
                        done = disturbed(running, slurm)
                    finally:  # where this process is stopped, Snakemake would wait for ever for a cluster that is gone
                        running.kill()  # asked to end, it waits for its jobs
                        running.wait()
                say(
                    f"{CASES} cases by Slurm: status {running.returncode}, {time.monotonic() - started:.0f} s"
                )
                jobs = (root / "jobs.txt").read_text().count("JobId=") if (root / "jobs.txt").exists() else 0
                same = contents(alone) == contents(spread)
                say(
                    f"{jobs} Slurm jobs; {len(contents(spread))} files, {'all the same' if same else 'NOT the same'} bytes"
                )
                failed = [
                    what
                    for what, wrong in (
                        ("the run on one machine failed", status != 0),
                        ("the run by Slurm failed", running.returncode != 0),
                        ("the bytes differ", not same),
                        ("no job and no node could be killed in time: more CASES", len(done) < 2),
                    )
                    if wrong
                ]
                for what in failed:
                    say(what)
                return 1 if failed else 0
            finally:
                copy_logs(root, LOGS)
                for name in ("alone.log", "spread.log"):
                    if (folder / name).exists():
                        shutil.copy(folder / name, LOGS)
                # What a job said itself: the controller knows no more than that it failed.
                if (of_jobs := spread / ".snakemake/slurm_logs").exists():
                    shutil.copytree(of_jobs, LOGS / "jobs", dirs_exist_ok=True)
    except MissingPackages as error:
        print(error, file=sys.stderr)
        return 1
    finally:
        shutil.rmtree(folder, ignore_errors=True)


if __name__ == "__main__":
    sys.exit(main())
