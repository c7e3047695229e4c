"""Imported tables give the same numbers as the foreign files, in SI: units, signs, missing rows, covariates, scans and nests."""

import numpy as np
import pytest
from click.testing import CliRunner

from scalar.cli import cli
from scalar.data.dataset import read_dataset
from scalar.data.io.plain_yaml import dump_yaml
from tests.ingest.foreign_tables import (
    N,
    cells,
    header,
    imported,
    joints,
    numbers,
    refused,
    run,
    tracker_mapping,
    write_table,
)
from tests.small_datasets import description


def test_other_units_separators_and_decimal_signs_give_the_same_numbers(tmp_path):
    """Degrees and millimetres become radians and metres, to the last digit that the file has."""
    data = imported(tmp_path, tracker_mapping(), write_table(tmp_path / "a.csv", cells()))
    given = numbers()
    np.testing.assert_allclose(data.q, np.radians(given[:, :6]), rtol=0, atol=1e-15)
    assert [[f"{1000 * x:.3f}" for x in row] for row in data.points] == [
        [f"{x:.3f}" for x in row] for row in given[:, 6:]
    ]
    written = (tmp_path / "out/points.csv").read_text().splitlines()[1]
    assert all(len(cell) <= len("-0.123456") for cell in written.split(",")), (
        "no digits that the file does not have"
    )
    np.testing.assert_array_equal(data.pose_ids, np.arange(N))
    assert "order" not in data.poses  # nothing states it


@pytest.mark.parametrize(("unit", "size"), [("cm", 10.0), ("in", 25.4)])
def test_centimetres_and_inches_become_metres(unit, size, tmp_path):
    """The same lengths in another unit give the same points, to the digits that the file has."""
    mapping = tracker_mapping()
    columns = mapping["poses"]["columns"]
    for name in ("x", "y", "z"):
        columns[name]["unit"] = unit
    rows = [
        row[:6] + [f"{value / 100:.5f}".replace(".", ",") for value in given[6:]]
        for row, given in zip(cells(), numbers(), strict=True)
    ]
    data = imported(tmp_path, mapping, write_table(tmp_path / "a.csv", rows))
    np.testing.assert_allclose(data.points, numbers()[:, 6:] * size / 1e5, rtol=1e-14)


def test_directions_may_be_written_as_signs(tmp_path):
    """A column of + and - alone is one of 1 and -1; a single - among numbers is no number."""
    mapping = tracker_mapping()
    mapping["poses"]["columns"] |= {f"approach{j}": {"column": "dir"} for j in range(1, 7)}
    signs = ["+" if k % 3 else "-" for k in range(N)]
    table = [[*row, sign] for row, sign in zip(cells(), signs, strict=True)]
    data = imported(tmp_path, mapping, write_table(tmp_path / "a.csv", table, [*header(), "dir"]))
    assert data.poses["approach2"].tolist() == [1 if sign == "+" else -1 for sign in signs]


@pytest.mark.parametrize("written", ["tab", '"\\t"', "'\\t'"])
def test_a_tab_may_be_written_as_a_word_or_as_its_escape(written, tmp_path):
    """``tab``, ``"\\t"`` and ``'\\t'`` are one separator, in a mapping of YAML text."""
    mapping = tracker_mapping()
    mapping["text"]["separator"] = "SEPARATOR"
    file = tmp_path / "mapping.yaml"
    dump_yaml(mapping, file)
    text = file.read_text(encoding="utf-8")
    assert text.count("SEPARATOR") == 1
    file.write_text(text.replace("SEPARATOR", written), encoding="utf-8")
    table = write_table(tmp_path / "a.csv", cells(), separator="\t")
    result = CliRunner().invoke(cli, ["import", str(file), str(table), "-o", str(tmp_path / "out")])
    assert result.exit_code == 0, result.output
    np.testing.assert_allclose(read_dataset(tmp_path / "out").q, np.radians(numbers()[:, :6]), atol=1e-15)


def test_sign_and_offset_of_a_joint(tmp_path):
    """A joint angle is ``sign * value + offset``, the offset in the file's unit."""
    mapping = tracker_mapping()
    mapping["poses"]["columns"]["q2"] |= {"sign": -1, "offset": 90}
    data = imported(tmp_path, mapping, write_table(tmp_path / "a.csv", cells()))
    np.testing.assert_allclose(data.q[:, 1], np.radians(90 - numbers()[:, 1]), atol=1e-15)


