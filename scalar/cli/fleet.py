"""The diagnoses of a fleet: a process for each dataset, as many at once as there are processors, each result whole or not at all.

Each dataset has a process of its own, not one of a pool: if a process is killed, for lack of memory say, the other datasets are not affected. The
line of the table is written with the result, so a run that was stopped can be continued: a finished result for the same files, options
and release is not computed again.
"""

from __future__ import annotations

import gc
import hashlib
import json
import os
import signal
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from multiprocessing import get_all_start_methods, get_context
from multiprocessing.connection import wait
from pathlib import Path
from typing import TYPE_CHECKING, Any

from scalar.cli import unexpected
from scalar.data.io.processes import end_with
from scalar.data.io.temporary import sweep
from scalar.errors import ScalarError

if TYPE_CHECKING:
    from multiprocessing.context import ForkProcess, SpawnProcess

RESULT = "batch.json"
"""File in the folder of each result, with its line of the table, and checksums of that line and of what it was made from; where it exists, the
result is complete."""
FORMAT = "scalar-batch/3"


@dataclass(frozen=True)
class Job:
    """One dataset of a fleet.

    Attributes:
        name: Name in the table.
        dataset: Folder of the dataset.
        output: Folder of its result.
        folds: Number of parts of the outer split; 0 for a quick answer.
        modules: Files with effects from outside the package.
    """

    name: str
    dataset: Path
    output: Path
    folds: int
    modules: tuple[Path, ...]


