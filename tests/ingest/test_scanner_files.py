"""Imports of spreadsheets and of profiles as scanners save them; the tests write files of these layouts."""

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner

from scalar.cli import cli
from scalar.data.dataset import read_dataset

RNG = np.random.default_rng(3)
POSES = 6
PLANES = ["floor", "wall_x", "wall_y"] * 2
X = np.round(np.linspace(-30.0, 30.0, 25), 4)
Z = np.round(200.0 + 5.0 * RNG.random((POSES, 25)), 4)  # mm
Q = np.round(RNG.uniform(-90, 90, (POSES, 2)), 4)  # deg

DESCRIPTION = """
dataset_units: {length: mm, angle: deg}
dataset:
  name: cell
  robot:
    name: two
    convention: modified-dh
    joints: [{a: 0, alpha: 0, d: 300, theta: 0}, {a: 400, alpha: 90, d: 0, theta: 0}]
  sensor: {kind: line-laser, nominal_pose: {translation: [0, 0, 10], rotation_euler: {axes: ZYX, angles: [90, 0, 180]}}}
  planes:
    - {name: floor, normal: [0, 0, 1], distance: 0}
    - {name: wall_x, normal: [1, 0, 0], distance: 800}
    - {name: wall_y, normal: [0, 1, 0], distance: 800}
"""
POSES_BLOCK = """
format: scalar-mapping/1
poses:
  columns:
    pose: {column: id}
    plane: {column: target}
    q1: {column: A1, unit: deg}
    q2: {column: A2, unit: deg}
  files: [{name: poses.csv}]
"""


@pytest.fixture
def folder(tmp_path):
    """Return a folder with the table of poses, whose ids begin at 11."""
    table = {"id": np.arange(11, 11 + POSES), "target": PLANES, "A1": Q[:, 0], "A2": Q[:, 1]}
    pd.DataFrame(table).to_csv(tmp_path / "poses.csv", index=False)
    return tmp_path


def imported(folder, mapping, *sources):
    """Return status and output of an import, and the dataset where there is one."""
    (folder / "m.yaml").write_text(mapping, encoding="utf-8")
    arguments = ["import", str(folder / "m.yaml"), *map(str, sources or [folder]), "-o", str(folder / "d")]
    result = CliRunner().invoke(cli, arguments)
    return result.exit_code, result.output, read_dataset(folder / "d") if result.exit_code == 0 else None


def points_block(files, columns="pose: {column: '@file_number'}"):
    """Return a mapping whose points are in separate files."""
    return POSES_BLOCK + (
        f"points:\n  columns:\n    {columns}\n    x: {{column: x, unit: mm}}\n    z: {{column: z, unit: mm}}\n"
        f"  drop_without: [z]\n  files: [{{name: '{files}'}}]\n" + DESCRIPTION
    )


def check(dataset, lost=0):
    """Compare a dataset with the numbers written, in radians and metres, without the first ``lost`` points of each scan."""
    np.testing.assert_allclose(dataset.q, np.deg2rad(Q), atol=1e-12)
    for k in range(POSES):
        mine = dataset.points[dataset.starts[k] : dataset.starts[k + 1]]
        np.testing.assert_allclose(mine, np.column_stack([X, Z[k]])[lost:] / 1e3, atol=1e-12)


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
