"""Protect files that exist already: without --force, a command replaces only files of the kind that it writes.

A file that the command reads is not replaced even with --force, if it is given as an input. For folders of datasets,
``scalar.data.dataset_writer`` applies the same rule.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from pathlib import Path

import click

from scalar.errors import Fault, InvalidInput

FORCE = click.option(
    "--force",
    is_flag=True,
    help="Replace files at the output even if this command did not write them.",
)
_HEAD = 4000  # bytes at the beginning of a file, from which the command that wrote it is recognised

_SPREADSHEETS = (".xlsx", ".xlsm", ".xls", ".ods")

Own = Callable[[str], bool]
"""Takes the beginning of a file, and returns whether the command writes such files."""


def json_of(name: str) -> Own:
    """Return the function that recognises a JSON file of a format ``scalar-NAME/...``."""
    return lambda head: f'"format": "scalar-{name}/' in head


def table_with(*columns: str) -> Own:
    """Return the function that recognises a CSV file whose header has these columns, with any units."""
    from scalar.data.table_units import base_name

    def own(head: str) -> bool:
        names = {base_name(name.strip()) for name in re.split("[,;]", head.partition("\n")[0])}
        return set(columns) <= names

    return own


def text_with(words: str) -> Own:
    """Return the function that recognises a text with these words near its beginning."""
    return lambda head: words in head


def is_report(head: str) -> bool:
    """Return whether text from the beginning of a file is that of a report of this package: its HTML forbids browsers to load anything."""
    return "Content-Security-Policy" in head and "default-src 'none'" in head


def refuse_foreign(outputs: Sequence[tuple[Path, Own]], force: bool, inputs: Sequence[Path] = ()) -> None:
    """Refuse to replace inputs and, without ``force``, files that the command does not write.

    Args:
        outputs: Files to be written, which need not exist, each with the function that recognises such a file.
        force: Whether any file except an input may be replaced.
        inputs: Files that are read, and may never be replaced.

    Raises:
        InvalidInput: There are such files; it has one fault for each. Or a path leads to a folder, a pipe or a device.
    """
    from scalar.data.io.regular_file import refuse_special

    faults = []
    for path, own in outputs:
        refuse_special(path)
        if path.suffix.lower() in _SPREADSHEETS:
            message = f"the name of a spreadsheet, and this command writes text; give another one, such as {path.stem}.csv, which spreadsheets open"
            faults.append(Fault(str(path), message))
            continue
        # An empty file has no content that could be lost.
        if not path.is_file() or not path.stat().st_size:
            continue
        if any(source.exists() and path.samefile(source) for source in inputs):
            faults.append(Fault(str(path), "is read by this command; give another name for the output"))
        elif not force and not own(_head(path)):
            message = "already there, and not written by this command; give another place, or say --force to replace it"
            faults.append(Fault(str(path), message))
    if faults:
        raise InvalidInput(faults)


def refuse_foreign_plan(folder: Path, force: bool, inputs: Sequence[Path] = ()) -> None:
    """Refuse to replace inputs by a plan and, without ``force``, files that are no earlier plan, such as the poses.csv of a dataset.

    Args:
        folder: The folder to which the plan is written.
        force: Whether any file except an input may be replaced.
        inputs: Files that are read, and may never be replaced.

    Raises:
        InvalidInput: There are such files; it has one fault for each.
    """
    index = folder / "plan.json"
    is_plan = json_of("plan")
    has_plan = index.is_file() and is_plan(_head(index))

    def of_the_plan(_: str) -> bool:
        return has_plan

    refuse_foreign(
        [
            (index, is_plan),
            (folder / "poses.csv", of_the_plan),
            (folder / "poses_deg.csv", of_the_plan),
            (folder / "plan.png", of_the_plan),
        ],
        force,
        inputs,
    )


def _head(path: Path) -> str:
    """Return the beginning of a file as text."""
    with path.open("rb") as file:
        return file.read(_HEAD).decode("utf-8", "replace")
