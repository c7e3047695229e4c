"""Write a diagnosis, or a calibration with its page.

Every file is written whole or not at all and contains the identifier of its run; none is put in its place before all are complete. The main file,
``diagnosis.json`` or ``calibration.json``, comes last, so that its presence shows that the result is complete.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from scalar.data.io.atomic import json_text, plain, write_together
from scalar.data.io.run_id import INDEX, run_of, with_run

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset
    from scalar.diagnosis.result import Diagnosis
    from scalar.estimation.result import Calibration


def write_diagnosis(diagnosis: Diagnosis, folder: Path) -> None:
    """Write ``before.json``, ``after.json``, ``report.html`` and, last, ``diagnosis.json`` to a folder that exists."""
    write_together(folder, files_of_diagnosis(diagnosis))


def files_of_diagnosis(diagnosis: Diagnosis) -> dict[str, str]:
    """Return the content of each file that ``write_diagnosis`` writes by its name, in the order in which they are put in their places."""
    from scalar.report import render_report

    parts = {
        "before.json": plain(diagnosis.calibration_before.to_mapping()),
        "after.json": plain(diagnosis.calibration_after.to_mapping()),
        INDEX: diagnosis.to_mapping(),
    }
    run = run_of(*parts.values())
    page = render_report(diagnosis, run)
    texts = {name: json_text(with_run(part, run)) for name, part in parts.items()}
    index = texts.pop(INDEX)
    return texts | {"report.html": page, INDEX: index}


def write_calibration(
    calibration: Calibration, dataset: Dataset, folder: Path, *, with_page: bool = True
) -> None:
    """Write the page ``report.html``, if it is wanted, and then ``calibration.json``.

    Args:
        calibration: The calibration.
        dataset: The dataset from which it was estimated.
        folder: An existing folder.
        with_page: Whether the page is wanted.
    """
    content = plain(calibration.to_mapping())
    run = run_of(content)
    texts: dict[str, str] = {}
    if with_page:
        from scalar.report import render_calibration

        texts["report.html"] = render_calibration(calibration, dataset, run)
    write_together(folder, texts | {"calibration.json": json_text(with_run(content, run))})
