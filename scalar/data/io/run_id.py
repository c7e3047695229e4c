"""The run that each file of a result names, so that files of two runs are not taken for one result.

A result of several files is written file by file, its index last. A run that is killed between two of them leaves files of two runs in
one folder, each whole. Every file of a result therefore names its run, and a reader of one file compares its run with that of the index in
the same folder. A run is named by a checksum of its results, not by its time, so that the same input gives the same bytes.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from scalar.errors import Fault, InvalidInput

RUN = "run"
"""The key of a run in a JSON file of a result, right after ``format``."""
INDEX = "diagnosis.json"
"""The file of a diagnosis that is written last."""
DIAGNOSIS_FILES = ("before.json", "after.json", INDEX)
_HEAD = 400  # bytes at the start of a file that contain the name of its run
_SOURCE = re.compile(rb"^source: .*, run ([0-9a-f]{16})\"?\s*$", re.MULTILINE)
_NAMED = re.compile(rb'\A\{\s*"format": "[^"]*",\s*"run": "([0-9a-f]{16})"')


def run_of(*contents: Any) -> str:
    """Return the name of the run whose files have these contents: plain data, in the order of the files."""
    total = hashlib.sha256()
    for content in contents:
        total.update(json.dumps(content, allow_nan=True, sort_keys=False, default=list).encode())
    return total.hexdigest()[:16]


def with_run(content: Mapping[str, Any], run: str) -> dict[str, Any]:
    """Return the content of a JSON file with its run after its format."""
    return {"format": content["format"], RUN: run, **content}


def check_run(path: Path) -> None:
    """Refuse a file of a diagnosis if another file of the diagnosis, in the same folder, is of another run.

    Files that name no run, as earlier releases wrote them, are not compared.

    Args:
        path: The file that is being read.

    Raises:
        InvalidInput: The runs differ.
    """
    if path.name not in DIAGNOSIS_FILES:
        return
    run = _run_named_in(path)
    others = [name for name in DIAGNOSIS_FILES if name != path.name] if path.name == INDEX else [INDEX]
    for other in others:
        found = _run_named_in(path.with_name(other))
        if run is not None and found is not None and found != run:
            message = (
                f"is of run {run}, and {other} in the same folder of run {found}: a run was stopped while it wrote, or files of two were "
                "put together; diagnose again"
            )
            raise InvalidInput(Fault(str(path), message, None, RUN))


def source_with_run(source: str, run: str) -> str:
    """Return the ``source`` of a simulated dataset, with the run that made it and its truth."""
    return f"{source}, run {run}"


def check_truth_run(truth: Path, run: object) -> None:
    """Refuse a truth if the dataset in the folder ``dataset`` next to it is of another run.

    Args:
        truth: The folder of the truth.
        run: The run that its ``truth.json`` names; None if it names none.

    Raises:
        InvalidInput: The runs differ.
    """
    description = truth.parent / "dataset" / "dataset.yaml"
    if truth.name != "truth" or not isinstance(run, str) or not description.is_file():
        return
    with suppress(OSError), open(description, "rb") as file:
        found = _SOURCE.search(file.read(_HEAD))
        if found is not None and found[1].decode() != run:
            message = (
                f"is of run {run}, and the dataset in the same folder of run {found[1].decode()}: a run was stopped while it wrote; "
                "simulate again"
            )
            raise InvalidInput(Fault(str(truth / "truth.json"), message, None, RUN))


def _run_named_in(path: Path) -> str | None:
    if not path.is_file():
        return None
    try:
        with open(path, "rb") as file:
            found = _NAMED.match(file.read(_HEAD))
    except OSError:
        return None
    return found[1].decode() if found else None
