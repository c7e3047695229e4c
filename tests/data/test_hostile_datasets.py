"""Datasets damaged at random are read, or refused with named faults; the reader never fails otherwise."""

import shutil
from pathlib import Path

import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from scalar.data.dataset import read_dataset
from scalar.data.dataset_writer import write_dataset
from scalar.errors import InvalidInput
from tests.small_datasets import description, edit_cell, edit_lines, tables

HOSTILE = settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=60)
KINDS = ("line-laser", "probe", "tracker")
NOT_NUMBERS = st.sampled_from(
    ["", " ", "abc", "nan", "-inf", "1e999", "1,5", "--1", "0x1", "None", "1 2", "٣", "½"]
) | (st.text("abcxyz!?/", min_size=1, max_size=5))


@pytest.fixture(scope="module")
def originals(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Return a valid dataset of each kind, and one with Parquet."""
    root = tmp_path_factory.mktemp("originals")
    for kind in KINDS:
        write_dataset(root / kind, mapping=description(kind), **tables(kind))
    write_dataset(root / "parquet", mapping=description(), table_format="parquet", **tables())
    return {path.name: path for path in root.iterdir()}


def copy(original: Path, folder: Path) -> Path:
    """Return a fresh copy of a dataset."""
    shutil.rmtree(folder / "d", ignore_errors=True)
    return Path(shutil.copytree(original, folder / "d"))


def refused(folder: Path) -> InvalidInput:
    """Return the refusal of a dataset; every fault names a file and is one printable line."""
    with pytest.raises(InvalidInput) as caught:
        read_dataset(folder)
    assert caught.value.faults
    for fault in caught.value.faults:
        assert fault.file
        assert str(fault).isprintable()
    return caught.value


@HOSTILE
@given(st.data(), st.sampled_from(KINDS), NOT_NUMBERS)
def test_a_cell_that_is_no_number_is_named_by_row_and_column(
    originals: dict[str, Path], tmp_path: Path, data: st.DataObject, kind: str, text: str
) -> None:
    """Any numeric cell replaced by text that is no number gives a fault at its file, row and column."""
    folder = copy(originals[kind], tmp_path)
    file = data.draw(st.sampled_from(sorted(path.name for path in folder.glob("*.csv"))))
    lines = (folder / file).read_text().splitlines()
    row = data.draw(st.integers(2, len(lines)))
    column = data.draw(st.sampled_from([name for name in lines[0].split(",") if name != "plane"]))
    edit_cell(folder, file, row, column, f'"{text}"' if "," in text else text)
    places = {(fault.file, fault.row, fault.column) for fault in refused(folder).faults}
    assert (file, row, column) in places


@HOSTILE
@given(st.data(), st.sampled_from(KINDS))
def test_a_missing_column_is_named(
    originals: dict[str, Path], tmp_path: Path, data: st.DataObject, kind: str
) -> None:
    """Any column that is removed gives a fault with its name."""
    folder = copy(originals[kind], tmp_path)
    file = data.draw(st.sampled_from(sorted(path.name for path in folder.glob("*.csv"))))
    names = (folder / file).read_text().splitlines()[0].split(",")
    name = data.draw(st.sampled_from(names))
    i = names.index(name)
    edit_lines(
        folder, file, lambda ls: [",".join(c for j, c in enumerate(x.split(",")) if j != i) for x in ls]
    )
    assert (file, name) in {(fault.file, fault.column) for fault in refused(folder).faults}


@HOSTILE
@given(st.data(), st.sampled_from(KINDS))
def test_a_row_of_another_length_is_named(
    originals: dict[str, Path], tmp_path: Path, data: st.DataObject, kind: str
) -> None:
    """Any row that is shortened or lengthened gives a fault at that row."""
    folder = copy(originals[kind], tmp_path)
    file = data.draw(st.sampled_from(sorted(path.name for path in folder.glob("*.csv"))))
    lines = (folder / file).read_text().splitlines()
    row = data.draw(st.integers(2, len(lines)))
    cells = lines[row - 1].split(",")
    n = data.draw(st.integers(1, len(cells) + 3).filter(lambda n: n != len(cells)))
    lines[row - 1] = ",".join((cells * 2)[:n])
    edit_lines(folder, file, lambda _: lines)
    assert (file, row) in {(fault.file, fault.row) for fault in refused(folder).faults}


@HOSTILE
@given(st.data())
def test_a_key_that_is_unknown_is_named(
    originals: dict[str, Path], tmp_path: Path, data: st.DataObject
) -> None:
    """Any key of the description with a wrong letter gives a fault with the misspelt key."""
    folder = copy(originals["line-laser"], tmp_path)
    written = (folder / "dataset.yaml").read_text().splitlines(keepends=True)
    text = "".join(line for line in written if not line.startswith("#"))
    keys = sorted({word for word in text.replace("{", " ").split() if word.endswith(":")})
    key = data.draw(st.sampled_from(keys))
    (folder / "dataset.yaml").write_text(text.replace(key, f"{key[:-1]}x:"))
    found = [fault.column or "" for fault in refused(folder).faults]
    assert any(column.split(".")[-1] == f"{key[:-1]}x" for column in found)


@HOSTILE
@given(st.data(), st.sampled_from([*KINDS, "parquet"]))
def test_random_bytes_anywhere_are_survived(
    originals: dict[str, Path], tmp_path: Path, data: st.DataObject, kind: str
) -> None:
    """Bytes overwritten, inserted or removed anywhere in any file give a dataset or InvalidInput."""
    folder = copy(originals[kind], tmp_path)
    path = data.draw(st.sampled_from(sorted(folder.iterdir())))
    raw = path.read_bytes()
    start = data.draw(st.integers(0, len(raw)))
    end = data.draw(st.integers(start, min(len(raw), start + 20)) | st.just(len(raw)))
    path.write_bytes(raw[:start] + data.draw(st.binary(max_size=20)) + raw[end:])
    try:
        read_dataset(folder)
    except InvalidInput as error:
        assert all(str(fault).isprintable() for fault in error.faults)


@HOSTILE
@given(st.data())
def test_a_parquet_file_cut_short_is_named(
    originals: dict[str, Path], tmp_path: Path, data: st.DataObject
) -> None:
    """Cut anywhere, a Parquet file is refused by name."""
    folder = copy(originals["parquet"], tmp_path)
    raw = (folder / "scans.parquet").read_bytes()
    (folder / "scans.parquet").write_bytes(raw[: data.draw(st.integers(0, len(raw) - 1))])
    assert [fault.file for fault in refused(folder).faults] == ["scans.parquet"]


JUNK = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-5, 5)
    | st.floats()
    | st.sampled_from(["", "x", "1e-4", "floor"]),
    lambda inner: (
        st.lists(inner, max_size=3) | st.dictionaries(st.sampled_from(["a", "name", "x"]), inner, max_size=3)
    ),
    max_leaves=4,
)


@HOSTILE
@given(st.data(), st.sampled_from(KINDS), JUNK)
def test_junk_in_the_place_of_any_value_is_survived(
    originals: dict[str, Path], tmp_path: Path, data: st.DataObject, kind: str, junk: object
) -> None:
    """Any value of the description replaced by another of any type gives a dataset or InvalidInput."""
    mapping = description(kind)
    where: object = mapping
    while True:
        assume(isinstance(where, dict | list) and where)
        key = data.draw(st.sampled_from(list(where) if isinstance(where, dict) else range(len(where))))  # type: ignore[arg-type]
        if not isinstance(where[key], dict | list) or data.draw(st.booleans()):  # type: ignore[index]
            where[key] = junk  # type: ignore[index]
            break
        where = where[key]  # type: ignore[index]
    shutil.rmtree(tmp_path / "d", ignore_errors=True)
    write_dataset(tmp_path / "d", mapping=mapping, **tables(kind))
    try:
        read_dataset(tmp_path / "d")
    except InvalidInput as error:
        assert all(str(fault).isprintable() for fault in error.faults)