def test_a_joint_that_is_shown_against_the_horizontal_is_a_sum(tmp_path):
    """A joint angle is ``sign * (value + plus) + offset``; a row in which the second column is empty has no measurement of the joint."""
    mapping = tracker_mapping()
    name = mapping["poses"]["columns"]["q2"]["column"]
    mapping["poses"]["columns"]["q3"] |= {"plus": name, "sign": -1, "offset": 10}
    data = imported(tmp_path, mapping, write_table(tmp_path / "a.csv", cells()))
    np.testing.assert_allclose(data.q[:, 2], np.radians(10 - (numbers()[:, 2] + numbers()[:, 1])), atol=1e-15)


def test_an_angle_that_contains_that_of_the_joint_before_is_a_difference(tmp_path):
    """With ``minus`` a joint angle is ``sign * (value - minus) + offset``."""
    mapping = tracker_mapping()
    name = mapping["poses"]["columns"]["q2"]["column"]
    mapping["poses"]["columns"]["q3"] |= {"minus": name, "sign": -1, "offset": 10}
    data = imported(tmp_path, mapping, write_table(tmp_path / "a.csv", cells()))
    np.testing.assert_allclose(data.q[:, 2], np.radians(10 - (numbers()[:, 2] - numbers()[:, 1])), atol=1e-15)


def test_plus_and_minus_exclude_each_other(tmp_path):
    """A column to which one is added and from which another is subtracted is refused; the key is named."""
    mapping = tracker_mapping()
    mapping["poses"]["columns"]["q3"] |= {"plus": "A", "minus": "B"}
    table = write_table(tmp_path / "a.csv", cells())
    refused(tmp_path, run(tmp_path, mapping, table), "poses.columns.q3.minus", "keep one of the two keys")


def test_a_second_column_that_the_file_lacks_is_named(tmp_path):
    """A column that is to be added has to be there, as the first one has."""
    mapping = tracker_mapping()
    mapping["poses"]["columns"]["q3"]["plus"] = "J22"
    table = write_table(tmp_path / "a.csv", cells())
    refused(tmp_path, run(tmp_path, mapping, table), "J22")


def test_rows_without_a_measurement_are_left_out_where_asked_and_refused_otherwise(tmp_path):
    """An empty cell, or a text that the mapping calls missing, is no measurement; other rows keep their numbers."""
    rows = cells()
    rows[2][7], rows[5][6] = "", "-9999"
    mapping = tracker_mapping()
    mapping["text"]["missing"] = ["-9999"]
    write_table(tmp_path / "a.csv", rows)
    refused(tmp_path, run(tmp_path, mapping, tmp_path / "a.csv"), "a.csv, row 4, column tracker Y", "row 7")
    mapping["poses"]["drop_without"] = ["x", "y", "z"]
    said = run(tmp_path, mapping, tmp_path / "a.csv").output
    assert "a.csv: 2 rows left out, without" in said and "(drop_without): 4, 7" in said
    data = imported(tmp_path, mapping, tmp_path / "a.csv")
    np.testing.assert_allclose(data.q, np.radians(np.delete(numbers()[:, :6], [2, 5], axis=0)), atol=1e-15)


def test_optional_columns_covariates_and_preamble(tmp_path):
    """Optional columns and covariates are imported, poses are sorted by order, and lines before the table are skipped."""
    rows = [[*row, str(20 + i), f"{i},5", "ab"[i % 2], str(N - i)] for i, row in enumerate(cells())]
    write_table(tmp_path / "a.csv", rows, [*header(), "T", "t", "shift", "n"])
    path = tmp_path / "a.csv"
    path.write_bytes(b"a tracker's words\r\n\r\n" + path.read_bytes())
    mapping = tracker_mapping()
    mapping["text"]["skip_lines"] = 1
    mapping["poses"]["columns"] |= {
        "temperature": {"column": "T", "unit": "degC"},
        "time": {"column": "t", "unit": "s"},
        "session": {"column": "shift", "names": {"a": "early", "b": "late"}},
        "order": {"column": "n"},
    }
    mapping["poses"]["covariates"] = {"load": {"column": 10}}
    data = imported(tmp_path, mapping, path)
    np.testing.assert_array_equal(data.pose_ids, np.arange(N)[::-1])
    np.testing.assert_array_equal(data.poses["temperature"], 20 + np.arange(N)[::-1])
    np.testing.assert_array_equal(data.poses["load"], data.poses["temperature"])
    np.testing.assert_array_equal(data.poses["time"], np.arange(N)[::-1] + 0.5)
    assert list(data.poses["session"][-2:]) == ["late", "early"]


