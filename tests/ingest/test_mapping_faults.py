"""Every fault of a mapping file is refused by its key; the example mappings have none."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

from scalar.cli import cli
from scalar.data.io.plain_yaml import dump_yaml
from scalar.errors import InvalidInput
from scalar.ingest.mapping_reader import load_mapping
from tests.ingest.foreign_tables import cells, refused, run, tracker_mapping, write_table

ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize("content", ["", "7", "[1, 2]"])
def test_a_description_without_keys_is_refused(tmp_path, content):
    """A file that the mapping names as the dataset's description, and that holds no keys, is refused by its name, also with --urdf."""
    source = write_table(tmp_path / "a.csv", cells())
    (tmp_path / "cell.yaml").write_text(content, encoding="utf-8")
    mapping = {**tracker_mapping(), "dataset": "cell.yaml"}
    mapping.pop("dataset_units", None)
    refused(tmp_path, run(tmp_path, mapping, source), "cell.yaml", "not a mapping; write keys and values")
    with pytest.raises(InvalidInput, match="not a mapping; write keys and values"):
        load_mapping(tmp_path / "mapping.yaml", {"name": "any"})


def changed(path: tuple[str, ...], value: Any) -> dict[str, Any]:
    """Return the tracker's mapping with one key set, or removed where the value is None."""
    mapping = tracker_mapping()
    inner: Any = mapping
    for key in path[:-1]:
        inner = inner.setdefault(key, {})
    if value is None:
        del inner[path[-1]]
    else:
        inner[path[-1]] = value
    return mapping


@pytest.mark.parametrize(
    ("path", "value", "words"),
    [
        (("matrixx",), {}, ("matrixx", "did you mean 'matrix'")),
        (("text", "seperator"), ";", ("text.seperator", "unknown key", "separator")),
        (("text", "separator"), None, ("text.decimal", "separator")),
        (("text", "separator"), ":", ("text.separator", "write one of ',', ';', '|', tab, '\\t', space")),
        (("text", "skip_lines"), -1, ("text.skip_lines", "less than 0")),
        (("format",), "scalar-mapping/2", ("format", "scalar-mapping/1")),
        (("poses", "columns", "q1", "unit"), "degrees", ("poses.columns.q1.unit", "did you mean 'deg'")),
        (("poses", "columns", "q1", "unit"), None, ("poses.columns.q1.unit", "missing", "rad or deg")),
        (("poses", "columns", "x", "unit"), "inch", ("poses.columns.x.unit", "m, mm")),
        (
            ("poses", "columns", "order"),
            {"column": "x", "offset": 1.0},
            ("poses.columns.order.offset", "only joints"),
        ),
        (("poses", "columns", "x", "plus"), "y", ("poses.columns.x.plus", "only joints")),
        (("poses", "columns", "q1", "sign"), 2, ("poses.columns.q1.sign", "1, -1")),
        (("poses", "columns", "q1", "offset"), float("nan"), ("poses.columns.q1.offset", "finite")),
        (("poses", "columns", "q3"), None, ("poses.columns.q3", "missing")),
        (
            ("poses", "columns", "y", "column"),
            "tracker X",
            ("poses.columns.y", "comes from the same column of the file as x"),
        ),
        (
            ("poses", "columns", "q3", "column"),
            "J2",
            ("poses.columns.q3", "comes from the same column of the file as q2", "of a parallelogram"),
        ),
        (("poses", "columns", "q7"), {"column": "J7", "unit": "deg"}, ("poses.columns.q7", "unknown column")),
        (("poses", "columns", "temprature"), {"column": "T"}, ("did you mean 'temperature'",)),
        (("poses", "drop_without"), ["w"], ("poses.drop_without[0]",)),
        (("poses", "covariates", "q9"), {"column": "T"}, ("poses.covariates.q9",)),
        (("poses", "columns", "q1", "column"), "J8", ("a.csv", "column J8", "no such column", "J1")),
        (("poses", "columns", "q1", "column"), 12, ("a.csv", "no column 12", "9")),
        (("poses", "files"), [{"name": "b.csv"}], ("b.csv", "not among the sources")),
        (
            ("poses", "files"),
            [{"name": "run_*.csv"}],
            ("run_*.csv", "none is among the sources", "not searched"),
        ),
        (
            ("poses", "files"),
            [{"name": "runs/a.csv"}],
            ("runs/a.csv", "not among the sources", "write a.csv"),
        ),
        (("dataset", "sensor", "kind"), "trakker", ("dataset.sensor.kind", "did you mean 'tracker'")),
        (("dataset", "robot", "joints"), [], ("dataset.robot.joints",)),
        (("dataset",), "missing.yaml", ("missing.yaml", "no such file")),
        (("dataset",), "../dataset.yaml", ("mapping.yaml, dataset", "leads out of the folder")),
        (("dataset",), "/etc/hostname", ("mapping.yaml, dataset", "leads out of the folder")),
        (("poses", "files"), [{"name": "../a.csv"}], ("../a.csv", "not among the sources")),
        (("poses", "files"), [{"name": "/etc/hostname"}], ("/etc/hostname", "not among the sources")),
        (("dataset_units", "length"), "ft", ("dataset_units.length", "m, mm, cm, in")),
        (("dataset_units", "length"), "mm", ("dataset.", "mapping.yaml")),
        (
            ("dataset", "dataset_units"),
            {"length": "mm"},
            ("dataset.dataset_units", "at the top of the mapping"),
        ),
        (("poses", "text"), {"separator": ";"}, ("poses.text", "at the top of the mapping")),
    ],
)
def test_a_wrong_mapping_is_refused_by_name(tmp_path, path, value, words):
    """The message names the key, column or unit, and suggests what may have been meant."""
    table = write_table(tmp_path / "a.csv", cells())
    mapping = changed(path, value)
    refused(tmp_path, run(tmp_path, mapping, table), *words)