def run_all(
    jobs: Sequence[Job], cores: int, done: Callable[[int, Mapping[str, Any]], None]
) -> list[dict[str, Any]]:
    """Return the lines of the table, in the order of the jobs.

    Args:
        jobs: The jobs; results that are finished already are read.
        cores: Number of jobs that run at once.
        done: Called with the index of each job and its line when it is finished.
    """
    _sweep_output_folders(jobs)
    method = "fork" if "fork" in get_all_start_methods() else "spawn"
    context: Any = get_context(method)
    rows: dict[int, dict[str, Any]] = {}
    waiting = list(range(len(jobs)))[::-1]
    running: dict[int, tuple[int, ForkProcess | SpawnProcess]] = {}
    cores_each = max(1, cores // max(len(jobs), 1))

    def finished(k: int, row: dict[str, Any]) -> None:
        rows[k] = {"folder": jobs[k].name, **row}
        done(k, rows[k])

    try:
        while waiting or running:
            while waiting and len(running) < cores:
                k = waiting.pop()
                made = finished_row(jobs[k])
                if made is not None:
                    finished(k, made)
                    continue
                process = context.Process(
                    target=_work, args=(jobs[k], cores_each, os.getpid(), method != "fork")
                )
                process.start()
                running[process.sentinel] = (k, process)
            for sentinel in wait(list(running)) if running else ():
                k, process = running.pop(sentinel)  # pyright: ignore[reportArgumentType]
                process.join()
                finished(k, finished_row(jobs[k], again=True) or _lost(process.exitcode))
    finally:
        for _, process in running.values():
            process.terminate()
        for _, process in running.values():
            process.join()
        # Processes of a killed run may have written for a moment after the first sweep.
        _sweep_output_folders(jobs)
    return [rows[k] for k in range(len(jobs))]


def _sweep_output_folders(jobs: Sequence[Job]) -> None:
    """Remove the temporary files that killed runs have left next to the results."""
    for folder in {job.output.parent for job in jobs}:
        sweep(folder)


def finished_row(job: Job, *, again: bool = False) -> dict[str, Any] | None:
    """Return the line of a result that is complete and was made from the same files with the same options; else None.

    Args:
        job: The job whose result is read.
        again: Whether this run has made the result. A fault of the software then counts as a result; from an earlier run it does not, so that the
            job is tried again.
    """
    from scalar.data.io.json_reader import read_json

    try:
        content = read_json(job.output / RESULT)
        row = content["row"]
        status = int(row["status"])
        stale = content != content_of_result(job, row)
    except (ScalarError, OSError, KeyError, TypeError, ValueError):
        return None
    return None if stale or (status == unexpected.EXIT_STATUS and not again) else dict(row)


def content_of_result(job: Job, row: Mapping[str, Any], source: str | None = None) -> dict[str, Any]:
    """Return the content of the file of a result.

    Args:
        job: The job.
        row: Its line of the table.
        source: What ``made_from`` returned before the files were read; None: what it returns now.
    """
    checksum = hashlib.sha256(json.dumps(row, sort_keys=True).encode()).hexdigest()
    return {"format": FORMAT, "source": source or made_from(job), "row": row, "checksum": checksum}


def made_from(job: Job) -> str:
    """Return a checksum of all that a result depends on: release, options, effects from outside, and every file of the dataset."""
    from scalar import __version__

    total = hashlib.sha256(f"{__version__} {job.folds}".encode())
    for path in (*job.modules, *_files_in(job.dataset)):
        total.update(f"{path.name}\0".encode(errors="surrogateescape"))
        try:
            with open(path, "rb") as file:
                total.update(hashlib.file_digest(file, "sha256").digest())
        except OSError as error:
            total.update(str(error.errno).encode())
    return total.hexdigest()


def _files_in(folder: Path) -> list[Path]:
    """Return the files in a folder by their names; none if it cannot be read, which reading the dataset then reports."""
    try:
        return sorted(path for path in folder.iterdir() if os.path.isfile(path))
    except OSError:
        return []


def _work(job: Job, cores: int, parent: int, load: bool) -> None:
    """Diagnose one dataset, in a process of its own, and write its folder of results, whole or not at all."""
    from scalar.data.io.atomic import atomic_directory, json_content, write_json, write_together

    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the process that started this one ends it
    end_with(parent)
    gc.freeze()  # what was loaded before the fork is no garbage, and searching it would copy it for this process
    source = made_from(job)
    if load:  # a forked process has the effects already
        from scalar.cli.options import load_effects

        load_effects(job.modules)
    try:
        with atomic_directory(job.output, lambda folder: (folder / RESULT).is_file()) as folder:
            row, files = _answer(job, cores)
            write_together(folder, files)
            write_json(folder / RESULT, content_of_result(job, json_content(row), source))
    except (ScalarError, OSError):  # nothing can be written there; the caller sees that there is no result
        sys.exit(1)


def _answer(job: Job, cores: int) -> tuple[dict[str, Any], dict[str, str]]:
    """Return the line of the table, and the content of the files of a diagnosis by their names, or no files if there is no diagnosis.

    Nothing is written here: that a disk is full is no answer about the dataset, and must not be kept as one.
    """
    from scalar.data.dataset import read_dataset
    from scalar.diagnosis import diagnose
    from scalar.report.fleet_row import row_of, row_of_refusal
    from scalar.report.output import files_of_diagnosis

    try:
        diagnosis = diagnose(read_dataset(job.dataset), outer_folds=job.folds, cores=cores)
        return row_of(diagnosis), files_of_diagnosis(diagnosis)
    except ScalarError as error:
        return row_of_refusal(error), {}
    except OSError:
        raise
    except Exception as error:
        what = " ".join([type(error).__name__, *str(error).split()])[:200]
        message = f"a fault of this program ({what}), not of the data; 'scalar diagnose' on this folder alone says how to report it"
        return {"status": unexpected.EXIT_STATUS, "message": message}, {}


def _lost(code: int | None) -> dict[str, Any]:
    """Return the line of a process that ended without a result."""
    why = f"by signal {-code}" if code is not None and code < 0 else f"with status {code}"
    message = f"its process ended {why} and left no result, perhaps because memory or disk space ran out; run the same command again"
    return {"status": unexpected.EXIT_STATUS, "message": message}
