"""Columns and units of the tables of ``scalar correct`` and ``scalar predict``."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.transform import Rotation

from scalar.effects.payload_deflection import PayloadDeflection
from tests.cli.correcting import FRAME, JOINTS, WRITTEN, corrected, frames, predicted, run


def test_degrees_and_millimetres_give_the_same(program):
    """Tables in degrees and millimetres, by option or by their names, give the same as those in SI units; the output states its units."""
    si = corrected(program, "targets.csv")
    si_frames = predicted(program, "joints.csv", "--std")
    joints = pd.read_csv(program / "targets.csv")
    joints[JOINTS] = np.rad2deg(joints[JOINTS])
    joints.to_csv(program / "by_option.csv", index=False, float_format="%.17g")
    by_name = joints.rename(columns={name: f"{name}_deg" for name in JOINTS})
    by_name.to_csv(program / "by_name.csv", index=False, float_format="%.17g")
    degrees = corrected(program, "by_option.csv", "--units", "deg,mm")
    assert "q1" not in degrees
    np.testing.assert_allclose(np.deg2rad(degrees[[f"{n}_deg" for n in JOINTS]]), si[JOINTS], atol=1e-9)
    in_units = predicted(
        program, "joints.csv", "--std", "--units", "deg,mm"
    )  # names say deg: no doubt what is meant
    for name, unit, size in (("x", "mm", 1e3), ("rz", "deg", np.rad2deg(1))):
        np.testing.assert_allclose(in_units[f"{name}_{unit}"], si_frames[name] * size, atol=1e-6)
    np.testing.assert_allclose(in_units["y_std_mm"], si_frames["y_std"] * 1e3, rtol=1e-6)
    np.testing.assert_allclose(in_units["x_y_correlation"], si_frames["x_y_correlation"], atol=1e-6)
    named = corrected(program, "by_name.csv")
    np.testing.assert_allclose(np.deg2rad(named[[f"{n}_deg" for n in JOINTS]]), si[JOINTS], atol=1e-9)
    assert {"x_mm", "rz_deg"} <= set(predicted(program, "joints.csv"))


def test_written_frames_are_read_again_in_their_units(program):
    """`correct` reads what `predict` writes in millimetres and degrees, without the option --units."""
    joints = pd.read_csv(program / "targets.csv")
    wanted = predicted(program, "targets.csv")
    named = joints.rename(columns={name: f"{name}_rad" for name in JOINTS})
    # named with their unit, the joints stay in rad
    named.to_csv(program / "named.csv", index=False, float_format="%.17g")
    in_units = predicted(program, "named.csv", "--units", "mm,deg")
    pd.concat([in_units, joints.drop(columns="pose")], axis=1).to_csv(
        program / "wanted.csv", index=False, float_format="%.17g"
    )
    corrected(program, "wanted.csv")
    predicted(program, "joints.csv")
    assert np.abs(frames(program / "frames.csv")[:, :3] - wanted[FRAME[:3]].to_numpy()).max() < 1e-6


def test_millimetres_among_degrees_keep_the_unit_of_the_angles(program):
    """Who says --units deg and forgets mm is told both, because --units mm alone would read the angles as radians."""
    wanted = predicted(program, "targets.csv", "--units", "deg,mm")
    wanted.columns = [name.removesuffix("_mm").removesuffix("_deg") for name in wanted.columns]
    wanted.to_csv(program / "far.csv", index=False)
    table, output = program / "far.csv", program / "x.csv"
    status, said = run("correct", program / "calibration.json", table, "-o", output, "--units", "deg")
    assert status == 2 and "say --units deg,mm" in said


def test_what_a_tracker_does_not_know_of_a_target_is_left_out(program):
    """Standard deviations of a tracked target's position are written, and those of its orientation, which nothing showed, are not."""
    table = predicted(program, "targets.csv", "--std")
    assert {"x_std", "y_z_correlation"} <= set(table.columns)
    assert not {"rx_std", "x_rx_correlation", "rx_ry_correlation"} & set(table.columns)


