"""Spreadsheets that state a wrong size, have a damaged row number, or are long."""

import tracemalloc
from zipfile import ZipFile

import openpyxl
import pytest

from scalar.errors import InvalidInput
from scalar.ingest.spreadsheet import read_spreadsheet


def rows_of_sheet(folder, edit):
    """Return the lines of a spreadsheet whose sheet was rewritten, as text."""
    book = openpyxl.Workbook()
    for row in (["id", "x", "z"], [1, 2.0, 3.0], [2, None, 4.0], [3, 5.0]):
        book.active.append(row)
    book.save(folder / "sound.xlsx")
    with ZipFile(folder / "sound.xlsx") as sound, ZipFile(folder / "a.xlsx", "w") as changed:
        for name in sound.namelist():
            content = sound.read(name)
            changed.writestr(name, edit(content) if name.endswith("sheet1.xml") else content)
    table = read_spreadsheet("a.xlsx", (folder / "a.xlsx").read_bytes(), {})
    return table.names, [list(cells) for cells in table.cells], table.lines.tolist()


@pytest.mark.parametrize("size", ["A1", "A1:B2", "A1:XFD1048576", None])
def test_the_size_that_a_spreadsheet_states_does_not_matter(tmp_path, size):
    """A sheet is read to its last row and column whatever it states as its size, and short rows are filled up."""

    def stated(content):
        begin, end = content.index(b"<dimension"), content.index(b"/>", content.index(b"<dimension")) + 2
        return content[:begin] + (f'<dimension ref="{size}"/>'.encode() if size else b"") + content[end:]

    names, cells, lines = rows_of_sheet(tmp_path, stated)
    assert names == ("id", "x", "z")
    assert cells == [["1", "2", "3"], ["2", "", "5"], ["3", "4", ""]]
    assert lines == [2, 3, 4]


def test_a_row_beyond_the_last_of_a_spreadsheet_is_refused(tmp_path):
    """A damaged row number once made the reader fill up hundreds of millions of rows."""
    with pytest.raises(InvalidInput, match="beyond 1048576"):
        rows_of_sheet(tmp_path, lambda content: content.replace(b'<row r="4"', b'<row r="400000000"'))


def test_a_spreadsheet_takes_the_memory_of_its_cells(tmp_path):
    """A sheet of three columns once had ten thousand cells in each row: twenty thousand rows took gigabytes."""
    book = openpyxl.Workbook()
    for k in range(2000):
        book.active.append([k, 0.5 * k, 0.25 * k])
    book.save(tmp_path / "long.xlsx")
    raw = (tmp_path / "long.xlsx").read_bytes()
    tracemalloc.start()
    try:
        assert len(read_spreadsheet("long.xlsx", raw, {"header": False}).lines) == 2000
        assert tracemalloc.get_traced_memory()[1] < 20_000_000
    finally:
        tracemalloc.stop()
