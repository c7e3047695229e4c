"""Tables of `scalar correct` and `scalar predict` with semicolons and decimal commas, as spreadsheets save them in many languages."""

import numpy as np
import pandas as pd
import pytest

from scalar.ingest.dh_table import robot_from_dh_table
from tests.cli.correcting import FRAME, JOINTS, corrected, predicted, run


def as_a_spreadsheet_saves(program, name, table, decimal=","):
    """Write a table with semicolons and return the name of its file."""
    table.to_csv(program / name, sep=";", decimal=decimal, index=False, float_format="%.17g")
    return name


@pytest.mark.parametrize("decimal", [",", "."])
def test_a_table_with_semicolons_is_read_and_written_in_its_own_form(program, decimal):
    """Joint angles and frames are those of the same table with commas, and the output has the form of the input; texts are copied as they are."""
    targets = pd.read_csv(program / "targets.csv")
    plain = corrected(program, "targets.csv")
    at = predicted(program, "targets.csv")
    comments = [f"a, b; {i} \u00fc" for i in range(len(targets))]
    name = as_a_spreadsheet_saves(program, "excel.csv", targets.assign(comment=comments, speed=0.5), decimal)
    status, said = run("correct", program / "calibration.json", program / name, "-o", program / "out.csv")
    assert status == 0 and "semicolons and decimal" in said
    written = pd.read_csv(program / "out.csv", sep=";", decimal=decimal)
    np.testing.assert_allclose(written[JOINTS], plain[JOINTS], atol=1e-12)
    assert list(written["comment"]) == comments and set(written["speed"]) == {0.5}
    status, said = run("predict", program / "calibration.json", program / name, "-o", program / "at.csv")
    assert status == 0, said
    np.testing.assert_allclose(
        pd.read_csv(program / "at.csv", sep=";", decimal=decimal)[FRAME], at[FRAME], atol=1e-11
    )


def test_a_row_without_joint_angles_has_decimal_commas_in_the_others(program):
    """Where one frame is out of reach, the cells of its row are empty and the others keep decimal commas."""
    needed = pd.read_csv(program / "targets.csv").drop(columns=["pose", *JOINTS])
    wanted = pd.concat([predicted(program, "targets.csv"), needed], axis=1).head(3)
    wanted.loc[1, "x"] += 3.0
    name = as_a_spreadsheet_saves(program, "wanted.csv", wanted)
    status, said = run("correct", program / "calibration.json", program / name, "-o", program / "joints.csv")
    assert status == 2 and "pose 101" in said, said
    written = pd.read_csv(program / "joints.csv", sep=";", decimal=",")
    assert written["q1"].isna().sum() == 1
    assert written[JOINTS].dtypes.eq(float).all()
    rest = as_a_spreadsheet_saves(program, "rest.csv", written.dropna())
    back = run("predict", program / "calibration.json", program / rest, "-o", program / "back.csv")
    assert back[0] == 0, back[1]
    back = pd.read_csv(program / "back.csv", sep=";", decimal=",")
    np.testing.assert_allclose(back[FRAME[:3]], wanted.drop(index=1)[FRAME[:3]], atol=1e-6)


def test_commas_beside_decimal_points_are_refused(program):
    """If some numbers have points and others commas, a comma may separate thousands: nothing is guessed, and the cell is named."""
    targets = pd.read_csv(program / "targets.csv")
    name = as_a_spreadsheet_saves(program, "mixed.csv", targets, ".")
    path = program / name
    lines = path.read_text(encoding="utf-8").splitlines()
    lines[1] = lines[1].replace(".", ",", 1)
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    status, said = run("correct", program / "calibration.json", path, "-o", program / "out.csv")
    assert status == 2 and "mixed.csv, row 2, column q1" in said and "decimal point" in said
    assert not (program / "out.csv").exists()


def test_points_between_thousands_are_said_to_be_that(program):
    """A spreadsheet may write 1.010,5: the message says what the point is, and how the number is read."""
    targets = pd.read_csv(program / "targets.csv")
    path = program / as_a_spreadsheet_saves(program, "thousands.csv", targets)
    lines = path.read_text(encoding="utf-8").splitlines()
    at = lines[0].split(";").index("q1")
    cells = lines[1].split(";")
    cells[at] = "1.010,5"
    lines[1] = ";".join(cells)
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    status, said = run("correct", program / "calibration.json", path, "-o", program / "out.csv")
    assert status == 2 and "thousands.csv, row 2, column q1" in said
    assert "leave out the points between thousands: write 1010.5 (or 1010,5" in said


def test_a_table_of_dh_parameters_may_have_semicolons(tmp_path):
    """`scalar init --dh` takes the lengths and angles of such a table as they are meant."""
    (tmp_path / "dh.csv").write_text(
        "a_mm;alpha_deg;d_mm;theta_deg\n150,5;-90;450;0\n614;180;0;-90\n200,25;-90;0;0\n", encoding="utf-8"
    )
    robot = robot_from_dh_table(tmp_path / "dh.csv", "standard-dh", "arm")
    assert [joint["a"] for joint in robot["joints"]] == pytest.approx([0.1505, 0.614, 0.20025])


def test_the_form_of_an_earlier_output_is_recognised(program):
    """A command replaces its own earlier output with semicolons without --force."""
    name = as_a_spreadsheet_saves(program, "excel.csv", pd.read_csv(program / "targets.csv"))
    for _ in range(2):
        status, said = run("predict", program / "calibration.json", program / name, "-o", program / "at.csv")
        assert status == 0, said
