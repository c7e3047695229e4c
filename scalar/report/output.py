"""Write a diagnosis, or a calibration with its page: every file whole or not at all."""

from __future__ import annotations

from pathlib import Path

from scalar.data.dataset import Dataset
from scalar.data.io.atomic import atomic_write, write_json
from scalar.diagnosis.result import Diagnosis
from scalar.estimation.result import Calibration


def write_diagnosis(diagnosis: Diagnosis, folder: Path) -> None:
    """Write ``before.json``, ``after.json``, ``diagnosis.json`` and ``report.html`` to a folder that exists."""
    from scalar.report import render_report

    page = render_report(diagnosis)
    diagnosis.calibration_before.save(folder / "before.json")
    diagnosis.calibration_after.save(folder / "after.json")
    write_json(folder / "diagnosis.json", diagnosis.to_mapping())
    with atomic_write(folder / "report.html") as temporary:
        temporary.write_text(page, encoding="utf-8")


def write_calibration(calibration: Calibration, dataset: Dataset, folder: Path) -> None:
    """Write ``calibration.json`` and its page ``report.html`` to a folder that exists."""
    from scalar.report import render_calibration

    page = render_calibration(calibration, dataset)
    calibration.save(folder / "calibration.json")
    with atomic_write(folder / "report.html") as temporary:
        temporary.write_text(page, encoding="utf-8")
