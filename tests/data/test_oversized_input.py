"""Small files that claim much, and files whose every row is wrong, are refused soon, in few lines and in little memory."""

import json
import re
import tracemalloc
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from scipy.io import savemat

from scalar.data.dataset import validate_dataset
from scalar.data.dataset_writer import write_dataset
from scalar.data.io.json_reader import read_json
from scalar.data.io.regular_file import MAX_TABLE_BYTES, read_regular_file
from scalar.data.located_table import MAX_SHOWN, did_you_mean
from scalar.errors import Fault, InvalidInput
from scalar.ingest.foreign_tables import read_raw
from tests.small_datasets import description, edit_lines, tables


def test_a_parquet_file_that_claims_more_than_a_table_may_hold_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Zeros without end are a small file; they were once read until the memory was full."""
    write_dataset(tmp_path / "d", mapping=description(), table_format="parquet", **tables())
    n = 200_000
    columns = {"pose": pa.array(np.full(n, 10)), "x": pa.array(np.zeros(n)), "z": pa.array(np.zeros(n))}
    path = tmp_path / "d" / "scans.parquet"
    pq.write_table(pa.table(columns), path)
    assert path.stat().st_size < 50_000
    monkeypatch.setattr("scalar.data.io.parquet_reader.MAX_TABLE_BYTES", 1_000_000)
    (fault,) = validate_dataset(tmp_path / "d")
    assert fault.file == "scans.parquet" and "5 MB of data, more than the 1 MB" in fault.message


def test_a_matrix_that_claims_more_than_a_table_may_hold_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The size that the file states is looked at before the matrix is decompressed."""
    monkeypatch.setattr("scalar.ingest.foreign_tables.MAX_TABLE_BYTES", 1_000_000)
    path = tmp_path / "zeros.mat"
    savemat(path, {"q": np.zeros((200_000, 3)), "small": np.zeros((4, 3))}, do_compression=True)
    with pytest.raises(InvalidInput, match="a matrix of 5 MB, more than the 1 MB"):
        read_raw(path, {}, "q")
    assert len(read_raw(path, {}, "small").lines) == 4


def test_rows_that_are_too_short_are_counted_not_listed(tmp_path: Path) -> None:
    """A header with one name too many makes every row wrong; a million of them were once a million lines."""
    content = tables()
    write_dataset(tmp_path / "d", mapping=description(), **content)
    edit_lines(tmp_path / "d", "scans.csv", lambda lines: [f"{lines[0]},y", *(10 * lines[1:])])
    wrong = [
        f for f in validate_dataset(tmp_path / "d") if f.file == "scans.csv" and "cells where" in f.message
    ]
    assert len(wrong) == MAX_SHOWN
    rest = 10 * len(content["scans"]) - MAX_SHOWN
    assert any(f"{rest} more rows" in f.message for f in validate_dataset(tmp_path / "d"))


def test_a_key_that_stands_twice_among_many_is_found_at_once(tmp_path: Path) -> None:
    """The key is named; the search once compared every key with all before it, which takes hours among as many as a file may have."""
    path = tmp_path / "a.json"
    path.write_text("{" + ",".join(f'"k{i}": 1' for i in range(100_000)) + ', "k99998": 2}')
    with pytest.raises(InvalidInput, match="k99998: this key stands twice"):
        read_json(path)


@pytest.mark.parametrize("wrong", ["NaN", "-Infinity", "1e101", "1" * 400, "true", "[NaN]", '"\\ud800"'])
def test_one_wrong_number_among_many_is_found(wrong: str, tmp_path: Path) -> None:
    """A list of numbers is looked at as a whole, and one that may not stand there is still named by its place."""
    path = tmp_path / "a.json"
    path.write_text(f'{{"values": [0, 1.5, -2e99, {wrong}, 3]}}')
    if wrong == "true":
        assert read_json(path)["values"][3] is True
        return
    with pytest.raises(InvalidInput, match=re.escape("values[3]")):
        read_json(path)


def test_a_limit_is_stated_as_it_is(tmp_path: Path) -> None:
    """The message about a number that is too large names the largest that is read."""
    path = tmp_path / "a.json"
    for number in ("1e100", "2e100"):
        path.write_text(json.dumps({"a": float(number)}))
        if number == "1e100":
            assert read_json(path) == {"a": 1e100}
            continue
        with pytest.raises(InvalidInput, match="at most 1e100"):
            read_json(path)


def test_a_name_of_any_length_is_shown_in_part() -> None:
    """A file that is no table at all may have one name of millions of characters; it resembles no column, and is no line of a terminal."""
    name = "q1" * 5_000_000
    assert did_you_mean(name, ["q1", "q2"]) == ""
    assert len(str(Fault("poses.csv", "an unknown column", 1, name))) < 400
    assert "column q1: " in str(Fault("poses.csv", "an unknown column", 1, "q1"))


def test_a_long_table_with_one_wrong_cell_takes_little_memory(tmp_path: Path) -> None:
    """The cell is named by its row; once every cell was kept as text, fifty times the size of the file."""
    write_dataset(tmp_path / "d", mapping=description(), **tables())
    edit_lines(tmp_path / "d", "scans.csv", lambda lines: [lines[0], *(2000 * lines[1:]), "10,0.1,+-2"])
    size = (tmp_path / "d" / "scans.csv").stat().st_size
    tracemalloc.start()
    try:
        (fault,) = validate_dataset(tmp_path / "d")
        most = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert fault.row == 2000 * 36 + 2 and fault.column == "z" and "'+-2'" in fault.message
    assert most < 12 * size


def test_a_small_file_takes_no_buffer_of_the_largest(tmp_path: Path) -> None:
    """The buffer is that of the file; once it was a gigabyte, which a process with limited memory does not get."""
    path = tmp_path / "a.csv"
    path.write_text("pose\n1\n")
    tracemalloc.start()
    try:
        assert read_regular_file(path, MAX_TABLE_BYTES) == b"pose\n1\n"
        assert tracemalloc.get_traced_memory()[1] < 1_000_000
    finally:
        tracemalloc.stop()


@pytest.mark.skipif(
    not Path("/proc/self/status").exists(), reason="a file whose size the system does not state"
)
def test_a_file_that_has_more_than_its_size_says_is_read_whole() -> None:
    """A file that grows while it is read, or states no size, is read up to the limit."""
    path = Path("/proc/self/status")
    assert path.stat().st_size == 0
    raw = read_regular_file(path, 1_000_000)
    assert raw.startswith(b"Name:") and b"Threads:" in raw
    with pytest.raises(InvalidInput, match="longer than"):
        read_regular_file(path, 10)


def test_an_unknown_column_of_words_and_a_few_numbers_is_one_fault(tmp_path: Path) -> None:
    """Most of its cells are no numbers: the column is at fault, and not each of its cells."""
    write_dataset(tmp_path / "d", mapping=description(), **tables())
    edit_lines(
        tmp_path / "d",
        "poses.csv",
        lambda lines: [f"{lines[0]},remark", f"{lines[1]},1e400", *(f"{x},good" for x in lines[2:])],
    )
    (fault,) = validate_dataset(tmp_path / "d")
    assert fault.column == "remark" and "not of numbers ('good')" in fault.message
