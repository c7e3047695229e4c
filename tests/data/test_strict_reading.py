"""What a tolerant reader would accept is refused with its place: 1.0 for an integer, lone surrogates, very long lists."""

import time
from pathlib import Path
from typing import Any

import pytest

from scalar.data.dataset import read_dataset, validate_dataset
from scalar.data.dataset_writer import write_dataset
from scalar.data.io.atomic import atomic_directory, atomic_write
from scalar.data.io.json_reader import read_json
from scalar.data.io.plain_yaml import dump_yaml, load_yaml
from scalar.data.located_table import MAX_COLUMNS
from scalar.data.strict_schema import strict_validator
from scalar.errors import InvalidInput
from tests.random_scene import make_scene
from tests.small_datasets import description, edit_cell, edit_lines, tables


@pytest.mark.parametrize("text", [r"\ud800", r"\udfff", r"a\uDBFF"])
@pytest.mark.parametrize("entry", ['name: "{}"', '"{}": 1', 'list: [1, "{}"]'])
def test_a_lone_surrogate_in_yaml_is_refused_with_its_row(entry: str, text: str, tmp_path: Path) -> None:
    """A lone surrogate, in a value or a key, is refused, since it could not be written to a file."""
    path = tmp_path / "file.yaml"
    path.write_text("first: 1\n" + entry.format(text) + "\n")
    with pytest.raises(InvalidInput, match="half a character") as caught:
        load_yaml(path)
    assert caught.value.faults[0].row == 2


@pytest.mark.parametrize("escape", [r"\U00110000", r"\UFFFFFFFF"])
def test_an_escape_beyond_the_last_character_is_refused_with_its_row(escape: str, tmp_path: Path) -> None:
    """Unicode ends at U+10FFFF: an escape beyond it is refused, and the last character itself is read."""
    path = tmp_path / "file.yaml"
    path.write_text(f'last: "\\U0010ffff"\nname: "{escape}"\n')
    with pytest.raises(InvalidInput, match="names no character") as caught:
        load_yaml(path)
    assert caught.value.faults[0].row == 2
    path.write_text('last: "\\U0010ffff"\n')
    assert load_yaml(path) == {"last": "\U0010ffff"}


@pytest.mark.parametrize("value, valid", [(1, True), (-3, True), (1.0, False), (True, False), ("1", False)])
def test_an_integer_is_written_without_a_point(value: Any, valid: bool) -> None:
    """A whole number with a decimal point is not an integer."""
    assert strict_validator({"type": "integer"}).is_valid(value) == valid


@pytest.mark.parametrize(
    "text, column",
    [
        ('{"a": {"b": [1, NaN]}}', "a.b[1]"),
        ('{"a": -Infinity}', "a"),
        ('{"a": 1e999}', "a"),
        ('{"a": 1' + 400 * "0" + "}", "a"),
        ('{"a": ' + 5000 * "7" + "}", "a"),
        (r'{"a": ["\ud800"]}', "a[0]"),
        ('{"a": 1, "a": 2}', "a"),
        ('{"a": ' + 30 * "[" + 30 * "]" + "}", "a" + 19 * "[0]"),
    ],
)
def test_values_that_no_json_file_may_hold_are_refused_with_their_key(
    text: str, column: str, tmp_path: Path
) -> None:
    """Numbers that are not finite or have too many digits, lone surrogates, repeated keys and deep nesting are refused."""
    path = tmp_path / "file.json"
    path.write_text(text)
    with pytest.raises(InvalidInput) as caught:
        read_json(path)
    assert column in [fault.column for fault in caught.value.faults]


