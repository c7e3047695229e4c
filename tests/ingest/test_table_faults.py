"""Every fault of a foreign table is refused by its file, row and column, and nothing is written."""

import numpy as np
import pandas as pd
import pytest

from tests.ingest.foreign_tables import cells, header, refused, run, tracker_mapping, write_table


@pytest.mark.parametrize(
    ("row", "column", "text", "words"),
    [
        (3, 1, "abc", ("a.csv, row 5, column J2", "abc")),
        (3, 1, "1.5", ("a.csv, row 5, column J2", "decimal: ','")),
        (3, 1, "1.234,5", ("a.csv, row 5, column J2", 'thousands: "."')),
        (0, 0, "1e999", ("a.csv, row 2, column J1", "finite")),
        (0, 8, "", ("a.csv, row 2, column tracker Z", "empty")),
        (4, 3, "90000", ("a.csv, row 6, column J4", "suspect")),
        (2, 6, "1;2", ("a.csv, row 4", "10 cells where 9")),
        (2, 6, '"1', ("a.csv", "quotes")),
    ],
)
def test_a_wrong_cell_is_named_by_row_and_column_of_its_own_file(tmp_path, row, column, text, words):
    """The row is the one that an editor shows, and the column has its name in the file."""
    rows = cells()
    rows[row][column] = text
    refused(tmp_path, run(tmp_path, tracker_mapping(), write_table(tmp_path / "a.csv", rows)), *words)


def test_a_title_before_the_table_is_one_fault_which_says_how_many_lines_to_skip(tmp_path):
    """A line with fewer cells than nearly all lines after it names no columns."""
    path = write_table(tmp_path / "a.csv", cells())
    text = path.read_text(encoding="utf-8")
    path.write_text("Protocol of cell 4\nMonday\n" + text, encoding="utf-8")
    result = run(tmp_path, tracker_mapping(), path)
    refused(tmp_path, result, "skip_lines: 2")
    assert len(result.stderr.splitlines()) == 1
    assert "header: false" not in result.stderr


def test_numbers_below_a_title_are_not_taken_for_names(tmp_path):
    """Where no line names the columns, to skip the title alone would make names of the first pose and lose it."""
    path = write_table(tmp_path / "a.csv", cells())
    _, *numbers = path.read_text(encoding="utf-8").splitlines(keepends=True)
    path.write_text("Protocol of cell 4\n" + "".join(numbers), encoding="utf-8")
    refused(tmp_path, run(tmp_path, tracker_mapping(), path), "skip_lines: 1", "header: false")


@pytest.mark.parametrize(("names", "expected"), [("P{:03d}", 0), ("P{:03d}-7", 2), ("P{0}.{0}", 2)])
def test_poses_with_a_name_have_the_number_in_it(tmp_path, names, expected):
    """P001 is pose 1; where a name holds two numbers that differ, or has no number of its own, it is refused."""
    mapping, rows = tracker_mapping(), cells()
    mapping["poses"]["columns"]["pose"] = {"column": "Point"}
    path = write_table(
        tmp_path / "a.csv", [[*row, names.format(k + 1)] for k, row in enumerate(rows)], [*header(), "Point"]
    )
    result = run(tmp_path, mapping, path)
    assert result.exit_code == expected, result.output


def test_decimal_commas_that_the_mapping_does_not_mention_give_few_messages(tmp_path):
    """If every cell of nine columns is wrong, each column has one message, which counts them, shows the first and names the key to set."""
    mapping = tracker_mapping()
    del mapping["text"]["decimal"]
    rows = cells() * 5
    result = run(tmp_path, mapping, write_table(tmp_path / "a.csv", rows))
    refused(tmp_path, result, f"none of the {len(rows)} cells is a number", "write decimal: ',' under text")
    assert len(result.stderr.splitlines()) == len(rows[0])


@pytest.mark.parametrize(
    ("text", "seconds"),
    [
        (["9:00:00", "09:01:30", "10:00:00.5"], [32_400.0, 32_490.0, 36_000.5]),
        (["23:59:30", "23:59:45", "00:00:15"], [86_370.0, 86_385.0, 86_415.0]),
        (["12:00", "12:01", "12:03"], [43_200.0, 43_260.0, 43_380.0]),
        (
            ["2026-11-26 23:59:30", "2026-11-27T00:00:15", "2026-11-27T00:01:00,5"],
            [86_370.0, 86_415.0, 86_460.5],
        ),
        (
            ["2026-11-26T01:00:00+01:00", "2026-11-26T00:00:30Z", "2026-11-26T01:01:00+01:00"],
            [0.0, 30.0, 60.0],
        ),
    ],
)
def test_times_of_day_are_seconds(tmp_path, text, seconds):
    """A column `time` may hold times of day; midnight in between does not turn the clock back."""
    mapping, rows = tracker_mapping(), cells()
    mapping["poses"]["columns"]["time"] = {"column": "Clock"}
    table = [[*row, text[min(k, 2)]] for k, row in enumerate(rows)]
    result = run(tmp_path, mapping, write_table(tmp_path / "a.csv", table, [*header(), "Clock"]))
    assert result.exit_code == 0, result.output
    written = next(tmp_path.rglob("poses.csv"))
    assert list(np.sort(pd.read_csv(written)["time"].unique())) == seconds