def test_other_columns_are_kept_and_those_of_the_frame_are_not(program):
    """From frames with their uncertainties, as `predict --std` writes them, and a speed, the output keeps the speed and leaves out the frame."""
    joints = pd.read_csv(program / "targets.csv")
    for units in ([], ["--units", "deg,mm"]):
        if units:
            named = joints.rename(columns={name: f"{name}_rad" for name in JOINTS})
            named.to_csv(program / "named.csv", index=False, float_format="%.17g")
        wanted = predicted(program, "named.csv" if units else "targets.csv", "--std", *units)
        assert any("std" in name for name in wanted) and any("correlation" in name for name in wanted)
        rest = joints.drop(columns="pose").assign(speed=250.0)
        pd.concat([wanted, rest], axis=1).to_csv(program / "wanted.csv", index=False, float_format="%.17g")
        table = corrected(program, "wanted.csv")
        assert set(table.columns) == {*joints.columns, "speed", *WRITTEN}
        assert (table["speed"] == 250.0).all()


@pytest.mark.parametrize("units", [(), ("--units", "deg,mm")])
def test_orientations_in_other_forms_are_written_and_read(program, units):
    """`predict --orientation` adds roll, pitch and yaw, and quaternions, which are the same rotations by SciPy; `correct` takes frames in each
    form to the same joint angles, and copies none of their columns."""
    joints = pd.read_csv(program / "targets.csv")
    if units:
        joints[JOINTS] = np.degrees(joints[JOINTS])
        joints.to_csv(program / "targets.csv", index=False, float_format="%.17g")
    table = predicted(program, "targets.csv", "--orientation", "rpy", "--orientation", "quaternion", *units)
    mm, deg = ("_mm", "_deg") if units else ("", "")
    vector, rpy = (
        [f"{name}{deg}" for name in names] for names in (("rx", "ry", "rz"), ("roll", "pitch", "yaw"))
    )
    quaternion, place = ["qw", "qx", "qy", "qz"], ["pose", *(f"{name}{mm}" for name in "xyz")]
    turned = Rotation.from_rotvec(table[vector], degrees=bool(units))
    from_rpy = Rotation.from_euler("xyz", table[rpy], degrees=bool(units))
    from_quaternion = Rotation.from_quat(table[["qx", "qy", "qz", "qw"]])
    for other in (from_rpy, from_quaternion):
        assert np.max((turned.inv() * other).magnitude()) < 1e-9
    needs = joints.drop(columns=["pose", *JOINTS])
    found = []
    for form in (vector, rpy, quaternion):
        given = pd.concat([table[[*place, *form]], needs, joints[JOINTS]], axis=1)
        given.to_csv(program / "wanted.csv", index=False, float_format="%.17g")
        out = corrected(program, "wanted.csv", *units)
        assert not {*form, "roll", "qw"} & set(out.columns)
        found.append(out[[f"{name}{deg}" for name in JOINTS]].to_numpy())
    np.testing.assert_allclose(found[1], found[0], atol=1e-6)
    np.testing.assert_allclose(found[2], found[0], atol=1e-6)


@pytest.mark.parametrize(
    ("names", "makers"),
    [
        (("a", "b", "c"), ["KUKA"]),
        (("W", "P", "R"), ["FANUC"]),
        (("q1", "q2", "q3"), ["ABB"]),
        (("u", "v", "w"), []),
    ],
)
def test_a_table_without_an_orientation_is_refused_with_all_forms(names, makers, program):
    """Places with columns of other names are one fault that names the three forms of an orientation; names of the makers are translated."""
    wanted = predicted(program, "targets.csv").rename(columns=dict(zip(FRAME[3:], names, strict=True)))
    if "q1" in names:
        wanted["q4"] = 1.0
    wanted.to_csv(program / "wanted.csv", index=False)
    status, said = run(
        "correct", program / "calibration.json", program / "wanted.csv", "-o", program / "joints.csv"
    )
    assert status == 2 and len(said.splitlines()) == 1
    assert all(form in said for form in ("rx,ry,rz", "roll,pitch,yaw", "qw,qx,qy,qz"))
    assert [maker for maker in ("KUKA", "FANUC", "ABB") if maker in said] == makers


