"""What may stand at the place of an output: nothing, or what the same command wrote there before; else --force is needed.

An input is never overwritten. Folders of datasets keep the same rule in ``scalar.data.dataset_writer``.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import click

from scalar.errors import Fault, InvalidInput

FORCE = click.option(
    "--force",
    is_flag=True,
    help="Replace what stands at the output, even if it was written by hand or by others.",
)
_HEAD = 4000  # characters of a file in which what wrote it shows

Own = Callable[[str], bool]
"""Says of the first characters of a file whether they are such as the command writes."""


def json_of(name: str) -> Own:
    """Return the test for a JSON file of a format ``scalar-NAME/...``."""
    return lambda head: f'"format": "scalar-{name}/' in head


def table_with(*columns: str) -> Own:
    """Return the test for a CSV file whose header has these columns, with any units."""
    from scalar.data.table_units import base_name

    def own(head: str) -> bool:
        names = {base_name(name.strip()) for name in head.partition("\n")[0].split(",")}
        return set(columns) <= names

    return own


def text_with(words: str) -> Own:
    """Return the test for a text that begins with a note of these words."""
    return lambda head: words in head


def page(head: str) -> bool:
    """Return whether a page is a report of ours, by what its first characters allow a browser to load."""
    return "Content-Security-Policy" in head and "default-src 'none'" in head


def refuse_foreign(outputs: Sequence[tuple[Path, Own]], force: bool, inputs: Sequence[Path] = ()) -> None:
    """Refuse to write where something stands that is no earlier output of the same command.

    Args:
        outputs: Files to be written, each with the test for such a file. What does not exist is all right.
        force: Whether anything but an input may be replaced.
        inputs: Files that are read, and may never be replaced.

    Raises:
        InvalidInput: With a line for each output that is in the way.
    """
    faults = []
    for path, own in outputs:
        # A folder is refused where it is written; an empty file holds nothing that could be lost.
        if not path.is_file() or not path.stat().st_size:
            continue
        if any(source.exists() and path.samefile(source) for source in inputs):
            faults.append(Fault(str(path), "is read by this command; give another name for the output"))
        elif not force and not own(_head(path)):
            message = "already there, and not written by this command; give another place, or say --force to replace it"
            faults.append(Fault(str(path), message))
    if faults:
        raise InvalidInput(faults)


def refuse_foreign_plan(folder: Path, force: bool) -> None:
    """Refuse a folder whose poses.csv is no earlier plan, as that of a dataset is.

    Raises:
        InvalidInput: With a line for each file that is in the way.
    """
    said = folder / "plan.json"
    ours = json_of("plan")
    earlier = said.is_file() and ours(_head(said))

    def beside_a_plan(_: str) -> bool:
        return earlier

    refuse_foreign(
        [(said, ours), (folder / "poses.csv", beside_a_plan), (folder / "plan.png", beside_a_plan)], force
    )


def _head(path: Path) -> str:
    with path.open("rb") as file:
        return file.read(_HEAD).decode("utf-8", "replace")
