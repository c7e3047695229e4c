"""Poses that one of two tables lacks: many of them are one fault."""

from pathlib import Path

import pytest

from scalar.data.dataset import validate_dataset
from scalar.data.dataset_writer import write_dataset
from tests.small_datasets import description, edit_lines, tables


@pytest.mark.parametrize(
    ("file", "other", "words"),
    [
        ("points.csv", "poses.csv", ("poses have no ", "in points.csv: ", "remove these poses")),
        ("poses.csv", "points.csv", ("unknown poses,", "add the poses to poses.csv")),
    ],
)
def test_many_poses_that_one_table_lacks_are_one_fault(
    tmp_path: Path, file: str, other: str, words: tuple[str, ...]
) -> None:
    """If a table ends after its second row, the other has one fault, with the number of poses and rows and the first three of each."""
    folder = tmp_path / "d"
    write_dataset(folder, mapping=description("tracker"), **tables("tracker"))
    all_rows = (folder / other).read_text().splitlines()
    lost, at = [row.split(",")[0] for row in all_rows[3:]], range(4, len(all_rows) + 1)
    assert len(lost) > 4
    edit_lines(folder, file, lambda ls: ls[:3])
    (fault,) = validate_dataset(folder)
    assert (fault.file, fault.row, fault.column) == (other, 4, "pose")
    assert fault.message.startswith(f"{len(lost)} ")
    assert f"{', '.join(lost[:3])}, ... ({len(at)} rows: 4, 5, 6, ...)" in fault.message
    assert all(word in fault.message for word in words)