def test_scans_in_one_table_or_in_two_are_the_same(tmp_path):
    """A long table with one row for each point, and separate files of poses and points, give the same dataset."""
    rng = np.random.default_rng(5)
    q, xz = rng.uniform(-2, 2, (6, 6)), rng.uniform(1, 200, (6, 4, 2))
    planes = ["floor", "wall_x", "wall_y"] * 2
    names = ["scan", "target", *(f"J{i}" for i in range(1, 7))]
    short = [[str(k), planes[k], *map(repr, map(float, q[k]))] for k in range(6)]
    points = [[str(k), *(repr(float(v)) for v in point)] for k in range(6) for point in xz[k]]
    write_table(tmp_path / "poses.csv", short, names, ",")
    write_table(tmp_path / "scans.csv", points, ["scan", "x", "z"], ",")
    long = [[*short[int(row[0])], *row[1:]] for row in points]
    write_table(tmp_path / "long.csv", long, [*names, "x", "z"], ",")
    coordinates = {"x": {"column": "x", "unit": "mm"}, "z": {"column": "z", "unit": "mm"}}
    columns = {"pose": {"column": "scan"}, "plane": {"column": "target"}, **joints()}
    mapping = {
        "format": "scalar-mapping/1",
        "poses": {"columns": {**columns, **coordinates}, "first_of_each": "scan"},
        "dataset": description("line-laser"),
    }
    one = imported(tmp_path, mapping, tmp_path / "long.csv")
    mapping["poses"] = {"columns": columns, "files": [{"name": "poses.csv"}]}
    mapping["points"] = {
        "columns": {"pose": {"column": "scan"}, **coordinates},
        "files": [{"name": "sc*.csv"}],
    }
    two = imported(tmp_path, mapping, tmp_path)
    np.testing.assert_allclose(one.points, xz.reshape(-1, 2) / 1000, rtol=1e-14)
    np.testing.assert_array_equal(one.points, two.points)
    np.testing.assert_array_equal(one.starts, two.starts)
    np.testing.assert_array_equal(one.q, q)
    np.testing.assert_array_equal(two.q, q)


def test_nests_are_imported(tmp_path):
    """A table of nests in millimetres becomes nests.csv; a nest of an unknown pose is refused by its row."""
    mapping = tracker_mapping()
    mapping["poses"]["columns"]["pose"] = {"column": "Pose"}
    mapping["poses"]["files"] = [{"name": "a.csv"}]
    mapping["nests"] = {
        "files": [{"name": "nests.csv"}],
        "columns": {
            "pose": {"column": "Pose"},
            "nest": {"column": "Nest"},
            **{c: {"column": c.upper(), "unit": "mm"} for c in "xyz"},
        },
    }
    rows = [[str(i + 1), *row] for i, row in enumerate(cells())]
    write_table(tmp_path / "a.csv", rows, ["Pose", *header()])
    nests = [
        [str(i + 1), name, f"{1000 * k},5", "2000", "0"] for i in range(N) for k, name in enumerate("ABC")
    ]
    write_table(tmp_path / "nests.csv", nests, ["Pose", "Nest", "X", "Y", "Z"])
    data = imported(tmp_path, mapping, tmp_path / "a.csv", tmp_path / "nests.csv")
    assert data.references is not None and data.references.names == ("A", "B", "C")
    np.testing.assert_allclose(data.references.points[1], [1.0005, 2.0, 0.0], atol=1e-15)
    assert len(data.references.pose) == 3 * N
    write_table(tmp_path / "nests.csv", [["77", "A", "0", "0", "0"]], ["Pose", "Nest", "X", "Y", "Z"])
    result = run(tmp_path, mapping, tmp_path / "a.csv", tmp_path / "nests.csv")
    assert (
        result.exit_code == 2 and "nests.csv, row 2" in result.stderr and "unknown pose 77" in result.stderr
    )


def test_the_order_of_the_rows_is_that_of_acquisition_only_where_it_is_stated(tmp_path):
    """Without a column of time or order the dataset states no order, and the import says how; stated, rows are numbered as they stand."""
    mapping, file = tracker_mapping(), write_table(tmp_path / "measurements.csv", cells())
    result = run(tmp_path, mapping, file)
    assert (
        "no column states when the poses were measured" in result.output
        and "rows_in_order: true" in result.output
    )
    assert "order" not in read_dataset(tmp_path / "out").poses
    mapping["poses"]["rows_in_order"] = True
    result = run(tmp_path, mapping, file)
    assert "no column states" not in result.output
    assert read_dataset(tmp_path / "out").poses["order"].tolist() == list(range(N))


def test_a_table_in_place_of_the_mapping_is_told_with_the_right_order(tmp_path):
    """The message states the command with both in their places."""
    table = write_table(tmp_path / "a.csv", cells())
    dump_yaml(tracker_mapping(), tmp_path / "mine.yaml")
    command = ["import", str(table), str(tmp_path / "mine.yaml"), "-o", str(tmp_path / "out")]
    words = f"scalar import {tmp_path / 'mine.yaml'} {table} -o"
    refused(tmp_path, CliRunner().invoke(cli, command), "the mapping comes first", words)