def test_a_file_has_no_other_units(tmp_path):
    """A dataset.yaml that a mapping names is in metres and radians: one message says so, and none of its numbers is suspected besides."""
    mapping = {**tracker_mapping(), "dataset": "cell.yaml", "dataset_units": {"length": "mm"}}
    dump_yaml(tracker_mapping()["dataset"], tmp_path / "cell.yaml")
    result = run(tmp_path, mapping, write_table(tmp_path / "a.csv", cells()))
    refused(tmp_path, result, "dataset_units", "write the content of that file under dataset")
    assert len(result.stderr.splitlines()) == 1


@pytest.mark.parametrize(
    "edit, key",
    [
        (lambda m: m["poses"]["columns"]["q1"].update(column=1.0), "column"),
        (lambda m: m["dataset"]["robot"]["joints"][0].update(a=int("9" * 390)), "joints[0].a"),
    ],
)
def test_column_numbers_are_integers_and_lengths_are_bounded(edit: Any, key: str, tmp_path: Path) -> None:
    """A column number with a decimal point, and a length too large to compute with, are refused by their keys."""
    mapping = {**tracker_mapping(), "dataset_units": {"length": "mm", "angle": "deg"}}
    edit(mapping)
    dump_yaml(mapping, tmp_path / "mapping.yaml")
    write_table(tmp_path / "table.csv", cells())
    result = CliRunner().invoke(
        cli,
        [
            "import",
            *(str(tmp_path / name) for name in ("mapping.yaml", "table.csv")),
            "-o",
            str(tmp_path / "d"),
        ],
    )
    assert result.exit_code == 2, result.output
    assert key in result.stderr


@pytest.mark.parametrize(
    "path", sorted((ROOT / "configs/measured").glob("*.yaml")), ids=lambda path: path.stem
)
def test_the_example_mappings_have_no_faults(path):
    """Each example loads without a fault, and its robot's flange is 0.5 to 3 m from the base at joint angles of zero."""
    from scalar.geometry.robot import Robot
    from scalar.ingest.mapping_reader import load_mapping

    mapping = load_mapping(path)
    robot = Robot.from_mapping(mapping.description.mapping["robot"])
    reach = np.linalg.norm(robot.flange(np.zeros((1, robot.n_joints)))[0, :3, 3])
    assert 0.5 < reach < 3.0
