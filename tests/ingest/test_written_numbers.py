"""Thousands that are grouped, a row of units and empty rows are read as a person reads them; what may mean two things is asked."""

import numpy as np
import pytest

from scalar.ingest.written_numbers import Written, is_row_of_units
from tests.ingest.foreign_tables import cells, imported, numbers, refused, run, tracker_mapping, write_table


@pytest.mark.parametrize(
    ("decimal", "thousands", "cell", "value"),
    [
        (",", ".", "-1.234,5", -1234.5),
        (",", ".", "1.234.567", 1234567.0),
        (",", ".", "234,5", 234.5),
        (",", ".", "1.5", None),
        (".", ",", "1,234.5", 1234.5),
        (".", "'", "1'234.5", 1234.5),
        (",", " ", "1\N{NARROW NO-BREAK SPACE}234,5", 1234.5),
        (".", "", "1,234.5", None),
        (",", "", "1.234,5", None),
        (".", ",", "12,34.5", None),
        (".", ",", "0,123", None),
    ],
)
def test_a_number_is_what_a_person_reads(decimal, thousands, cell, value):
    """Groups have three digits; anything else is no number."""
    assert Written(decimal, thousands).number(cell) == value


@pytest.mark.parametrize(
    ("decimal", "cell", "words"),
    [
        (",", "1.234,5", ['thousands: "."']),
        (".", "1.234,5", ["decimal: ','", "thousands: '.'"]),
        (".", "1,234", ['thousands: ","', "decimal: ','"]),
        (".", "12,34", ["decimal: ','"]),
        (".", "abc", ["correct it"]),
        (",", "52,132°", ["remove '°' from the cells"]),
        (",", "-571,684 mm", ["remove 'mm' from the cells"]),
        (",", "mm", ["correct it"]),
    ],
)
def test_a_cell_that_is_no_number_is_met_with_what_to_write(decimal, cell, words):
    """A comma before three digits may be either, and both are named."""
    assert all(word in Written(decimal).hint(cell) for word in words)


@pytest.mark.parametrize(
    ("table", "said", "unsaid"),
    [
        (["12,345", "-3828,645"], "decimal: ','", "thousands"),
        (["12,345", "0,250"], "decimal: ','", "thousands"),
        (["12,345", "1,234.5"], 'thousands: ","', "decimal"),
        (["12,345", "1,234,567"], 'thousands: ","', "decimal"),
        (["12,345", "99,125", "wall"], "decimal: ','", ""),
    ],
)
def test_other_cells_of_the_table_show_what_a_comma_before_three_digits_is(table, said, unsaid):
    """Where none of them does, both readings are named, the decimal comma first."""
    hint = Written().hint("12,345", table)
    assert said in hint and (not unsaid or unsaid not in hint)
    assert unsaid or hint.index("decimal: ','") < hint.index('thousands: ","')


def test_a_decimal_comma_that_was_declared_to_separate_thousands_is_named():
    """The declaration that is wrong is named with what takes its place."""
    hint = Written(".", ",").hint("3828,645")
    assert "decimal: ','" in hint and 'in place of thousands: ","' in hint


def test_angles_with_three_decimals_are_known_by_the_lengths_beside_them(tmp_path):
    """The column that is refused needs not show it itself: 12,345 is a decimal number where another column has 1234,5."""
    rows = cells()
    for row in rows:
        row[0] = "12,345"
    mapping = tracker_mapping()
    del mapping["text"]["decimal"]
    ended = run(tmp_path, mapping, write_table(tmp_path / "a.csv", rows))
    refused(tmp_path, ended, "row 2, column J1", "has a decimal comma")


@pytest.mark.parametrize(
    ("row", "expected"),
    [
        (["deg", "[mm]", "°C", "m/s"], True),
        (["°", "mm", "", "-"], True),
        (["nan", "nan", "nan", "nan"], False),
        (["", "", "", ""], False),
        (["1", "mm", "mm", "mm"], False),
        (["degrees of arc", "mm", "mm", "mm"], False),
    ],
)
def test_a_row_of_units_has_short_words_where_numbers_follow(row, expected):
    """A row without a measurement is none, nor is one above words."""
    missing = frozenset({"", "nan"})
    assert is_row_of_units(row, ["1", "2,5", "3", "4"], Written(","), missing) == expected
    assert not is_row_of_units(row, ["a", "b", "c", "d"], Written(","), missing)


def test_a_table_with_units_thousands_and_empty_rows_gives_the_same_numbers(tmp_path):
    """It is what a spreadsheet writes; without ``thousands`` in the mapping, the key is named."""
    rows = cells()
    for row in rows:
        for j in range(6, 9):
            whole, part = row[j].split(",")
            row[j] = f"{int(whole):,}".replace(",", ".") + f",{part}" if abs(int(whole)) > 0 else row[j]
    rows.insert(0, ["deg"] * 6 + ["mm"] * 3)
    rows.insert(4, [""] * 9)
    mapping, path = tracker_mapping(), write_table(tmp_path / "a.csv", rows)
    refused(tmp_path, run(tmp_path, mapping, path), "row 3, column tracker", 'thousands: "."')
    said = run(tmp_path, mapping, path).output
    faults = [line for line in said.splitlines() if "between" in line or "thousands" in line]
    assert len(faults) <= 3, "one line for each column, whatever the number of its cells"
    mapping["text"]["thousands"] = "."
    points = imported(tmp_path, mapping, path).points
    np.testing.assert_allclose(points, numbers()[:, 6:] / 1000, rtol=0, atol=1e-12)


def test_one_sign_cannot_have_two_meanings(tmp_path):
    """The sign between thousands is not the decimal sign."""
    mapping = tracker_mapping()
    mapping["text"]["thousands"] = ","
    refused(
        tmp_path,
        run(tmp_path, mapping, write_table(tmp_path / "a.csv", cells())),
        "text.thousands",
        "decimal sign",
    )


def test_an_axis_that_counts_the_other_way_is_mapped(tmp_path):
    """A mirrored axis of the tracker has the sign -1 in the mapping."""
    mapping = tracker_mapping()
    mapping["poses"]["columns"]["y"]["sign"] = -1
    points = imported(tmp_path, mapping, write_table(tmp_path / "a.csv", cells())).points
    np.testing.assert_allclose(points, numbers()[:, 6:] / 1000 * [1, -1, 1], rtol=0, atol=1e-12)


def test_a_comma_may_be_separator_and_decimal_sign_where_numbers_stand_in_quotes(tmp_path):
    """Such a table is CSV by its standard; without the quotes nothing says where a cell ends, and the message says so."""
    mapping = tracker_mapping()
    mapping["text"]["separator"] = ","
    quoted = [[f'"{cell}"' for cell in row] for row in cells()]
    path = write_table(tmp_path / "a.csv", quoted, separator=",")
    np.testing.assert_allclose(
        imported(tmp_path, mapping, path).points, numbers()[:, 6:] / 1000, rtol=0, atol=1e-12
    )
    path = write_table(tmp_path / "a.csv", cells(), separator=",")
    (tmp_path / "again").mkdir()
    refused(
        tmp_path / "again", run(tmp_path / "again", mapping, path), "a.csv, row 2: 9 rows", "stand in quotes"
    )
    del mapping["text"]["separator"]
    refused(tmp_path / "again", run(tmp_path / "again", mapping, path), "a comma is the separator already")