def test_a_quaternion_of_another_norm_is_refused(program):
    """The row is named; nothing is written."""
    table = predicted(program, "targets.csv", "--orientation", "quaternion").drop(columns=["rx", "ry", "rz"])
    table.loc[3, "qw"] += 1.0
    table.to_csv(program / "wanted.csv", index=False)
    status, said = run(
        "correct", program / "calibration.json", program / "wanted.csv", "-o", program / "out.csv"
    )
    assert status == 2 and "row 5" in said and "the quaternion of pose 103 has the norm" in said
    assert not (program / "out.csv").exists()


def test_a_column_called_roll_beside_joint_angles_is_copied(program):
    """In a table of joint angles `roll` is no orientation: its numbers are those of the user, in any unit."""
    joints = pd.read_csv(program / "targets.csv").assign(roll=12.5)
    joints[JOINTS] = np.degrees(joints[JOINTS])
    joints.to_csv(program / "targets.csv", index=False, float_format="%.17g")
    assert (corrected(program, "targets.csv", "--units", "deg,mm")["roll"] == 12.5).all()


@pytest.mark.parametrize("form", ["joints", "frames"])
def test_text_and_empty_cells_of_other_columns_are_copied_as_they_are(form, program):
    """A comment, a column of blanks, numbers with gaps, leading or trailing zeros, and text with a comma stand in the output as in the input."""
    table = pd.read_csv(program / "targets.csv")
    if form == "frames":
        table = pd.concat([predicted(program, "targets.csv"), table.drop(columns=["pose", *JOINTS])], axis=1)
    n = len(table)
    own = {
        "comment": [f"weld {i}" for i in range(n)],
        "nothing": [""] * n,
        "speed": ["250", ""] * (n // 2),
        "name": ["a, b"] * n,
        "decimal": ["12,5"] * n,
        "tool": ["007"] * n,
        "feed": ["1.50"] * n,
    }
    table.assign(**own).to_csv(program / "own.csv", index=False, float_format="%.17g")
    corrected(program, "own.csv")
    written = pd.read_csv(program / "joints.csv", dtype=str, keep_default_na=False)
    for name, cells in own.items():
        assert written[name].tolist() == cells


@pytest.mark.parametrize("end", ["\r", "\r\n", "\n\n"])
def test_a_table_of_any_line_ends_is_copied(end, program):
    """Old and new line ends, blank lines, a mark of UTF-8 and a comma in the quoted name of a column change nothing."""
    table = pd.read_csv(program / "targets.csv")
    table["tool, name"] = [f"00{i}, x" for i in range(len(table))]
    text = table.to_csv(index=False, float_format="%.17g", lineterminator=end)
    (program / "own.csv").write_bytes(b"\xef\xbb\xbf" + text.encode())
    corrected(program, "own.csv")
    written = pd.read_csv(program / "joints.csv", dtype=str, keep_default_na=False)
    assert written["tool, name"].tolist() == table["tool, name"].tolist()


def test_a_column_that_an_effect_needs_has_to_hold_numbers(program):
    """A temperature is known, and a cell of it that is no number is refused with its row, as is a joint angle."""
    table = pd.read_csv(program / "targets.csv").astype({"temperature": object, "q2": object})
    table.loc[3, "temperature"] = "warm"
    table.loc[4, "q2"] = ""
    table.to_csv(program / "bad.csv", index=False)
    status, said = run(
        "correct", program / "calibration.json", program / "bad.csv", "-o", program / "joints.csv"
    )
    assert status == 2 and not (program / "joints.csv").exists()
    assert "row 5, column temperature: not a number ('warm')" in said
    assert "row 6, column q2: an empty cell" in said


def test_text_in_a_covariate_that_an_effect_needs_is_not_called_missing(program, arm_calibration):
    """A payload is known to the effect alone; it is there, and the message says that it has to be numbers."""
    effect = PayloadDeflection((2,))
    loaded = replace(arm_calibration.model, effects=(effect,))
    replace(arm_calibration, model=loaded, free=(), covariance=np.empty((0, 0))).save(
        program / "calibration.json"
    )
    pd.read_csv(program / "targets.csv").assign(payload="heavy").to_csv(program / "bad.csv", index=False)
    status, said = run(
        "correct", program / "calibration.json", program / "bad.csv", "-o", program / "joints.csv"
    )
    assert status == 2 and "column payload" in said and "not all of its cells are numbers" in said
    assert "missing" not in said


def test_frames_where_joint_angles_belong_are_one_fault(program):
    """`predict` names `scalar correct` for a table of frames, in one line; a table of neither lacks its columns of joint angles."""
    predicted(program, "targets.csv")
    for name, table in (("frames.csv", None), ("neither.csv", "pose,speed\n1,2\n")):
        if table is not None:
            (program / name).write_text(table)
        status, said = run("predict", program / "calibration.json", program / name, "-o", program / "out.csv")
        assert status == 2 and ("scalar correct" in said) == (table is None)
        assert len(said.splitlines()) == (1 if table is None else 6)


def test_rows_of_both_kinds_are_counted_and_not_listed_cell_by_cell(program):
    """A table in which some rows have joint angles alone and some frames alone is refused in a line for each kind, also with semicolons.

    Single empty cells are named as everywhere.
    """
    joints = pd.read_csv(program / "targets.csv")
    table = joints.merge(predicted(program, "targets.csv"), on="pose")
    mixed = table.copy()
    mixed.loc[:3, FRAME] = np.nan
    mixed.loc[10:, JOINTS] = np.nan
    mixed.to_csv(program / "commas.csv", index=False)
    mixed.to_csv(program / "semicolons.csv", index=False, sep=";", decimal=",")
    for name in ("commas.csv", "semicolons.csv"):
        status, said = run("correct", program / "calibration.json", program / name, "-o", program / "out.csv")
        assert status == 2
        first, second = said.splitlines()
        assert "row 12: 20 rows have a wanted frame and no joint angles, the last in row 31" in first
        assert "row 2: 4 rows have joint angles and no wanted frame, the last in row 5" in second
    table.loc[4, "q3"] = np.nan
    table.to_csv(program / "hole.csv", index=False)
    status, said = run(
        "correct", program / "calibration.json", program / "hole.csv", "-o", program / "out.csv"
    )
    assert status == 2 and "row 6, column q3: an empty cell" in said


def test_orientations_in_degrees_without_units_are_refused(program):
    """A rotation vector of more than a turn is degrees; the refusal says how to state them, and what it says is accepted."""
    wanted = predicted(program, "targets.csv")
    wanted[FRAME[3:]] = np.rad2deg(wanted[FRAME[3:]])
    wanted.to_csv(program / "in_degrees.csv", index=False, float_format="%.17g")
    status, said = run(
        "correct", program / "calibration.json", program / "in_degrees.csv", "-o", program / "out.csv"
    )
    assert status == 2 and "more than a turn" in said and "rx_deg, ry_deg, rz_deg" in said
    named = wanted.rename(columns={name: f"{name}_deg" for name in FRAME[3:]})
    others = pd.read_csv(program / "targets.csv").drop(columns=["pose", *JOINTS])
    pd.concat([named, others], axis=1).to_csv(
        program / "named_degrees.csv", index=False, float_format="%.17g"
    )
    corrected(program, "named_degrees.csv")
