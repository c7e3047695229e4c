"""Compile the paper from its text and the results with Typst, in a temporary folder; the same inputs give the same bytes.

All files are copied below one root, since Typst reads nothing outside it: the folder ``paper/``, and ``results/``
with the numbers and figures. The fonts of the machine, the date and the network are not used, so that the bytes depend on the inputs alone.
"""

from __future__ import annotations

import datetime
import json
import shutil
import tempfile
import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Literal

from scalar.data.io.atomic import atomic_write, write_json
from scalar.errors import Fault, InvalidInput
from study.paper.layout import layout_faults

MAIN = "paper/paper.typ"
NUMBERS = "results/numbers.json"
FILES = "results/files.json"
CREATED = datetime.datetime(2018, 10, 1, tzinfo=datetime.UTC)
"""The date of creation in a PDF: always the first day of IROS 2018, since the true one would change the bytes."""

ARCHIVE = "a-2b"
"""The PDF/A standard: everything is embedded, and a character that no font contains is an error."""


def typeset(
    text: Path,
    numbers: Mapping[str, Any],
    figures: Mapping[str, Path],
    output_format: Literal["pdf", "png"] = "pdf",
    points_per_inch: float = 110.0,
) -> list[bytes]:
    """Return the paper: one document as PDF, or a picture for each page as PNG.

    Args:
        text: Folder of the text, with ``paper.typ`` in it.
        numbers: As ``study.paper.numbers.gather`` returns them.
        figures: ``{path below results/: file}``.
        points_per_inch: Resolution of PNG pictures.

    Raises:
        InvalidInput: The text does not compile, for example because it quotes a number that is missing.
    """
    with _compiler(text, numbers, figures) as compiler:
        made = compiler.compile(
            format=output_format,
            ppi=points_per_inch,
            timestamp=CREATED,
            pdf_standards=ARCHIVE if output_format == "pdf" else [],
        )
    assert made is not None
    return made if isinstance(made, list) else [made]


def placed(text: Path, numbers: Mapping[str, Any], figures: Mapping[str, Path]) -> list[dict[str, Any]]:
    """Return the places of figures, captions, tables and formulas: the metadata ``<placed>`` that style.typ writes.

    Arguments and errors are those of ``typeset``.
    """
    with _compiler(text, numbers, figures) as compiler:
        try:
            return json.loads(compiler.query("<placed>", field="value"))
        except RuntimeError as error:  # what a query raises where a compilation raises a TypstError
            raise InvalidInput(Fault(str(text), f"cannot be typeset: {error}")) from None


@contextmanager
def _compiler(text: Path, numbers: Mapping[str, Any], figures: Mapping[str, Path]) -> Iterator[Any]:
    """Copy text and results below one root and yield a compiler; raise its errors as faults of the text."""
    import typst  # imported here: an optional dependency, of the extra `workflow`

    with tempfile.TemporaryDirectory(prefix="paper-") as folder:
        root = Path(folder)
        shutil.copytree(text, root / "paper")
        for place, source in figures.items():
            target = root / "results" / place
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(source, target)
        write_json(root / NUMBERS, numbers)
        write_json(root / FILES, sorted(figures))
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error")  # such as that of a missing font
                yield typst.Compiler(root / MAIN, root=root, ignore_system_fonts=True)
        except (typst.TypstError, typst.TypstWarning) as error:
            reason = str(error).replace(str(root), "").replace("\n", " ")
            raise InvalidInput(Fault(str(text), f"cannot be typeset: {reason}")) from None


def write_paper(
    output: str | Path, text: Path, numbers: Mapping[str, Any], figures: Mapping[str, Path]
) -> None:
    """Write the paper to a PDF, whole or not at all; the other arguments are those of ``typeset``.

    Raises:
        InvalidInput: The text does not compile, or parts overlap or extend over the margins; in a draft, the latter is only printed.
    """
    (document,) = typeset(text, numbers, figures)
    if faults := layout_faults(placed(text, numbers, figures)):
        if not numbers.get("draft"):
            raise InvalidInput([Fault(str(text), fault) for fault in faults])
        print("\n".join(faults))
    with atomic_write(output) as temporary:
        temporary.write_bytes(document)
