"""Texts in tables to be imported: remarks, signs and letters in other forms, numbers as text, and the names of joints that are converted."""

import unicodedata

import numpy as np
import pytest
from openpyxl import Workbook

from tests.ingest.foreign_tables import N, imported, joints, refused, run
from tests.ingest.two_tables import XYZ, angles, places, two_tables
from tests.small_datasets import description


def test_joints_that_are_converted_are_named(tmp_path):
    """Who imports another joint than the controller shows has to know it before a program is corrected."""
    mapping = two_tables(tmp_path)
    assert "controller" not in run(tmp_path, mapping, tmp_path).output
    columns = mapping["poses"]["columns"]
    columns["q3"]["plus"] = "J2"
    columns["q2"] |= {"sign": -1, "offset": 1.5}
    assert "q2 = -J2 + 1.5 rad, q3 = J3 + J2" in run(tmp_path, mapping, tmp_path).output


def test_remarks_and_signs_of_word_processors_are_read(tmp_path):
    """A line that begins like a remark is passed over where the mapping says so; a true minus sign is a minus sign."""
    mapping = two_tables(tmp_path)
    path = tmp_path / "tracker.csv"
    path.write_text(path.read_text() + "# end of the measurement\n")
    refused(tmp_path, run(tmp_path, mapping, tmp_path), "row 11", "comment: '#'")
    mapping["text"] = {"comment": "#"}
    robot = tmp_path / "robot.csv"
    robot.write_text(robot.read_text().replace("-", "\N{MINUS SIGN}"), encoding="utf-8")
    np.testing.assert_array_equal(imported(tmp_path, mapping, tmp_path).q, angles())


def test_letters_with_dots_are_the_same_however_a_system_writes_them(tmp_path):
    """macOS writes an umlaut of a file's name as a letter and its dots."""
    mapping = two_tables(tmp_path)
    for name, change in (("robot.csv", "Straße Ü.csv"), ("tracker.csv", "Länge.csv")):
        text = (tmp_path / name).read_text().replace("Nr", "Prüfung")
        (tmp_path / unicodedata.normalize("NFD", change)).write_text(unicodedata.normalize("NFD", text))
    mapping["poses"]["files"], mapping["points"]["files"] = (
        [{"name": "Straße Ü.csv"}],
        [{"name": "Länge.csv"}],
    )
    for block in ("poses", "points"):
        mapping[block]["columns"]["pose"] = {"column": "Prüfung"}
    assert len(imported(tmp_path, mapping, tmp_path).pose_ids) == N


@pytest.mark.parametrize("name", ["a.xlsx", "a.xlsm", "a.dat"])
def test_numbers_that_a_spreadsheet_holds_as_text_are_read_as_the_mapping_says(tmp_path, name):
    """Cells of text have the decimal sign and the thousands of the mapping; numbers beside them stay what they are."""
    book = Workbook()
    sheet = book.active
    assert sheet is not None
    sheet.append([*(f"J{i}" for i in range(1, 7)), *"xyz"])
    for q, place in zip(angles(), places(), strict=True):
        german = [f"{value:,.3f}".translate(str.maketrans(".,", ",.")) for value in place]
        sheet.append([*(float(value) for value in q), *german])
    book.save(tmp_path / name)
    mapping = {
        "format": "scalar-mapping/1",
        "text": {"separator": ";", "decimal": ",", "thousands": "."},
        "poses": {"columns": {**joints(), **XYZ}},
        "dataset": description("tracker"),
    }
    data = imported(tmp_path, mapping, tmp_path / name)
    np.testing.assert_array_equal(data.q, angles())
    np.testing.assert_allclose(data.points, places() / 1000, rtol=1e-12)


def test_an_old_spreadsheet_is_named_as_such(tmp_path):
    """It is no text in another encoding."""
    (tmp_path / "a.xls").write_bytes(b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1" + bytes(600))
    mapping = two_tables(tmp_path)
    mapping["poses"] = {"columns": {**joints(), **XYZ}}
    del mapping["points"]
    refused(tmp_path, run(tmp_path, mapping, tmp_path / "a.xls"), "a.xls", "save it as .xlsx")
