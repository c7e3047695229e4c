"""Files that people write and that are no table of this format are refused in one line that says what they are."""

import pytest

from scalar.data.dataset import read_dataset
from scalar.errors import InvalidInput
from tests.random_scene import make_scene


@pytest.fixture
def cell(tmp_path):
    """Return the folder of a dataset."""
    make_scene("vs060", "tracker", seed=2, poses_per_plane=20).write(tmp_path / "cell")
    return tmp_path / "cell"


def refused(cell, *words: str) -> None:
    """Check that the dataset is refused with one fault that has these words."""
    with pytest.raises(InvalidInput) as refusal:
        read_dataset(cell)
    assert len(refusal.value.faults) == 1, str(refusal.value)
    for word in words:
        assert word in str(refusal.value)


def edited(cell, change) -> None:
    """Replace the lines of poses.csv by what ``change`` returns for them."""
    path = cell / "poses.csv"
    path.write_text("\n".join(change(path.read_text(encoding="utf-8").splitlines())) + "\n", encoding="utf-8")


@pytest.mark.parametrize("at", [0, 5])
def test_comments_are_called_comments(cell, at):
    edited(cell, lambda lines: [*lines[:at], "# measured by me", *lines[at:]])
    refused(cell, f"poses.csv, row {at + 1}", "a table has no comments")


def test_a_spreadsheet_is_called_one(cell):
    (cell / "poses.csv").write_bytes(b"PK\x03\x04\x14\x00\x06\x00\xff\xfe")
    refused(cell, "this is a spreadsheet", "scalar import")


def test_a_dash_is_no_minus(cell):
    def with_dash(lines):
        names, cells = lines[0].split(","), lines[3].split(",")
        cells[names.index("q2")] = "\u22120.5"
        return [*lines[:3], ",".join(cells), *lines[4:]]

    edited(cell, with_dash)
    refused(cell, "column q2", "write - of the keyboard")


def test_signs_of_the_approach_are_ones(cell):
    def with_signs(lines):
        names = ",".join(f"approach{i + 1}" for i in range(6))
        return [
            f"{lines[0]},{names}",
            *(f"{line},{'+-'[i % 2]},1,1,1,1,1" for i, line in enumerate(lines[1:])),
        ]

    edited(cell, with_signs)
    refused(cell, "column approach1", "write 1 or -1")


def test_a_decimal_comma_in_yaml_is_called_one(cell):
    path = cell / "dataset.yaml"
    text = path.read_text(encoding="utf-8")
    path.write_text(text + "extra: {a: 0,68}\n", encoding="utf-8")
    refused(cell, "decimal comma")


def test_times_of_day_are_seconds(cell):
    edited(
        cell,
        lambda lines: [
            f"{lines[0]},time",
            *(f"{line},09:00:{i % 60:02d}" for i, line in enumerate(lines[1:])),
        ],
    )
    refused(cell, "column time", "write seconds")