@pytest.mark.parametrize("text", ["", "{", "[1,]", 100_000 * "[", '{"a": }', "\udcff"])
def test_what_is_no_json_is_refused(text: str, tmp_path: Path) -> None:
    """Text that is cut short, nested too deeply or not UTF-8 is a fault of the file."""
    path = tmp_path / "file.json"
    path.write_bytes(text.encode("utf-8", "surrogateescape"))
    with pytest.raises(InvalidInput) as caught:
        read_json(path)
    assert caught.value.faults[0].file == str(path)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Return a small tracker dataset."""
    write_dataset(tmp_path / "d", mapping=description("tracker"), **tables("tracker"))
    return tmp_path / "d"


def faults_within(folder: Path, seconds: float) -> str:
    """Return the message with which a dataset is refused, which has to come within this processor time [s]."""
    start = time.process_time()
    with pytest.raises(InvalidInput) as caught:
        read_dataset(folder)
    assert time.process_time() - start < seconds
    text = str(caught.value)
    assert len(text) < 100_000
    return text


@pytest.mark.parametrize("repeated", [False, True])
def test_a_header_of_very_many_columns_is_refused_at_once(folder: Path, repeated: bool) -> None:
    """A header of 100,000 columns, named differently or alike, is one fault, in linear time."""
    names = [f"c{0 if repeated else i}" for i in range(100_000)]
    edit_lines(folder, "poses.csv", lambda lines: [lines[0] + "," + ",".join(names), *lines[1:]])
    assert f"at most {MAX_COLUMNS} are read" in faults_within(folder, 5)


@pytest.mark.slow
def test_very_many_joints_are_one_fault(folder: Path) -> None:
    """30,000 joints in a dataset.yaml are one fault, without a fault for each missing column of poses.csv."""
    text = (folder / "dataset.yaml").read_text()
    mapping = load_yaml(folder / "dataset.yaml")
    mapping["robot"]["joints"] = "JOINTS"
    dump_yaml(mapping, folder / "dataset.yaml")
    text = (folder / "dataset.yaml").read_text()
    joints = 30_000 * "{a: 0,alpha: 0,d: 0,theta: 0},"
    (folder / "dataset.yaml").write_text(text.replace("JOINTS", f"[{joints}]"))
    assert "robot.joints: 30000 entries, and at most 100 are read" in faults_within(folder, 60)


def test_very_many_unknown_keys_are_not_all_written_out(folder: Path) -> None:
    """At most a hundred unknown keys are listed."""
    with (folder / "dataset.yaml").open("a") as file:
        file.writelines(f"k{i}: 1\n" for i in range(2_000))
    assert len(faults_within(folder, 30).splitlines()) <= 101


@pytest.mark.parametrize("path", [".", "", "/", "..", "a/.."])
def test_an_output_without_a_name_is_refused(
    path: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A file or a folder cannot replace the folder one stands in, its parent or the root."""
    monkeypatch.chdir(tmp_path)
    for writing in (atomic_write, atomic_directory):
        with pytest.raises(InvalidInput), writing(path):
            pytest.fail("there is nothing to write to")
    assert not list(tmp_path.iterdir())


def test_a_number_too_large_to_compute_with_is_named(tmp_path: Path) -> None:
    """A recorded temperature of 1e101 is refused, and one of 1e99 is read."""
    content = tables()
    content["poses"]["temperature"] = 20.0
    for exponent, faults in (("99", 0), ("101", 1)):
        folder = tmp_path / exponent
        write_dataset(folder, mapping=description(), **content)
        edit_cell(folder, "poses.csv", 4, "temperature", f"1e{exponent}")
        found = validate_dataset(folder)
        assert [(f.row, f.column) for f in found if "too large a number" in f.message] == [
            (4, "temperature")
        ] * faults


@pytest.mark.parametrize("key", ["nominal_pose", "normal"])
def test_a_vector_whose_square_overflows_is_named(tmp_path: Path, key: str) -> None:
    """dataset.yaml with 1.4e154 in a vector is refused by the key; its length is not computed."""
    mapping = description()
    where = {"nominal_pose": "sensor.nominal_pose.translation[2]", "normal": "planes[0].normal[2]"}[key]
    write_dataset(tmp_path / "d", mapping=mapping, **tables())
    if key == "normal":
        mapping["planes"][0]["normal"] = [0.0, 0.0, 1.4e154]
    else:
        mapping["sensor"]["nominal_pose"] = {
            "translation": [0.0, 0.0, 1.4e154],
            "rotation_vector": [0.0, 0.0, 0.0],
        }
    dump_yaml(mapping, tmp_path / "d" / "dataset.yaml")
    found = validate_dataset(tmp_path / "d")
    assert any(f.column == where and "too large a number" in f.message for f in found)


@pytest.mark.parametrize(("sign", "called"), [(";", "';'"), ("\t", "tabs")])
def test_another_separator_is_named(sign, called, tmp_path):
    """A table whose cells are separated by semicolons or tabs is refused in one sentence that says so."""
    folder = make_scene("vs060", "tracker", seed=2, poses_per_plane=8).write(tmp_path / "cell")
    poses = folder / "poses.csv"
    poses.write_text(poses.read_text(encoding="utf-8").replace(",", sign), encoding="utf-8")
    with pytest.raises(InvalidInput) as refused:
        read_dataset(folder)
    said = [fault.message for fault in refused.value.faults if fault.file == "poses.csv"]
    assert len(said) == 1 and f"separated by {called}; separate them by commas" in said[0]


def test_a_row_without_any_content_is_a_blank_line(tmp_path):
    """Spreadsheets save rows that were emptied as separators alone."""
    write_dataset(tmp_path / "d", mapping=description(), **tables())
    before = read_dataset(tmp_path / "d")
    edit_lines(
        tmp_path / "d",
        "poses.csv",
        lambda lines: [*lines[:3], "," * lines[0].count(","), *lines[3:], " ," * lines[0].count(",")],
    )
    assert read_dataset(tmp_path / "d").poses.equals(before.poses)


def test_a_folder_of_results_is_called_so(tmp_path):
    """The output of a diagnosis is no dataset, and the message says what the folder is."""
    (tmp_path / "after.json").write_text("{}", encoding="utf-8")
    (fault,) = validate_dataset(tmp_path)
    assert "this folder holds results (after.json)" in fault.message
