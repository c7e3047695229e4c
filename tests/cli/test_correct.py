"""``scalar correct`` takes the arm to the wanted frames, and refuses tables that say too little."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from scalar.cli.pose_lines import lines_on_large_changes, lines_on_setup
from scalar.geometry.robot import Robot
from tests.calibrated_arms import T_SENSOR
from tests.cli.correcting import FRAME, JOINTS, corrected, frames, predicted, run
from tests.robot_configs import robot_mapping


def test_predict_takes_corrected_joints_to_the_nominal_frames(program, arm_calibration):
    """`predict` reads what `correct` writes, and the predicted frames are those of the nominal arm, to 1e-6 m."""
    table = corrected(program, "targets.csv")
    assert list(table["pose"]) == list(range(100, 130))
    predicted(program, "joints.csv")
    q = pd.read_csv(program / "targets.csv")[JOINTS].to_numpy()
    wanted = arm_calibration.model.nominal.flange(q) @ T_SENSOR
    assert np.abs(frames(program / "frames.csv")[:, :3] - wanted[:, :3, 3]).max() < 1e-6
    assert np.abs(table[JOINTS].to_numpy() - q).max() > 1e-4


def test_what_is_not_known_of_the_flange_is_said(program, arm_calibration):
    """If a parameter of the last joint is confounded with the sensor's pose, another tool keeps a constant offset, and the output says so."""
    gauge = ({"held": "d_6", "reason": "", "moves_with": ["sensor_z"], "cause": "structural"},)
    replace(arm_calibration, gauge=gauge).save(program / "fixed.json")
    status, said = run("correct", program / "fixed.json", program / "targets.csv", "-o", program / "t.csv")
    assert status == 0 and "d_6 is not known" in said and "teach its centre point again" in said
    replace(arm_calibration, gauge=()).save(program / "free.json")
    status, said = run("correct", program / "free.json", program / "targets.csv", "-o", program / "u.csv")
    assert status == 0 and "teach" not in said


@pytest.mark.parametrize("given", ["frames", "frames and joints"])
def test_predicted_frames_are_taken_back_to_joints(given, program):
    """Frames are converted to joint angles in the posture of the joints beside them, or else in a posture within the limits."""
    joints = pd.read_csv(program / "targets.csv")
    wanted = predicted(program, "targets.csv")
    rest = joints.drop(columns=["pose", *([] if given != "frames" else JOINTS)])
    pd.concat([wanted, rest], axis=1).to_csv(program / "wanted.csv", index=False, float_format="%.17g")
    table = corrected(program, "wanted.csv")
    predicted(program, "joints.csv")
    assert np.abs(frames(program / "frames.csv")[:, :3] - wanted[FRAME[:3]].to_numpy()).max() < 1e-6
    if given != "frames":
        np.testing.assert_allclose(table[JOINTS], joints[JOINTS], atol=1e-5)


def test_the_approach_of_the_joint_that_needs_it_suffices(program):
    """Play of joint 2 asks for approach2; the other joints need no column, and what is given for them changes nothing."""
    table = pd.read_csv(program / "targets.csv")
    others = [name for name in table.columns if name.startswith("approach") and name != "approach2"]
    assert others
    first = corrected(program, "targets.csv")
    table.drop(columns=others).to_csv(program / "few.csv", index=False, float_format="%.17g")
    np.testing.assert_allclose(corrected(program, "few.csv")[JOINTS], first[JOINTS], atol=1e-9)


@pytest.mark.parametrize(
    "change, options, words",
    [
        (lambda t: t.drop(columns="temperature"), [], "the column 'temperature'"),
        (lambda t: t.drop(columns="approach2"), [], "approach2"),
        (lambda t: t.drop(columns="q3"), [], "column q3: the column is missing"),
        (lambda t: t.assign(x=0.1), [], "column y: the column is missing"),
        (lambda t: t.assign(q1=np.nan), [], "column q1"),
        (lambda t: t.drop(columns=JOINTS), [], "column q1: the column is missing"),
        (lambda t: t.assign(**{q: np.rad2deg(t[q]) for q in JOINTS}), [], "say --units deg"),
        (lambda t: t.assign(**(dict.fromkeys(FRAME, 0.0) | {"x": 400.0})), [], "say --units mm"),
        (lambda t: t, ["--units", "grad"], "write deg,mm"),
        (lambda t: t, ["--units", "deg,rad"], "write deg,mm"),
    ],
)
def test_targets_that_say_too_little_are_refused(change, options, words, program):
    """The exit status is 2, the message names what is missing, and there is no output."""
    change(pd.read_csv(program / "targets.csv")).to_csv(program / "bad.csv", index=False)
    status, said = run(
        "correct", program / "calibration.json", program / "bad.csv", "-o", program / "out.csv", *options
    )
    assert status == 2, said
    assert words in said
    assert "Traceback" not in said
    assert not (program / "out.csv").exists()


def test_joints_that_a_correction_moves_far_are_named():
    """Half a degree is usual, and nothing is said of it; larger moves are listed with joint and size, the largest first."""
    robot = Robot.from_mapping(robot_mapping("vs060"))
    q = np.zeros((5, 6))
    moved = q.copy()
    moved[1, 2], moved[3, 5], moved[4, 0] = np.radians([2.0, -7.5, 0.5])
    near = np.ones(5, dtype=bool)
    (line,) = lines_on_large_changes(robot, np.arange(10, 15), q, moved, ~near)
    assert "same table of joints" in line
    (line,) = lines_on_large_changes(robot, np.arange(10, 15), q, moved, near)
    assert "near a singularity" in line
    assert "pose 13 (joint 6 by 7.5 deg), pose 11 (joint 3 by 2.0 deg);" in line
    assert lines_on_large_changes(robot, np.arange(5), q, moved / 20, near) == []


def test_a_doubt_about_the_table_of_joints_is_repeated_before_a_program_is_corrected():
    """A program of joint angles is understood by that table; other doubts say nothing of it."""
    doubts = [
        {"what": "robot", "sentence": "a_3 comes out 20 mm shorter"},
        {"what": "noise", "sentence": "too large"},
    ]
    (line,) = lines_on_setup(SimpleNamespace(summary={"setup": doubts}))  # type: ignore[arg-type]
    assert "a_3 comes out 20 mm shorter" in line and "table of joints" in line
    assert lines_on_setup(SimpleNamespace(summary={})) == []  # type: ignore[arg-type]
