"""Imports of tables with a profile in each row or in each column, as scanners save them; the tests write files of these layouts."""

import pytest

from tests.ingest.scanner_folder import POSES, X, Z, check, folder_of_poses, imported, points_block


@pytest.fixture
def folder(tmp_path):
    """Return a folder with the table of poses, whose ids begin at 11."""
    return folder_of_poses(tmp_path)


ROWS = points_block("LJ.csv", "pose: {column: No.}").replace("column: x,", "column: '@x',")
ROWS = ROWS.replace("column: z,", "column: '@z',").replace(
    "points:\n", "points:\n  text: {separator: ;, decimal: ',', missing: ['-99,9999']}\n  row_profiles: {}\n"
)


def rows_of_profiles(headers):
    """Return a table with a profile in each row, semicolons and decimal commas; the first two values of each profile are marked as not measured."""
    lines = [
        f"{11 + k};{20.5 + k};-99,9999;-99,9999;" + ";".join(f"{z}" for z in Z[k, 2:]) for k in range(POSES)
    ]
    return (
        "\n".join([";".join(["No.", "T", *headers]), *lines]).replace(".", ",").replace("No,", "No.") + "\n"
    )


def test_a_profile_in_each_row(folder):
    """The headers of the columns state x; the file may have other separators than that of the poses."""
    (folder / "LJ.csv").write_text(rows_of_profiles([f"{x}" for x in X]), encoding="utf-8")
    status, said, dataset = imported(folder, ROWS)
    assert status == 0, said
    check(dataset, lost=2)
    assert f"LJ.csv: {2 * POSES} points in {POSES} rows left out" in said


@pytest.mark.parametrize("headers", [[f"{i + 1}" for i in range(25)], [f"V{i}" for i in range(25)]])
def test_profiles_in_rows_whose_headers_do_not_state_x(folder, headers):
    """Heads that count the values, or name them, are not taken for x; first_x and step say where the values are."""
    (folder / "LJ.csv").write_text(rows_of_profiles(headers), encoding="utf-8")
    status, said, _ = imported(folder, ROWS)
    assert status == 2 and "first_x" in said and "step" in said
    where = f"row_profiles: {{first_column: '{headers[0]}', first_x: -30, step: 2.5}}"
    status, said, dataset = imported(folder, ROWS.replace("row_profiles: {}", where))
    assert status == 0, said
    check(dataset, lost=2)
    half = where.replace(", step: 2.5", "")
    status, said, _ = imported(folder, ROWS.replace("row_profiles: {}", half))
    assert status == 2 and "points.row_profiles" in said and "together" in said


COLUMNS = ROWS.replace("row_profiles: {}", "column_profiles: {x: 'X/mm'}")


def columns_of_profiles(headers):
    """Return a table with a profile in each column, after a count of the values and their x; the first two values of each are not measured."""
    rows = [[f"{x}", *("-99.9999" if i < 2 else f"{z}" for z in Z[:, i])] for i, x in enumerate(X)]
    lines = [";".join([f"{i}", *row]) for i, row in enumerate(rows)]
    return "\n".join([";".join(["i", "X/mm", *headers]), *lines]).replace(".", ",") + "\n"


@pytest.mark.parametrize(("first", "where"), [(11, "@head_number"), (1, "@row")])
def test_a_profile_in_each_column(folder, first, where):
    """One column states x, and all after it are profiles: they are numbered by their headers, or counted."""
    mapping = COLUMNS.replace("No.", f"'{where}'")
    if where == "@row":
        mapping = mapping.replace("column: id", f"column: '{where}'")
    headers = [f"scan 2 P{first + k:03d}" for k in range(POSES)]
    (folder / "LJ.csv").write_text(columns_of_profiles(headers), encoding="utf-8")
    status, said, dataset = imported(folder, mapping)
    assert status == 0, said
    check(dataset, lost=2)
    assert list(dataset.pose_ids) == list(range(first, first + POSES))


def test_heads_that_number_no_profile_are_refused(folder):
    """Where the number is the same in all headers, no profile is taken for another's."""
    (folder / "LJ.csv").write_text(
        columns_of_profiles([f"{'x' * k}_2026" for k in range(POSES)]), encoding="utf-8"
    )
    status, said, _ = imported(folder, COLUMNS.replace("No.", "'@head_number'"))
    assert status == 2 and "a number of its own" in said and "@row" in said


def test_profiles_in_rows_without_a_number(folder):
    """Where neither file numbers its rows, both count them from 1 (@row)."""
    table = rows_of_profiles([f"{x}" for x in X])
    (folder / "LJ.csv").write_text(
        "\n".join(line.split(";", 1)[1] for line in table.splitlines()), encoding="utf-8"
    )
    mapping = ROWS.replace("column: No.", "column: '@row'").replace("column: id", "column: '@row'")
    status, said, dataset = imported(folder, mapping)
    assert status == 0, said
    check(dataset, lost=2)
    assert list(dataset.pose_ids) == [1, 2, 3, 4, 5, 6]
