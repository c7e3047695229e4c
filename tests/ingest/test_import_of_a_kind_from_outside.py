"""Importing the measurements of a kind of sensor from outside the package: its columns have the units that its format states."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner, Result

from scalar.cli import cli
from scalar.data.dataset import read_dataset
from scalar.data.io.plain_yaml import dump_yaml
from scalar.data.sensor_formats import MeasuredTable, SensorFormat
from scalar.sensors import PointByPoint, register, unregister
from tests.small_datasets import description

KIND = "total-station"
N = 5


UNITS = {"distance": "m", "bearing": "rad", "elevation": "rad"}


class TotalStation(PointByPoint):
    """Measures a distance and two angles at each pose; these tests use its format alone."""

    format = SensorFormat(
        KIND,
        on_planes=False,
        needs_nominal_pose=True,
        table=MeasuredTable("sights", UNITS, False, "row", largest=100.0),
    )
    words = "total station"


@pytest.fixture(autouse=True)
def registered() -> Iterator[None]:
    """Make the kind known for one test."""
    register(TotalStation)
    yield
    unregister(TotalStation)


def measured() -> np.ndarray:
    """Return ``(N, 9)``: six joint angles [deg], distance [mm], bearing and elevation [deg]."""
    rng = np.random.default_rng(8)
    return np.hstack(
        [rng.uniform(-90, 90, (N, 6)), rng.uniform(2000, 4000, (N, 1)), rng.uniform(-40, 40, (N, 2))]
    )


def columns(**measured_columns: Mapping[str, Any]) -> dict[str, Any]:
    """Return the columns of a mapping: the joints in degrees, and what is measured."""
    joints = {f"q{i}": {"column": f"J{i}", "unit": "deg"} for i in range(1, 7)}
    return {**joints, **measured_columns}


def run(folder: Path, given: Mapping[str, Any]) -> Result:
    """Run ``scalar import`` of ``measured`` with these columns into ``folder/out``."""
    header = [*(f"J{i}" for i in range(1, 7)), "sd", "hz", "v"]
    rows = [",".join(map(repr, map(float, row))) for row in measured()]
    (folder / "a.csv").write_text("\n".join([",".join(header), *rows]) + "\n", encoding="utf-8")
    described = description("tracker")
    described["sensor"]["kind"] = KIND
    mapping = {"format": "scalar-mapping/1", "poses": {"columns": dict(given)}, "dataset": described}
    dump_yaml(mapping, folder / "mapping.yaml")
    command = ["import", str(folder / "mapping.yaml"), str(folder / "a.csv"), "-o", str(folder / "out")]
    return CliRunner().invoke(cli, command)


IN_FILE = {
    "distance": {"column": "sd", "unit": "mm"},
    "bearing": {"column": "hz", "unit": "deg"},
    "elevation": {"column": "v", "unit": "deg"},
}


def test_its_columns_are_converted(tmp_path):
    """Millimetres and degrees of the file become the metres and radians that the format of the kind states."""
    result = run(tmp_path, columns(**IN_FILE))
    assert result.exit_code == 0, result.output
    expected = measured()[:, 6:] * [1e-3, np.pi / 180, np.pi / 180]
    np.testing.assert_allclose(read_dataset(tmp_path / "out").points, expected, rtol=1e-14)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"distance": {"column": "sd"}}, ("distance.unit: missing", "m or mm")),
        ({"bearing": {"column": "hz", "unit": "mm"}}, ("bearing.unit: unknown ('mm')", "rad, deg")),
        ({"bearing": {"column": "hz", "unit": "deg", "sign": -1}}, ("bearing.sign: only joints have one",)),
    ],
)
def test_a_unit_that_is_missing_or_wrong_is_refused(tmp_path, change, words):
    """As for the kinds of the package, no unit is guessed: exit status 2, and the column is named."""
    result = run(tmp_path, columns(**{**IN_FILE, **change}))
    assert result.exit_code == 2
    for word in words:
        assert word in result.stderr
    assert not (tmp_path / "out").exists()


def test_a_missing_column_is_named_with_its_unit(tmp_path):
    """The message shows the entry to add, for an angle with a unit."""
    result = run(tmp_path, columns(distance=IN_FILE["distance"], bearing=IN_FILE["bearing"]))
    assert result.exit_code == 2
    assert "elevation: missing; add it, as {column: name in the file, unit: rad}" in result.stderr