def test_what_is_no_time_of_day_is_refused(tmp_path):
    """A column `time` with a word in one row is a column of numbers with faults."""
    mapping, rows = tracker_mapping(), cells()
    mapping["poses"]["columns"]["time"] = {"column": "Clock"}
    table = [[*row, "9:00:00" if k else "soon"] for k, row in enumerate(rows)]
    result = run(tmp_path, mapping, write_table(tmp_path / "a.csv", table, [*header(), "Clock"]))
    refused(tmp_path, result, "not a number ('soon')")


@pytest.mark.parametrize("date", ["24/11/2026", "2026-11-24", "11/24/2026 13:00 PM"])
def test_dates_are_named_as_such(tmp_path, date):
    """A column `time` with dates is one fault, which says what is read instead."""
    mapping = tracker_mapping()
    mapping["poses"]["columns"]["time"] = {"column": "Clock"}
    table = [[*row, date] for row in cells()]
    result = run(tmp_path, mapping, write_table(tmp_path / "a.csv", table, [*header(), "Clock"]))
    refused(tmp_path, result, "a.csv, row 2, column Clock", "dates are not read", "09:04:30")
    assert len(result.stderr.splitlines()) == 1


def test_a_file_in_utf_16_is_recognised(tmp_path):
    """A spreadsheet's "Unicode text" is refused with the encoding to write, and read with it."""
    path, mapping = write_table(tmp_path / "a.csv", cells()), tracker_mapping()
    path.write_bytes(path.read_bytes().decode().encode("utf-16"))
    refused(tmp_path, run(tmp_path, mapping, path), "set text.encoding in the mapping to utf-16")
    mapping["text"]["encoding"] = "utf-16"
    assert run(tmp_path, mapping, path).exit_code == 0


def test_all_faults_of_all_files_are_reported_at_once(tmp_path):
    """Faults of two files are reported together."""
    rows = cells()
    rows[1][1] = "x"
    one = write_table(tmp_path / "a.csv", rows)
    rows = cells()
    rows[2][2] = "y"
    two = write_table(tmp_path / "b.csv", rows)
    result = run(tmp_path, tracker_mapping(), one, two)
    refused(tmp_path, result, "a.csv, row 3, column J2", "b.csv, row 4, column J3")


def test_an_id_that_stands_twice_is_refused_across_files(tmp_path):
    """Files that count their poses from the same number cannot both keep their ids."""
    rows = [[str(i), *row] for i, row in enumerate(cells())]
    names = ["id", *header()]
    anew = [[*row[:-1], row[-1] + "1"] for row in rows]  # measured again
    files = [write_table(tmp_path / "a.csv", rows, names), write_table(tmp_path / "b.csv", anew, names)]
    mapping = tracker_mapping()
    mapping["poses"]["columns"]["pose"] = {"column": "id"}
    refused(tmp_path, run(tmp_path, mapping, *files), "b.csv, row 2, column id", "pose 0 stands already")
    rows[3][0] = "2,5"
    result = run(tmp_path, mapping, write_table(tmp_path / "a.csv", rows, names))
    refused(tmp_path, result, "a.csv, row 5, column id", "not an integer")


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", ("a.csv", "no rows")),
        (b"J1;J2\r\n", ("a.csv", "no rows")),
        (b"\xff\xfe\x00;\xd8", ("a.csv", "not utf-8")),
        (b"a,b,c\n1,2,3\n", ("a.csv", "separator")),
        (b"\x00\x00\x00", ("a.csv",)),
    ],
)
def test_a_file_that_is_no_table_is_refused(tmp_path, content, words):
    """A file that is empty, has another encoding or separator, or is no text, is refused by name."""
    (tmp_path / "a.csv").write_bytes(content)
    refused(tmp_path, run(tmp_path, tracker_mapping(), tmp_path / "a.csv"), *words)


def test_an_import_never_replaces_what_is_no_dataset(tmp_path):
    """A folder with something else in it stays as it is; a dataset is replaced whole."""
    table = write_table(tmp_path / "a.csv", cells())
    (tmp_path / "out").mkdir()
    (tmp_path / "out/thesis.txt").write_text("mine")
    result = run(tmp_path, tracker_mapping(), table)
    assert result.exit_code == 2
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["thesis.txt"]


def test_a_header_that_stands_twice_is_named(tmp_path):
    """Two logs in one file have it again; it is no number that is written wrongly."""
    rows = cells()
    rows.insert(4, header())
    ended = run(tmp_path, tracker_mapping(), write_table(tmp_path / "a.csv", rows))
    refused(tmp_path, ended, "a.csv, row 6: the names of the columns stand here again")
    assert ended.output.count("\n") == 1
