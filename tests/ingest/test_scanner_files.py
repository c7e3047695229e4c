"""Imports of spreadsheets and of profiles as scanners save them; the tests write files of these layouts."""

import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tests.ingest.scanner_folder import (
    DESCRIPTION,
    PLANES,
    POSES,
    POSES_BLOCK,
    Q,
    X,
    Z,
    check,
    folder_of_poses,
    imported,
    points_block,
)


@pytest.fixture
def folder(tmp_path):
    """Return a folder with the table of poses, whose ids begin at 11."""
    return folder_of_poses(tmp_path)


def test_profiles_of_opencv(folder):
    """Each file has one list of triples, with `.Nan` where nothing was measured; the number in the file's name is the pose."""
    for k in range(POSES):
        z = [".Nan" if i < 2 else f"{value:.8e}" for i, value in enumerate(Z[k])]
        cells = [text for x, value in zip(X, z, strict=True) for text in (f"{x:.8e}", "0.", value)]
        lines = [", ".join(cells[i : i + 6]) for i in range(0, len(cells), 6)]
        text = "%YAML:1.0\n---\nscan_line: [ " + ",\n    ".join(lines) + " ]\n"
        (folder / f"{11 + k}_line.yml").write_text(text, encoding="utf-8")
    status, said, dataset = imported(folder, points_block("*_line.yml"))
    assert status == 0, said
    check(dataset, lost=2)
    (folder / "12_line.yml").write_text("%YAML:1.0\n---\nscan_line: [ 1., 0. ]\n", encoding="utf-8")
    status, said, _ = imported(folder, points_block("*_line.yml"))
    assert status == 2 and "12_line.yml" in said and "triples" in said
    (folder / "12_line.yml").unlink()
    (folder / "13_line.yml").rename(folder / "twelve_line.yml")
    assert "has no number" in imported(folder, points_block("*_line.yml"))[1]


@pytest.mark.parametrize("uniform", [True, False])
def test_recordings_of_a_gocator(folder, uniform):
    """Sections have a header; frames are rows of z under columns of x, or rows of x and rows of z."""
    header = "Frame,Source,Time,Encoder,Z Encoder,Inputs,Exposure,Y,Axis"
    columns = ",".join(f"{x:.4f}" if uniform else str(i) for i, x in enumerate(X))
    rows = []
    for k in range(POSES):
        for axis, values in (("Z", Z[k]), ("I", np.full(len(X), 80))) if uniform else (("X", X), ("Z", Z[k])):
            cells = ["" if axis == "Z" and i < 3 else f"{value:.4f}" for i, value in enumerate(values)]
            rows.append(f"{11 + k},0,{k}.5,0,0,0,100,0,{axis}," + ",".join(cells))
    section = "Profile" if uniform else "RawProfile"
    text = [
        "Info",
        "CSV Version,Sensor Count,Trigger Mode",
        "2,1,0",
        "End",
        "DeviceInfo",
        "ID,Model",
        "1,G",
        "End",
    ]
    text += [
        section,
        "Frame Count,Column Count,X Offset,Y Offset,Z Offset",
        f"{POSES},{len(X)},0,0,0",
        f"{header},{columns}",
    ]
    (folder / "scan.csv").write_text("\n".join([*text, *rows, "End"]) + "\n", encoding="utf-8")
    mapping = points_block("scan.csv", "pose: {column: frame}")
    status, said, dataset = imported(folder, mapping)
    assert status == 0, said
    check(dataset, lost=3)
    (folder / "scan.csv").write_text("\n".join([*text, *[row[:40] for row in rows], "End"]), encoding="utf-8")
    status, said, _ = imported(folder, mapping)
    assert status == 2 and "scan.csv, row 13" in said


def test_plain_columns_in_one_file_for_each_pose(folder):
    """Columns of x and z without a header, separated by tabs, are read."""
    for k in range(POSES):
        lines = [f"{x}\t{z}" for x, z in zip(X, Z[k], strict=True)]
        (folder / f"profile_{11 + k:04d}.txt").write_text("\n".join(lines), encoding="utf-8")
    table = pd.read_csv(folder / "poses.csv")
    table.to_csv(folder / "poses.csv", index=False, header=False, sep="\t")
    mapping = points_block("profile_*.txt")
    for name, number in (("id", 1), ("target", 2), ("A1", 3), ("A2", 4), ("x", 1), ("z", 2)):
        mapping = mapping.replace(f"{{column: {name}", f"{{column: {number}")
    mapping = mapping.replace("poses:\n", "text: {separator: tab, header: false}\nposes:\n", 1)
    status, said, dataset = imported(folder, mapping)
    assert status == 0, said
    check(dataset)


@pytest.mark.parametrize("encoding", ["utf-8", "cp1252"])
def test_a_german_export_with_the_state_of_the_instrument(folder, encoding):
    """The example of docs/mapping.md is read as it stands there: lines of state, semicolons, decimal commas, a mark for what was not measured."""
    for k in range(POSES):
        cells = ["-9999,0000" if i < 2 else f"{value:.4f}".replace(".", ",") for i, value in enumerate(Z[k])]
        head = [
            "scanCONTROL 2900-50",
            f"Messgerät, Profil {11 + k}",
            "Exposure time [ms];1,00",
            "X [mm];Z [mm]",
        ]
        rows = [f"{x:.4f}".replace(".", ",") + f";{cell}" for x, cell in zip(X, cells, strict=True)]
        (folder / f"profile_{11 + k}.csv").write_text("\r\n".join([*head, *rows]) + "\r\n", encoding=encoding)
    page = (Path(__file__).parents[2] / "docs/mapping.md").read_text(encoding="utf-8")
    (block,) = re.findall(r"```yaml\n(points:\n  files: \[\{name: profile_\*.*?)```", page, re.DOTALL)
    if encoding == "cp1252":
        block = block.replace("text: {", "text: {encoding: cp1252, ")
    status, said, dataset = imported(folder, POSES_BLOCK + block + DESCRIPTION)
    assert status == 0, said
    check(dataset, lost=2)
    wrong = block.replace("skip_lines: 3, ", "")
    status, said, _ = imported(folder, POSES_BLOCK + wrong + DESCRIPTION)
    assert status == 2 and "profile_11.csv" in said and "write skip_lines: 3 " in said, said
    named = [line for line in said.splitlines() if "write skip_lines" in line]
    assert len(named) == 4 and f"and {len(list(folder.glob('profile_*.csv'))) - 4} more" in named[-1], said


