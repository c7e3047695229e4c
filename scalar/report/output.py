"""Write a diagnosis: two calibrations, the findings, and the report, each whole or not at all."""

from __future__ import annotations

from pathlib import Path

from scalar.data.io.atomic import atomic_write, write_json
from scalar.diagnosis.result import Diagnosis


def write_diagnosis(diagnosis: Diagnosis, folder: Path) -> None:
    """Write ``before.json``, ``after.json``, ``diagnosis.json`` and ``report.html`` to a folder that exists."""
    from scalar.report import render_report

    page = render_report(diagnosis)
    diagnosis.calibration_before.save(folder / "before.json")
    diagnosis.calibration_after.save(folder / "after.json")
    write_json(folder / "diagnosis.json", diagnosis.to_mapping())
    with atomic_write(folder / "report.html") as temporary:
        temporary.write_text(page, encoding="utf-8")
