"""Let a workflow that was killed be resumed by a plain call: clear away the locks and marks that the killed Snakemake has left.

Snakemake leaves two things behind when it is killed: a lock on its files, which names no process, and marks on the outputs of the jobs that
ran. Each main process of this workflow holds a record lock of its own on a file in ``.snakemake``, which the system releases when the
process ends, however it ends; a process that is not killed empties the file at its end. A process that gets that lock is the only one that works in
the folder: Snakemake's lock is then stale, and marked outputs are half-written at most. A process that does not get it changes nothing; Snakemake
itself then refuses to start.
"""

from __future__ import annotations

import atexit
import base64
import binascii
import fcntl
import os
import shutil
import time
from pathlib import Path

from scalar.data.io.processes import end_with

OWNER = "scalar-owner.lock"
WORKFLOW_PROCESS = "SCALAR_WORKFLOW_PROCESS"
"""The variable in which a job finds the number of the Snakemake that it works for."""
_ORPHANS_END = 1.2  # s, in which the jobs of a Snakemake that was killed see that it has gone
_held: list[int] = []  # open for as long as this process lives


def take_over(folder: Path) -> bool:
    """Take the lock on the folder of a workflow, and clear away what a killed Snakemake has left in it; return False if another process has it.

    Args:
        folder: Snakemake's own, ``.snakemake``, in the working directory; may be missing.

    Raises:
        OSError: The folder cannot be written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    descriptor = os.open(folder / OWNER, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o644)
    try:
        fcntl.lockf(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        os.close(descriptor)
        return False
    # An empty file: the last process was not killed, or there was none.
    killed = os.pread(descriptor, 1, 0) != b""
    os.ftruncate(descriptor, 0)
    os.pwrite(descriptor, f"{os.getpid()}\n".encode(), 0)
    _held.append(descriptor)
    atexit.register(os.ftruncate, descriptor, 0)
    locks = folder / "locks"
    if killed and locks.is_dir() and any(locks.iterdir()):
        time.sleep(_ORPHANS_END)
        clear_incomplete(folder / "incomplete", folder.parent)
        shutil.rmtree(locks)
    return True


def clear_incomplete(marks: Path, root: Path) -> list[str]:
    """Remove the outputs of jobs that were cut short, then their marks, so that the jobs run again; return the outputs.

    Args:
        marks: Folder in which Snakemake marks the outputs of running jobs: a file each, named by the output's path in base64; a long name is
            cut into folders, all but the last of which begin with ``@``.
        root: What relative paths start from.
    """
    cleared = []
    for mark in sorted(path for path in marks.rglob("*") if path.is_file()):
        name = "".join(part.removeprefix("@") for part in mark.relative_to(marks).parts)
        try:
            output = base64.urlsafe_b64decode(name.encode()).decode()
        except (binascii.Error, UnicodeError, ValueError):  # no mark of an output
            continue
        path = root / output
        if path.is_dir() and not path.is_symlink():
            shutil.rmtree(path)
        else:
            path.unlink(missing_ok=True)
        mark.unlink()
        cleared.append(output)
    return cleared


def end_with_workflow() -> None:
    """Let a job end when the Snakemake that it works for has gone."""
    owner = os.environ.get(WORKFLOW_PROCESS, "")
    if owner.isdecimal():
        end_with(int(owner))
