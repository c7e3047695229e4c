"""Every fault of the tables of a dataset is found and named with its file, row and column."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from scalar.data.dataset import read_dataset, validate_dataset
from scalar.data.dataset_writer import write_dataset
from scalar.errors import Fault, InvalidInput
from tests.small_datasets import description, edit_cell, edit_lines, tables, write_text

Edit = Callable[[Path], Any]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Return a valid line-laser dataset."""
    return make(tmp_path)


def make(tmp_path: Path, kind: str = "line-laser", **options: Any) -> Path:
    """Return the folder of a valid dataset."""
    write_dataset(tmp_path / "d", mapping=description(kind), **tables(kind), **options)
    return tmp_path / "d"


def only(faults: list[Fault]) -> Fault:
    """Return the only fault."""
    assert len(faults) == 1, [str(fault) for fault in faults]
    return faults[0]


def cell(file: str, row: int, column: str, text: str) -> Edit:
    """Return the edit that writes a text into a cell."""
    return lambda folder: edit_cell(folder, file, row, column, text)


def lines(file: str, edit: Callable[[list[str]], list[str]]) -> Edit:
    """Return the edit of a file's lines."""
    return lambda folder: edit_lines(folder, file, edit)


CELLS = [
    ("poses.csv", 4, "q2", "abc", "not a number ('abc')"),
    ("poses.csv", 4, "q2", "", "empty cell"),
    ("poses.csv", 4, "q2", "nan", "not a finite"),
    ("poses.csv", 10, "q6", "-inf", "not a finite"),
    ("poses.csv", 10, "q6", "1e999", "not a finite"),
    ("poses.csv", 10, "q6", '"0,5"', "decimal point"),
    ("poses.csv", 2, "q1", "1_0", "not a number"),
    ("poses.csv", 2, "q1", "0x10", "not a number"),
    ("poses.csv", 2, "q1", "٣", "not a number"),
    ("poses.csv", 3, "plane", "", "empty cell"),
    ("poses.csv", 3, "plane", "wal_x", "did you mean 'wall_x'"),
    ("scans.csv", 7, "x", "x", "not a number"),
    ("scans.csv", 7, "z", "NaN", "not a finite"),
    ("scans.csv", 7, "pose", "11.5", "not an integer"),
    ("scans.csv", 7, "pose", "1e300", "not an integer"),
    ("scans.csv", 7, "pose", "99", "unknown pose 99 (1 row)"),
]


@pytest.mark.parametrize(("file", "row", "column", "text", "message"), CELLS)
def test_a_wrong_cell_is_named(
    folder: Path, file: str, row: int, column: str, text: str, message: str
) -> None:
    """One wrong cell gives one fault, with its file, row, column and text."""
    edit_cell(folder, file, row, column, text)
    fault = only(validate_dataset(folder))
    assert (fault.file, fault.row, fault.column) == (file, row, column)
    assert message in fault.message


def test_all_faults_are_reported_at_once(folder: Path) -> None:
    """Faults of three files, two in one of them, come together; `read_dataset` raises them all."""
    for file, row, column, text, _ in [CELLS[0], CELLS[3], CELLS[12]]:
        edit_cell(folder, file, row, column, text)
    edit_lines(folder, "dataset.yaml", lambda lines: [line.replace("noise", "nose") for line in lines])
    with pytest.raises(InvalidInput) as caught:
        read_dataset(folder)
    places = {(fault.file, fault.column) for fault in caught.value.faults}
    assert places == {
        ("poses.csv", "q2"), ("poses.csv", "q6"), ("scans.csv", "z"), ("dataset.yaml", "sensor.nose"),
    }  # fmt: skip
    assert len(str(caught.value).splitlines()) == 4


def test_blank_lines_do_not_shift_the_rows(folder: Path) -> None:
    """Rows after blank lines have the number that an editor shows, in the fast parser (nan) and cell by cell (text)."""
    for text in ("nan", "abc"):
        edit_lines(folder, "scans.csv", lambda lines: [*lines[:4], "", *lines[4:]])
        edit_cell(folder, "scans.csv", 9, "x", text)
        assert validate_dataset(folder)[0].row == 9


def widen(name: str, *cells: str) -> Edit:
    """Return the edit that adds a column to poses.csv: its name, and its cells over and over."""
    all_cells = [name, *cells * 9]
    return lines("poses.csv", lambda ls: [f"{x},{c}" for x, c in zip(ls, all_cells, strict=False)])


def relabel(old: str, new: str) -> Edit:
    """Return the edit that replaces a text in poses.csv."""
    return lines("poses.csv", lambda ls: [x.replace(old, new) for x in ls])


def add_approach(n: int, value: str) -> Edit:
    """Return the edit that adds n approach columns."""
    return widen(",".join(f"approach{i + 1}" for i in range(n)), ",".join([value] * n))


def add_to_scans(row: int, text: str) -> Edit:
    """Return the edit that writes a text at the end of a row of scans.csv."""
    return lines("scans.csv", lambda ls: [*ls[: row - 1], ls[row - 1] + text, *ls[row:]])


