"""A file that lies in a folder twice is said to be a copy, once, and files that merely resemble each other are not."""

import shutil

import pytest

from tests.ingest.foreign_tables import N, cells, header, imported, refused, run, tracker_mapping, write_table
from tests.ingest.test_merged_scans import POSES, Z, mapping
from tests.ingest.two_tables import places, two_tables

HAS = ": has the same rows as "


def test_a_table_of_measurements_given_twice_is_refused_in_one_line(tmp_path):
    """Without numbers of poses, a copy would become poses of its own that count twice."""
    one = write_table(tmp_path / "poses.csv", cells())
    copy = shutil.copy(one, tmp_path / "poses (1).csv")
    result = run(tmp_path, tracker_mapping(), one, copy)
    refused(tmp_path, result, f"poses (1).csv{HAS}poses.csv")
    assert len(result.output.splitlines()) == 1


@pytest.mark.parametrize("numbered", [False, True], ids=["rows counted", "numbers of poses"])
def test_a_log_that_was_saved_twice_is_refused_in_one_line(tmp_path, numbered):
    """The second file begins with rows of the first: one line says how many, in both, whether or not a column numbers the poses."""
    rows, names, tables = cells(), header(), tracker_mapping()
    if numbered:
        rows, names = [[str(i), *row] for i, row in enumerate(rows)], ["Nr", *names]
        tables["poses"]["columns"]["pose"] = {"column": "Nr"}
    tables["poses"]["files"] = [{"name": "a.csv"}, {"name": "b.csv"}]
    write_table(tmp_path / "a.csv", rows[:6], names)
    write_table(tmp_path / "b.csv", rows[3:], names)
    result = run(tmp_path, tables, tmp_path)
    refused(
        tmp_path,
        result,
        f"b.csv, row 2: 3 of its {N - 3} rows, from this one on, stand in a.csv too, from row 5 on",
    )
    assert len(result.output.splitlines()) == 1


def test_a_row_that_recurs_here_and_there_is_no_copy(tmp_path):
    """A program that runs twice gives some rows of the same rounded numbers, and others between them."""
    again = [
        row if i in (0, 2) else [*row[:6], *(f"{cell}1" for cell in row[6:])] for i, row in enumerate(cells())
    ]
    tables = tracker_mapping()
    tables["poses"]["files"] = [{"name": "a.csv"}, {"name": "b.csv"}]
    write_table(tmp_path / "a.csv", cells())
    write_table(tmp_path / "b.csv", again)
    assert imported(tmp_path, tables, tmp_path).n_poses == 2 * N


def test_files_that_count_their_poses_anew_are_named_in_one_line(tmp_path):
    """Numbers of poses that stand in another file are one line for the pair of files, with how many there are and what to write."""
    rows, tables = [[str(i % 4), *row] for i, row in enumerate(cells()[:8])], tracker_mapping()
    tables["poses"]["columns"]["pose"] = {"column": "Nr"}
    tables["poses"]["files"] = [{"name": "a.csv"}, {"name": "b.csv"}]
    for name, own in (("a.csv", rows[:4]), ("b.csv", rows[4:])):
        write_table(tmp_path / name, own, ["Nr", *header()])
    result = run(tmp_path, tables, tmp_path)
    refused(
        tmp_path,
        result,
        "pose 0 stands already in a.csv, row 2, and so do 3 more of this file; if each",
        "add_to_pose",
    )
    assert "pose 1 stands" not in result.output


def test_copies_of_both_tables_are_named_in_one_line_each(tmp_path):
    """The copy of the poses does not hide that of the points; equal rows suffice, whatever the ends of lines."""
    tables = two_tables(tmp_path)
    for name in ("robot", "tracker"):
        text = (tmp_path / f"{name}.csv").read_bytes().replace(b"\r\n", b"\n")
        (tmp_path / f"{name} - Copy.csv").write_bytes(text)
    tables["poses"]["files"] = [{"name": "robot*.csv"}]
    tables["points"]["files"] = [{"name": "tracker*.csv"}]
    result = run(tmp_path, tables, tmp_path)
    refused(tmp_path, result, f"robot - Copy.csv{HAS}robot.csv", f"tracker - Copy.csv{HAS}tracker.csv")
    assert len(result.output.splitlines()) == 2


def test_a_copy_of_a_faulty_file_does_not_repeat_its_faults(tmp_path):
    """The fault is named in the first of both, and the second is said to have the same bytes."""
    rows = cells()
    rows[2][1] = "?"
    one = write_table(tmp_path / "poses.csv", rows)
    copy = shutil.copy(one, tmp_path / "poses (1).csv")
    result = run(tmp_path, tracker_mapping(), one, copy)
    refused(tmp_path, result, "poses.csv, row 4", "poses (1).csv: has the same bytes as poses.csv")
    assert len(result.output.splitlines()) == 2


def test_many_copies_are_one_line(tmp_path):
    """A folder that was copied whole gives one line with some of its files, and their number."""
    tables = tracker_mapping()
    tables["poses"]["files"] = [{"name": "a_*.csv"}]
    rows = cells()
    for k in range(4):
        one = write_table(tmp_path / f"a_{k}.csv", rows[2 * k : 2 * k + 2])
        shutil.copy(one, tmp_path / f"a_{k} (1).csv")
    result = run(tmp_path, tables, tmp_path)
    refused(tmp_path, result, "4 files", "a_0 (1).csv as a_0.csv")
    assert len(result.output.splitlines()) == 1


def test_copies_of_profiles_are_named_although_their_names_have_other_numbers(tmp_path):
    """The number of a file's name is that of its pose; ``scan_2 (1).csv`` is a copy all the same, and not the scan of pose 1."""
    write_table(tmp_path / "poses.csv", POSES, ["Nr", "Plane", *(f"J{i}" for i in range(1, 7))], ",")
    for k in range(len(POSES)):
        write_table(
            tmp_path / f"scan_{k + 1}.csv", [[str(i), z] for i, z in enumerate(Z[k])], ["X", "Z"], ","
        )
    shutil.copy(tmp_path / "scan_2.csv", tmp_path / "scan_2 (1).csv")
    columns = {"pose": {"column": "@file_number"}, **{c: {"column": c.upper(), "unit": "mm"} for c in "xz"}}
    result = run(tmp_path, mapping("scan_*.csv", columns=columns), tmp_path)
    refused(tmp_path, result, f"scan_2 (1).csv{HAS}scan_2.csv")
    assert len(result.output.splitlines()) == 1


@pytest.mark.parametrize("raised", [True, False])
def test_a_program_that_ran_twice_is_no_copy_if_its_poses_are_counted_on(tmp_path, raised):
    """Commanded angles are the same on both days. With other numbers of poses, both days are imported; without, the remedy is named."""
    tables = two_tables(tmp_path)
    shutil.copy(tmp_path / "robot.csv", tmp_path / "robot_2.csv")
    second = places() + 0.5
    rows = [[str(k + 1), *(f"{value:.3f}" for value in row)] for k, row in enumerate(second)]
    write_table(tmp_path / "tracker_2.csv", rows, ["Nr", "x", "y", "z"], ",")
    for block, name in (("poses", "robot"), ("points", "tracker")):
        further = {"name": f"{name}_2.csv"} | ({"add_to_pose": 1000} if raised else {})
        tables[block]["files"] = [{"name": f"{name}.csv"}, further]
    if raised:
        assert len(imported(tmp_path, tables, tmp_path).pose_ids) == 2 * N
        return
    refused(tmp_path, run(tmp_path, tables, tmp_path), f"robot_2.csv{HAS}robot.csv", "add_to_pose")
