"""A message names a file so that it can be found: by its path in the folder that was given, and never like another file."""

import shutil
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from scalar.ingest.source_files import distinct_names
from tests.ingest.foreign_tables import refused, run, write_table
from tests.ingest.two_tables import two_tables


def in_two_folders(folder):
    """Write the log of the robot and that of the tracker as data.csv in two folders each of two days, and return their mapping."""
    mapping = two_tables(folder)
    for day in (1, 2):
        for name in ("robot", "tracker"):
            inner = folder / f"day {day}" / name
            inner.mkdir(parents=True)
            shutil.copy(folder / f"{name}.csv", inner / "data.csv")
    for block, name in (("poses", "robot"), ("points", "tracker")):
        mapping[block]["files"] = [
            {"name": f"day {day}/{name}/data.csv", "add_to_pose": 1000 * (day - 1)} for day in (1, 2)
        ]
    return mapping


def spoilt(path, row, column, cell):
    """Replace a cell of a table."""
    lines = path.read_text().splitlines()
    cells = lines[row - 1].split(",")
    cells[column] = cell
    lines[row - 1] = ",".join(cells)
    path.write_text("\n".join(lines) + "\n")


@pytest.mark.parametrize("name", ["robot", "tracker"])
def test_faults_name_the_path_in_the_folder_that_was_given(tmp_path, name):
    """Cells, rows and whole files at fault are named with their folders, in the table of poses and in that of points."""
    mapping = in_two_folders(tmp_path)
    path = tmp_path / "day 2" / name / "data.csv"
    spoilt(path, 4, 3, "?")
    refused(tmp_path, run(tmp_path, mapping, tmp_path), f"day 2/{name}/data.csv, row 4, column")
    spoilt(path, 4, 3, "1,2")
    refused(tmp_path, run(tmp_path, mapping, tmp_path), f"day 2/{name}/data.csv, row 4: ")
    path.write_bytes(b"\xff\xfe\x00")
    refused(tmp_path, run(tmp_path, mapping, tmp_path), f"day 2/{name}/data.csv, row 1: byte 0 is not utf-8")
    path.write_bytes(b"")
    refused(tmp_path, run(tmp_path, mapping, tmp_path), f"day 2/{name}/data.csv: ")


def test_tables_that_do_not_fit_together_are_named_with_their_folders(tmp_path):
    """Poses and points stand in files of one name; a message that compares both says which it means."""
    mapping = in_two_folders(tmp_path)
    spoilt(tmp_path / "day 1/tracker/data.csv", 3, 0, "77")
    result = run(tmp_path, mapping, tmp_path)
    refused(tmp_path, result, "day 1/tracker/data.csv")
    assert not any(line.startswith("scalar: data.csv") for line in result.output.splitlines())


def test_files_directly_in_the_folder_have_their_name_alone(tmp_path):
    """Where a name is enough, no folder stands before it."""
    mapping = two_tables(tmp_path)
    spoilt(tmp_path / "robot.csv", 4, 3, "?")
    result = run(tmp_path, mapping, tmp_path)
    refused(tmp_path, result, "scalar: robot.csv, row 4")


def test_two_folders_that_were_given_are_distinguished(tmp_path):
    """Each has a file of the same name, whose path in the folder is the same too: the folder itself stands before it."""
    mapping = two_tables(tmp_path)
    for day, words in (("one", "abcdef"), ("two", "ghijkl")):
        (tmp_path / day).mkdir()
        write_table(
            tmp_path / day / "robot.csv", [["1", *words]], ["Nr", *(f"J{i}" for i in range(1, 7))], ","
        )
    result = run(tmp_path, mapping, tmp_path / "one", tmp_path / "two", tmp_path / "tracker.csv")
    refused(tmp_path, result, "scalar: one/robot.csv, row 2", "scalar: two/robot.csv, row 2")


PARTS = st.sampled_from(["a", "b", "data.csv"])


@given(st.lists(st.lists(PARTS, min_size=1, max_size=4), min_size=1, max_size=8, unique_by=tuple), st.data())
def test_no_two_files_are_called_alike(paths, data):
    """Whatever files are given, and through whichever folders, each name ends its path, and no two names are the same."""
    files = [Path("/given", *parts) for parts in paths]
    sources = {}
    for file in files:
        folder = data.draw(st.sampled_from([None, *file.parents[:-1]]))
        if folder is not None:
            sources[file] = folder
    names = distinct_names(files, sources)
    assert len(set(names)) == len(files)
    for file, name in zip(files, names, strict=True):
        assert str(file).endswith(f"/{name.removeprefix('/')}")
