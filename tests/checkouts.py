"""Copies of the checkout in which a test may run the workflow and edit modules and configs."""

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

ROOT = Path(__file__).parents[1]
SMOKE = ("--configfile", "configs/smoke.yaml")  # a config with which every rule runs, small
RESULTS = Path("results/smoke")  # where that config has its results
UNREPEATABLE = ("logs", "benchmarks", "claims")
"""Folders of the results whose files hold times, and so differ from run to run: one claim is judged by a time."""


def copy_checkout(to: Path) -> Path:
    """Copy to a folder what the workflow needs, without results, and return the folder."""
    for name in ("scalar", "workflow", "configs", "paper"):
        shutil.copytree(ROOT / name, to / name, ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("Snakefile", "CITATION.cff"):
        shutil.copy(ROOT / name, to)
    table = Path("benchmarks/diagnosis/results.csv")  # that the paper reads
    (to / table).parent.mkdir(parents=True)
    shutil.copy(ROOT / table, to / table)
    return to


def snakemake(folder: Path, *arguments: str, cores: int = 2) -> subprocess.CompletedProcess[str]:
    """Return the finished run of snakemake in a folder, its stdout and stderr as one text."""
    command = [sys.executable, "-m", "snakemake", "--cores", str(cores), "--nocolor", *arguments]
    return subprocess.run(
        command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False
    )


def jobs(output: str) -> dict[str, int]:
    """Return {rule: number of jobs} from the table that snakemake prints, without the rules that only gather files."""
    found = re.search(r"^job +count\n-[- ]+\n(.*?)^total", output, re.MULTILINE | re.DOTALL)
    table = (
        {name: int(count) for name, count in (line.split() for line in found[1].splitlines())}
        if found
        else {}
    )
    return {name: count for name, count in table.items() if name not in ("all", "figures")}


def planned(folder: Path, *arguments: str) -> dict[str, int]:
    """Return {rule: number of jobs} that a run with the small config would start now."""
    ran = snakemake(folder, "--dry-run", *SMOKE, *arguments)
    assert ran.returncode == 0, ran.stdout
    return jobs(ran.stdout)


@contextmanager
def edited(path: Path, old: str, new: str) -> Iterator[None]:
    """Replace the first occurrence of a text in a file within a ``with`` block; then restore the file and its time stamp."""
    text, times = path.read_text(encoding="utf-8"), path.stat()
    assert old in text
    path.write_text(text.replace(old, new, 1), encoding="utf-8")
    try:
        yield
    finally:
        path.write_text(text, encoding="utf-8")
        os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))
