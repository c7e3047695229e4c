"""How tests call ``scalar diagnose --batch`` and read its table."""

from __future__ import annotations

import csv
from pathlib import Path

from click.testing import CliRunner, Result

from scalar.cli import cli


def run(*arguments: object) -> Result:
    """Run ``scalar`` in this process; its workers are forked from it."""
    return CliRunner().invoke(cli, [str(argument) for argument in arguments])


def table(folder: Path) -> dict[str, dict[str, str]]:
    """Return the lines of the table by the name of the dataset, in their order."""
    with open(folder / "fleet.csv", encoding="utf-8", newline="") as file:
        return {row["folder"]: row for row in csv.DictReader(file)}