STRUCTURE = [
    ("no z", lines("scans.csv", lambda ls: [x.rsplit(",", 1)[0] for x in ls]), "scans.csv", 1, "z"),
    ("no q6", lines("poses.csv", lambda ls: [x.rsplit(",", 1)[0] for x in ls]), "poses.csv", 1, "q6"),
    ("renamed", relabel("q6", "Q6"), "poses.csv", 1, "q6"),
    ("q7", widen("q7", "0"), "poses.csv", 1, "q7"),
    ("text extra", widen("who", "me"), "poses.csv", 1, "who"),
    ("extra in scans", lines("scans.csv", lambda ls: [x + ",y" for x in ls]), "scans.csv", 1, "y"),
    ("twice", widen("q6", "0"), "poses.csv", 1, "q6"),
    ("nameless", widen("", "0"), "poses.csv", 1, None),
    ("short row", lines("poses.csv", lambda ls: [*ls[:3], "12,floor", *ls[4:]]), "poses.csv", 4, None),
    ("long row", add_to_scans(4, ",1"), "scans.csv", 4, None),
    ("open quote", add_to_scans(4, '"'), "scans.csv", 4, "z"),
    ("semicolons", lines("scans.csv", lambda ls: [x.replace(",", ";") for x in ls]), "scans.csv", 1, None),
    ("no header", lines("scans.csv", lambda ls: ls[1:]), "scans.csv", 1, None),
    ("empty file", lambda d: (d / "scans.csv").write_bytes(b""), "scans.csv", None, None),
    ("blank file", lambda d: (d / "scans.csv").write_bytes(b"\n\n"), "scans.csv", None, None),
    ("header only", lines("scans.csv", lambda ls: ls[:1]), "scans.csv", None, None),
    ("not UTF-8", lambda d: append(d / "scans.csv", b"1,\xff,2\n"), "scans.csv", 38, None),
    ("UTF-16", lambda d: (d / "poses.csv").write_text("pose", encoding="utf-16"), "poses.csv", 1, None),
    ("no scans", lambda d: (d / "scans.csv").unlink(), "scans.csv", None, None),
    ("no poses", lambda d: (d / "poses.csv").rename(d / "pose.csv"), "poses.csv", None, None),
    ("a folder", lambda d: ((d / "poses.csv").unlink(), (d / "poses.csv").mkdir()), "poses.csv", None, None),
    ("repeated pose", cell("poses.csv", 5, "pose", "11"), "poses.csv", 5, "pose"),
    ("approach incomplete", add_approach(5, "1"), "poses.csv", 1, "approach6"),
    ("approach of 0", add_approach(6, "0"), "poses.csv", 2, "approach1"),
    ("order twice", widen("order", "1"), "poses.csv", 3, "order"),
    ("empty session", widen("session", "", "1"), "poses.csv", 2, "session"),
    ("points too", lambda d: write_text(d, "points.csv", "pose,x,y,z"), "points.csv", None, None),
    ("two planes only", relabel("wall_y", "floor"), "poses.csv", None, "plane"),
]


def append(path: Path, raw: bytes) -> None:
    """Add bytes at the end of a file."""
    path.write_bytes(path.read_bytes() + raw)


@pytest.mark.parametrize(
    ("edit", "file", "row", "column"), [x[1:] for x in STRUCTURE], ids=[x[0] for x in STRUCTURE]
)
def test_a_wrong_structure_is_named(
    folder: Path, edit: Edit, file: str, row: int | None, column: str | None
) -> None:
    """The first fault names the place, in one line."""
    edit(folder)
    fault = validate_dataset(folder)[0]
    assert (fault.file, fault.row, fault.column) == (file, row, column)
    assert len(str(fault).splitlines()) == 1


def test_poses_without_a_scan_are_named_one_by_one(folder: Path) -> None:
    """Each pose that has no laser point is a fault at its own row of poses.csv."""
    edit_lines(folder, "scans.csv", lambda ls: [x for x in ls if x.split(",")[0] not in ("12", "15")])
    faults = validate_dataset(folder)
    assert [(fault.file, fault.row) for fault in faults] == [("poses.csv", 4), ("poses.csv", 7)]
    assert "pose 12 has no laser point in scans.csv" in faults[0].message


def test_a_pose_that_could_not_be_read_causes_no_faults_of_its_scan(folder: Path) -> None:
    """One short row of poses.csv gives one fault, and none for the points of the pose that it held."""
    edit_lines(folder, "poses.csv", lambda ls: [*ls[:3], "12,floor", *ls[4:]])
    assert only(validate_dataset(folder)).row == 4


def test_a_tracker_has_one_row_a_pose(tmp_path: Path) -> None:
    """A pose without a row, a pose with two rows, and a row of an unknown pose are faults."""
    folder = make(tmp_path, "tracker")
    edit_cell(folder, "points.csv", 4, "pose", "13")
    edit_cell(folder, "points.csv", 9, "pose", "77")
    found = {(fault.file, fault.row): fault.message for fault in validate_dataset(folder)}
    assert set(found) == {("points.csv", 5), ("points.csv", 9), ("poses.csv", 4), ("poses.csv", 9)}
    assert "already in row 4" in found["points.csv", 5]


