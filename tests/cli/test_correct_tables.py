"""Columns and units of the tables of ``scalar correct`` and ``scalar predict``."""

import numpy as np
import pandas as pd

from tests.cli.correcting import FRAME, JOINTS, corrected, frames, predicted


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
    assert {"x", "rz_deg"} <= set(predicted(program, "joints.csv"))


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
        own = {
            "corrected",
            "beyond_limits",
            "near_singular",
            "smallest_singular_value",
            "position_error",
            "orientation_error",
        }
        assert set(table.columns) == {*joints.columns, "speed", *own}
        assert (table["speed"] == 250.0).all()