def test_spreadsheets(folder):
    """The named sheet is read below two lines of title, to the last digit; a missing sheet, one without a table and a damaged file are refused."""
    import openpyxl

    book = openpyxl.Workbook()
    book.active.append(["nothing here"])
    sheet = book.create_sheet("Measured")
    for row in (["Campaign of May"], [], ["id", "target", "A1", "A2", "x", "z"]):
        sheet.append(row)
    for k in range(POSES):
        for x, z in zip(X, Z[k], strict=True):
            sheet.append([11 + k, PLANES[k], Q[k, 0], Q[k, 1], x, z])
    book.save(folder / "all.xlsx")
    lines = POSES_BLOCK.replace("  files: [{name: poses.csv}]\n", "  first_of_each: id\n")
    lines = lines.replace("poses:\n", "text: {sheet: Measured, skip_lines: 2}\nposes:\n", 1)
    lines = lines.replace("    q1:", "    x: {column: x, unit: mm}\n    z: {column: z, unit: mm}\n    q1:")
    status, said, dataset = imported(folder, lines + DESCRIPTION, folder / "all.xlsx")
    assert status == 0, said
    check(dataset)
    status, said, _ = imported(
        folder, (lines + DESCRIPTION).replace("Measured", "Mesured"), folder / "all.xlsx"
    )
    assert status == 2 and "did you mean 'Measured'?" in said
    first = (lines + DESCRIPTION).replace("sheet: Measured, ", "")
    status, said, _ = imported(folder, first, folder / "all.xlsx")
    assert status == 2 and "there is also Measured" in said
    raw = (folder / "all.xlsx").read_bytes()
    (folder / "all.xlsx").write_bytes(raw[: len(raw) // 2])
    status, said, _ = imported(folder, lines + DESCRIPTION, folder / "all.xlsx")
    assert status == 2 and "not a spreadsheet, or damaged" in said and len(said.splitlines()) == 1


def test_a_wrong_unit_is_corrected_in_the_mapping(folder):
    """Where the mapping states another unit than the file has, the message names the mapping's key, and not the scanner's file."""
    lines = [f"{11 + k},{x},{z}" for k in range(POSES) for x, z in zip(X, Z[k], strict=True)]
    (folder / "scans.csv").write_text("\n".join(["Nr,X,Z", *lines]), encoding="utf-8")
    mapping = points_block("scans.csv", "pose: {column: Nr}").replace("column: x", "column: X")
    mapping = mapping.replace("column: z", "column: Z")
    assert imported(folder, mapping)[0] == 0
    status, said, _ = imported(folder, mapping.replace("Z, unit: mm", "Z, unit: m"))
    assert status == 2 and "column Z" in said and "write unit: mm for points.columns.z in m.yaml" in said
    status, said, _ = imported(folder, mapping.replace("unit: deg", "unit: rad"))
    assert status == 2 and "write unit: deg for poses.columns.q1 in m.yaml" in said
    status, said, _ = imported(folder, mapping.replace("length: mm", "length: m"))
    assert status == 2 and "dataset_units: {length: mm}" in said


def test_a_unit_that_is_stated_already_is_not_advised(folder):
    """Numbers that are too large in millimetres as well are said to be another column, or damaged."""
    lines = [f"{11 + k},{x},{1e6 * z}" for k in range(POSES) for x, z in zip(X, Z[k], strict=True)]
    (folder / "scans.csv").write_text("\n".join(["Nr,x,z", *lines]), encoding="utf-8")
    status, said, _ = imported(folder, points_block("scans.csv", "pose: {column: Nr}"))
    assert status == 2 and "states unit: mm already" in said and "are these millimetres" not in said


def test_a_mark_for_no_value_in_every_file_is_named_once(folder):
    """Each profile has the mark of the scanner in a few points: it is no unit that is wrong, and not every file is listed."""
    for k in range(POSES):
        z = [f"{value:.4f}" for value in Z[k]]
        z[3] = z[9] = "-32768"
        rows = [f"{x:.4f},{value}" for x, value in zip(X, z, strict=True)]
        (folder / f"profile_{11 + k}.csv").write_text("\n".join(["x,z", *rows]) + "\n", encoding="utf-8")
    status, said, _ = imported(folder, points_block("profile_*.csv"))
    assert status == 2 and "stands in 2 of 25 points" in said and "text.missing" in said
    assert "millimetres" not in said and said.count("'no value'") == 3
    assert "3 more faults of this kind in other files" in said


def test_a_damaged_number_of_a_profile_is_shown_in_part(folder):
    """A damaged file may have thousands of characters where a number should be; the line that refuses it is short."""
    text = f"%YAML:1.0\n---\nscan_line: [ 1., 0., {'2' * 5000}x ]\n"
    (folder / "11_line.yml").write_text(text, encoding="utf-8")
    status, said, _ = imported(folder, points_block("*_line.yml"))
    assert status == 2 and "number 3 of scan_line is '222" in said and len(said) < 400
