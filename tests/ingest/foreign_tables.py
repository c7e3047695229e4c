"""A tracker's table in degrees, millimetres, semicolons and decimal commas, its mapping, and ``scalar import`` of them."""

from pathlib import Path
from typing import Any

import numpy as np
from click.testing import CliRunner, Result

from scalar.cli import cli
from scalar.data.dataset import Dataset, read_dataset
from scalar.data.io.plain_yaml import dump_yaml
from tests.small_datasets import description

N = 9
"""Number of rows of the table."""


def joints(unit: str = "rad") -> dict[str, Any]:
    """Return six columns of a mapping, J1 to J6."""
    return {f"q{i}": {"column": f"J{i}", "unit": unit} for i in range(1, 7)}


def tracker_mapping() -> dict[str, Any]:
    """Return the mapping of a table with degrees, millimetres, semicolons and decimal commas."""
    points = {f"{c}": {"column": f"tracker {c.upper()}", "unit": "mm"} for c in "xyz"}
    return {
        "format": "scalar-mapping/1",
        "text": {"separator": ";", "decimal": ","},
        "poses": {"columns": {**joints("deg"), **points}},
        "dataset": description("tracker"),
    }


def numbers() -> np.ndarray:
    """Return ``(N, 9)``: six joint angles [deg] and a position [mm], three decimals each."""
    rng = np.random.default_rng(3)
    return np.round(np.hstack([rng.uniform(-170, 170, (N, 6)), rng.uniform(-3000, 3000, (N, 3))]), 3)


def header() -> list[str]:
    """Return the names of the columns of `numbers`."""
    return [*(f"J{i}" for i in range(1, 7)), "tracker X", "tracker Y", "tracker Z"]


def cells() -> list[list[str]]:
    """Return `numbers` as text with decimal commas, as a German spreadsheet writes them."""
    return [[f"{value:.3f}".replace(".", ",") for value in row] for row in numbers()]


def write_table(
    path: Path, rows: list[list[str]], names: list[str] | None = None, separator: str = ";"
) -> Path:
    """Write a table of text with Windows line ends."""
    lines = [separator.join(row) for row in [header() if names is None else names, *rows]]
    path.write_bytes(("\r\n".join(lines) + "\r\n").encode())
    return path


def run(folder: Path, mapping: dict[str, Any], *sources: Path) -> Result:
    """Run ``scalar import`` into ``folder/out``."""
    dump_yaml(mapping, folder / "mapping.yaml")
    command = ["import", str(folder / "mapping.yaml"), *map(str, sources), "-o", str(folder / "out")]
    return CliRunner().invoke(cli, command)


def imported(folder: Path, mapping: dict[str, Any], *sources: Path) -> Dataset:
    """Return the dataset that an import wrote."""
    result = run(folder, mapping, *sources)
    assert result.exit_code == 0, result.output
    return read_dataset(folder / "out")


def refused(folder: Path, result: Result, *words: str) -> None:
    """Check a refusal: exit status 2, one line for each fault, the words, no traceback and no output."""
    assert result.exit_code == 2, result.output
    assert result.stdout == ""
    assert all(line.startswith("scalar: ") for line in result.stderr.splitlines())
    for word in words:
        assert word in result.stderr
    assert not (folder / "out").exists()
    assert not list(folder.glob(".out*"))
