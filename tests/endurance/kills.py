"""Kill the commands and the workflow at random moments, look at what is left, and run them again.

    python -m tests.endurance.kills --kills 50 --table kills.csv

A result of another dataset lies in the folder already, so that a kill may leave files of two runs; a command that replaces nothing starts without.
After each kill every file is whole: that of the first result or that of the second, byte by byte; files of two runs are refused by the command that
reads them; a plain second call succeeds, gives the bytes of an undisturbed run, and leaves nothing hidden. The workflow (``killed_workflow``) starts
from nothing each time.
"""

from __future__ import annotations

import argparse
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from tests.endurance import killed_workflow
from tests.endurance.killed_commands import COMMANDS, NEVER_REPLACE, SCALAR, command, write_datasets
from tests.endurance.outcome import HOWS, Outcome

WORKFLOW = "snakemake"


def contents(folder: Path) -> dict[str, bytes]:
    """Return every file below a folder that is not hidden, by its name."""
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and not any(part.startswith(".") for part in path.relative_to(folder).parts)
    }


def hidden(folder: Path) -> list[str]:
    """Return the names of everything hidden below a folder."""
    return sorted(str(path.relative_to(folder)) for path in folder.rglob(".*"))


def run(arguments: Sequence[str]) -> tuple[int, str]:
    """Return the exit status of a command and what it said on stderr."""
    done = subprocess.run(arguments, capture_output=True, text=True, check=False)
    return done.returncode, done.stderr


def killed(arguments: Sequence[str], after: float, how: signal.Signals, whole_group: bool) -> bool:
    """Start a command and kill it after some seconds, alone or with what it started; False if it had ended by then."""
    process = subprocess.Popen(
        arguments, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True
    )
    try:
        process.wait(after)
        return False
    except subprocess.TimeoutExpired:
        (os.killpg if whole_group else os.kill)(process.pid, how)
        process.wait()
        return True


def endure(name: str, datasets: tuple[Path, Path], kills: int, rng: random.Random, root: Path) -> Outcome:
    """Return the outcome of killing one command some times.

    Args:
        name: Key of ``COMMANDS``.
        datasets: The first has been run before; the run of the second is killed.
        kills: How many have to meet a living process.
        rng: Draws moments, signals, and whether the process group is killed.
        root: Folder to work in.
    """
    old, new, out = root / "old", root / "new", root / "out"
    for folder in (old, new, out):
        shutil.rmtree(folder, ignore_errors=True)
    for folder, data in ((old, datasets[0]), (new, datasets[1])):
        folder.mkdir(parents=True)
        if folder is old and name in NEVER_REPLACE:
            continue
        started = time.monotonic()
        status, said = run(command(name, data, folder))
        length = time.monotonic() - started
        if status != 0:
            return Outcome(faults=[f"{name}: undisturbed, it ended with {status}: {said.strip()[:200]}"])
    of_old, of_new = contents(old), contents(new)
    outcome = Outcome()
    while outcome.kills < kills:
        shutil.rmtree(out, ignore_errors=True)
        shutil.copytree(old, out)
        # Most of the time nothing is written: every other kill falls into the last tenth.
        begin = 0.9 if rng.random() < 0.5 else 0.0
        how, whole_group = rng.choice(HOWS), rng.random() < 0.5
        if not killed(command(name, datasets[1], out), length * rng.uniform(begin, 1.05), how, whole_group):
            continue
        case = outcome.killed(name, how, whole_group)
        left = contents(out)
        outcome.partial += (
            0 < sum(left.get(file) == of_new[file] != of_old.get(file) for file in of_new) < len(of_new)
        )
        for file, content in left.items():
            if content not in (of_old.get(file), of_new.get(file)):
                outcome.faults.append(f"{case}: {file} is neither of the old run nor of the new")
        if any(name not in left for name in of_old.keys() & of_new.keys()):
            outcome.faults.append(f"{case}: a file of the old run is gone, and no new one there")
        if name.startswith("diagnose") and "--batch" not in name:
            _read_a_mix(out, left, of_new, datasets[1], outcome, case)
        if (
            name in NEVER_REPLACE and left == of_new
        ):  # it was done, and a second call would refuse to replace it
            continue
        status, said = run(command(name, datasets[1], out))
        if status != 0:
            outcome.faults.append(f"{case}: the second call ended with {status}: {said.strip()[:200]}")
        elif {**of_old, **of_new} != contents(out):
            outcome.faults.append(f"{case}: the second call gave other bytes")
        if hidden(out):
            outcome.faults.append(f"{case}: left hidden after the second call: {', '.join(hidden(out))}")
    for folder in (old, new, out):
        shutil.rmtree(folder)
    return outcome


def _read_a_mix(
    out: Path, left: dict[str, bytes], of_new: dict[str, bytes], data: Path, outcome: Outcome, case: str
) -> None:
    """If the folder holds a calibration of the new run and the diagnosis of the old, count it, and whether ``predict`` refuses the calibration."""
    new = [file for file in ("before.json", "after.json") if left[file] == of_new[file]]
    if not new or left["diagnosis.json"] == of_new["diagnosis.json"]:
        return
    outcome.left += 1
    status, said = run(
        [
            *SCALAR,
            "predict",
            str(out / new[-1]),
            str(data / "poses.csv"),
            "-o",
            str(out.parent / "frames.csv"),
        ]
    )
    if status == 2 and "of run" in said:
        outcome.refused += 1
    else:
        outcome.faults.append(f"{case}: {new[-1]} of the new run was read beside diagnosis.json of the old")


def main() -> None:
    """Run from the command line; exit status 1 if anything was not as it should be."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kills", type=int, default=50, help="of all commands together")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", nargs="*", choices=[*COMMANDS, WORKFLOW], default=[*COMMANDS, WORKFLOW])
    parser.add_argument("--table", type=Path, help="CSV file that gets a row for each command")
    wanted = parser.parse_args()
    rng = random.Random(wanted.seed)
    shares = Counter(wanted.only[k % len(wanted.only)] for k in range(wanted.kills))
    rows, faults = [], 0
    with tempfile.TemporaryDirectory() as folder:
        datasets = write_datasets(Path(folder) / "data")
        for name, kills in shares.items():
            if name == WORKFLOW:
                outcome = killed_workflow.endure(kills, rng, Path(folder) / "workflow")
            else:
                outcome = endure(name, datasets, kills, rng, Path(folder))
            print(
                f"{name:18s} {outcome.kills:4d} kills, {outcome.left} left files of two runs, {outcome.refused} of these refused, "
                f"{len(outcome.faults)} faults",
                *outcome.faults,
                sep="\n",
                flush=True,
            )
            rows.append(outcome.row(name))
            faults += len(outcome.faults)
            if wanted.table:
                pd.DataFrame(rows).to_csv(wanted.table, index=False)
    print(f"{sum(row['kills'] for row in rows)} kills, {faults} faults")
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
