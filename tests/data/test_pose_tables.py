"""A table of poses alone reads exactly and is checked as strictly as poses.csv."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from scalar.data.pose_tables import read_pose_table
from scalar.errors import InvalidInput
from tests.small_datasets import edit_cell, edit_lines, tables

FRAME = ("x", "y", "z")


@pytest.fixture
def poses(tmp_path: Path) -> pd.DataFrame:
    """Return the poses that were written to joints.csv."""
    table = tables("tracker")["poses"].assign(x=0.1, y=0.2, z=1.0 / 3.0, order=7)
    table.to_csv(tmp_path / "joints.csv", index=False)
    return table


def test_numbers_read_back_exactly(tmp_path: Path, poses: pd.DataFrame) -> None:
    """Every column reads back to the last bit, further ones included."""
    back = read_pose_table(tmp_path / "joints.csv", 6, FRAME)
    assert list(back.columns) == list(poses.columns)
    assert np.array_equal(back.to_numpy(dtype=float), poses.to_numpy(dtype=float))


@pytest.mark.parametrize(
    ("row", "column", "text", "message"),
    [
        (3, "q2", "abc", "not a number"),
        (3, "order", "nan", "not a finite"),
        (4, "pose", "10", "stands already in row 2"),
        (5, "q3", "-170.0", "are these degrees?"),
        (1, "q6", "q7", "the robot has joints 1 to 6"),
        (1, "z", "Z", "the column is missing"),
    ],
)
def test_faults_are_named(
    tmp_path: Path, poses: pd.DataFrame, row: int, column: str, text: str, message: str
) -> None:
    """Wrong cells and wrong names are found at their row and column."""
    edit_cell(tmp_path, "joints.csv", row, column, text)
    with pytest.raises(InvalidInput, match=message) as caught:
        read_pose_table(tmp_path / "joints.csv", 6, FRAME)
    assert (row, column) in {(fault.row, fault.column) for fault in caught.value.faults}


def test_names_where_numbers_of_poses_are_needed_are_one_fault(tmp_path: Path, poses: pd.DataFrame) -> None:
    """A column of names A, P1 and so on gives one line that says how to number the poses and does not mention decimals.

    A single name is refused at its row.
    """
    poses["pose"] = ["A", *(f"P{i}" for i in range(1, len(poses)))]
    poses.to_csv(tmp_path / "joints.csv", index=False)
    with pytest.raises(InvalidInput) as caught:
        read_pose_table(tmp_path / "joints.csv", 6, FRAME)
    (fault,) = caught.value.faults
    assert fault.column == "pose" and fault.row == 2
    assert "'A'" in fault.message and "whole numbers" in fault.message and "0.123" not in fault.message
    poses["pose"] = range(len(poses))
    poses.astype({"pose": str}).replace({"pose": {"1": "B7"}}).to_csv(tmp_path / "joints.csv", index=False)
    with pytest.raises(InvalidInput, match="not a whole number \\('B7'\\); write one that no other pose has"):
        read_pose_table(tmp_path / "joints.csv", 6, FRAME)


def test_a_header_that_stands_twice_is_one_fault(tmp_path: Path, poses: pd.DataFrame) -> None:
    """Two tables in one file have it again; its cells are not met one by one."""
    edit_lines(tmp_path, "joints.csv", lambda lines: [*lines[:4], lines[0], *lines[4:]])
    with pytest.raises(InvalidInput) as caught:
        read_pose_table(tmp_path / "joints.csv", 6, FRAME)
    (fault,) = caught.value.faults
    assert fault.row == 5 and "names of the columns stand here again" in fault.message


def test_a_row_too_long_does_not_shift_the_columns(tmp_path: Path, poses: pd.DataFrame) -> None:
    """An additional cell in every row is a fault, and the first column is not taken for an index."""
    edit_lines(tmp_path, "joints.csv", lambda lines: [lines[0], *(line + ",0" for line in lines[1:])])
    with pytest.raises(InvalidInput, match="12 cells where the header names 11"):
        read_pose_table(tmp_path / "joints.csv", 6, FRAME)


@pytest.mark.parametrize(
    ("change", "words"),
    [(lambda line: line.replace(".", ","), "decimal commas"), (lambda line: line + ",", "end with a comma")],
    ids=["decimal commas", "a comma at the end"],
)
def test_what_all_rows_have_too_many_is_one_fault(tmp_path: Path, poses: pd.DataFrame, change, words) -> None:
    """The cause is asked for once, and not each row named."""
    edit_lines(tmp_path, "joints.csv", lambda lines: [lines[0], *map(change, lines[1:])])
    with pytest.raises(InvalidInput, match=words) as caught:
        read_pose_table(tmp_path / "joints.csv", 6, FRAME)
    assert len(caught.value.faults) == 1


def test_limits_allow_an_axis_that_turns_far(tmp_path: Path, poses: pd.DataFrame) -> None:
    """Angles within the robot's own limits are not suspect."""
    edit_cell(tmp_path, "joints.csv", 5, "q6", "90.5")
    limits = np.tile([-3.2, 3.2], (6, 1))
    limits[5] = [-100.0, 100.0]
    assert read_pose_table(tmp_path / "joints.csv", 6, FRAME, limits)["q6"].iloc[3] == 90.5


@pytest.mark.parametrize("make", [None, "folder", "empty"])
def test_a_file_that_cannot_be_read_is_one_fault(tmp_path: Path, make: str | None) -> None:
    """A missing file, a folder and an empty file give one fault each."""
    path = tmp_path / "joints.csv"
    if make == "folder":
        path.mkdir()
    elif make == "empty":
        path.touch()
    with pytest.raises(InvalidInput) as caught:
        read_pose_table(path, 6)
    assert len(caught.value.faults) == 1