def test_a_tracker_needs_no_planes_and_ignores_them(tmp_path: Path) -> None:
    """A plane column in a tracker's poses is ignored."""
    folder = make(tmp_path, "tracker")
    edit_lines(folder, "poses.csv", lambda ls: [ls[0] + ",plane", *(x + ",table" for x in ls[1:])])
    assert validate_dataset(folder) == []


def test_files_of_another_sensor_are_named(tmp_path: Path) -> None:
    """A line-laser with points.csv instead of scans.csv gets a fault for the missing file and one for the other."""
    folder = make(tmp_path)
    (folder / "scans.csv").rename(folder / "points.csv")
    assert [fault.file for fault in validate_dataset(folder)] == ["points.csv", "scans.csv"]
    (folder / "points.csv").rename(folder / "scans.csv")
    write_text(
        folder,
        "dataset.yaml",
        *(folder / "dataset.yaml").read_text().replace("line-laser", "probe").splitlines(),
    )
    assert "a probe has no such file" in only(validate_dataset(folder)).message


def test_csv_and_parquet_together_are_ambiguous(folder: Path) -> None:
    """With two files of scans, neither is chosen; the dataset is refused."""
    tables()["scans"].to_parquet(folder / "scans.parquet")
    assert "only one can be meant" in only(validate_dataset(folder)).message


PARQUET = [
    ("truncated", lambda p, t: p.write_bytes(p.read_bytes()[:-40]), None, None, "cut short"),
    ("cut to the head", lambda p, t: p.write_bytes(p.read_bytes()[:30]), None, None, "cut short"),
    ("empty", lambda p, t: p.write_bytes(b""), None, None, "cut short"),
    ("text", lambda p, t: p.write_bytes(b"pose,x,z\n1,2,3\n"), None, None, "cut short"),
    ("null", lambda p, t: save(p, t, "x", pa.array([0.1, None, *[0.1] * 34])), 2, "x", "empty cell"),
    ("nan", lambda p, t: save(p, t, "x", pa.array([0.1, 0.1, np.nan, *[0.1] * 33])), 3, "x", "not a finite"),
    ("strings", lambda p, t: save(p, t, "x", pa.array(["0.1"] * 36)), None, "x", "string, not numbers"),
    ("missing", lambda p, t: pq.write_table(t.drop_columns(["z"]), p), None, "z", "missing"),
    ("extra", lambda p, t: pq.write_table(t.append_column("y", t["x"]), p), None, "y", "unknown column"),
]


def save(path: Path, table: pa.Table, name: str, column: pa.Array) -> None:
    """Write a table with one column replaced."""
    pq.write_table(table.set_column(table.column_names.index(name), name, column), path)


@pytest.mark.parametrize(
    ("edit", "row", "column", "message"), [x[1:] for x in PARQUET], ids=[x[0] for x in PARQUET]
)
def test_a_damaged_parquet_file_is_named(
    tmp_path: Path, edit: Any, row: int | None, column: str | None, message: str
) -> None:
    """A scans.parquet that is truncated at any place, or has nulls, NaN, text or wrong columns, is refused by name."""
    path = make(tmp_path, table_format="parquet") / "scans.parquet"
    edit(path, pq.read_table(path))
    fault = only(validate_dataset(path.parent))
    assert (fault.file, fault.row, fault.column) == ("scans.parquet", row, column)
    assert message in fault.message


def test_integers_and_categories_in_parquet_are_numbers(tmp_path: Path) -> None:
    """Parquet columns of float32, int and dictionary type are read by value."""
    folder = make(tmp_path, table_format="parquet")
    scans = tables()["scans"]
    frame = pd.DataFrame({"pose": scans["pose"].astype("int16"), "x": 0, "z": scans["z"].astype("float32")})
    table = pa.Table.from_pandas(frame)
    table = table.set_column(0, "pose", table["pose"].dictionary_encode())
    pq.write_table(table, folder / "scans.parquet")
    assert np.array_equal(read_dataset(folder).points[:, 1], scans["z"].astype("float32").astype(float))


@pytest.mark.parametrize("content", ["nothing", "empty", "file", "yaml", "null"])
def test_a_path_that_is_no_dataset_folder_is_refused(tmp_path: Path, content: str) -> None:
    """No folder, an empty folder, a file and the description itself give one fault, which says what to give."""
    path = tmp_path / {"yaml": "dataset.yaml", "null": "a\0b"}.get(content, "d")
    if content == "empty":
        path.mkdir()
    elif content in ("file", "yaml"):
        path.write_text("format: scalar-dataset/1\n")
    assert "give the folder that holds dataset.yaml" in only(validate_dataset(path)).message


def test_a_folder_of_other_things_lacks_both_files(tmp_path: Path) -> None:
    """Each missing file is a fault of its own."""
    (tmp_path / "readme.txt").touch()
    assert [fault.file for fault in validate_dataset(tmp_path)] == ["dataset.yaml", "poses.csv"]
