"""``scalar correct`` and the units of ``scalar predict``: tables in, tables out, and what is refused."""

import re
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner

from scalar.cli import cli
from scalar.data.io.plain_yaml import load_yaml
from scalar.effects.joint_backlash import JointBacklash
from scalar.effects.joint_harmonic import JointHarmonic
from scalar.effects.thermal_drift import ThermalDrift
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import log_so3
from tests.calibrated_arms import T_SENSOR, calibrated
from tests.robot_configs import ROBOT_CONFIGS

FRAME = ["x", "y", "z", "rx", "ry", "rz"]
JOINTS = [f"q{i}" for i in range(1, 7)]


def run(*arguments):
    """Return status and output of the command line."""
    result = CliRunner().invoke(cli, [str(a) for a in arguments])
    return result.exit_code, result.output


@pytest.fixture(scope="module")
def calibration():
    """Return the calibration of an arm with a gear, play and growth with temperature, half of it known to a standard deviation."""
    effects = (
        JointHarmonic(4, (2,), coefficients=np.array([3e-4, 1e-4])),
        JointBacklash(2, "approach", coefficients=np.array([2e-4])),
        ThermalDrift("temperature", 20.0, coefficients=np.array([2e-5])),
    )
    robot = Robot.from_mapping(load_yaml(ROBOT_CONFIGS / "vs060.yaml"))
    made = calibrated(robot, np.random.default_rng(1), effects)
    free = ("a_2", "theta_3", "sensor_x")
    return replace(made, free=free, covariance=np.diag([1e-5, 2e-5, 3e-5]) ** 2, fixed={})


@pytest.fixture
def cell(tmp_path, calibration):
    """Return a folder with the calibration and a table of 30 poses with what the effects need."""
    rng = np.random.default_rng(2)
    q = rng.uniform(-1, 1, (30, 6))
    q[:, 2] = rng.uniform(0.8, 1.8, 30)
    q[:, 4] = rng.uniform(0.4, 1.2, 30)
    table = pd.DataFrame(q, columns=JOINTS)
    table.insert(0, "pose", np.arange(30) + 100)
    for i in range(6):
        table[f"approach{i + 1}"] = rng.choice([-1, 1], 30)
    table["temperature"] = rng.uniform(15, 35, 30)
    table.to_csv(tmp_path / "targets.csv", index=False, float_format="%.17g")
    calibration.save(tmp_path / "calibration.json")
    return tmp_path


def frames(path):
    """Return the frames of a table ``(N, 6)`` [m, rad]."""
    return pd.read_csv(path)[FRAME].to_numpy()


def corrected(cell, name, *options):
    """Return the table that ``scalar correct`` writes."""
    status, said = run("correct", cell / "calibration.json", cell / name, "-o", cell / "joints.csv", *options)
    assert status == 0, said
    return pd.read_csv(cell / "joints.csv")


def predicted(cell, name, *options):
    """Return the table that ``scalar predict`` writes."""
    status, said = run("predict", cell / "calibration.json", cell / name, "-o", cell / "frames.csv", *options)
    assert status == 0, said
    return pd.read_csv(cell / "frames.csv")


def test_predict_takes_corrected_joints_to_the_nominal_frames(cell, calibration):
    """What `correct` writes is what `predict` reads; the frames are the nominal arm's, to 1e-6 m."""
    table = corrected(cell, "targets.csv")
    assert list(table["pose"]) == list(range(100, 130))
    predicted(cell, "joints.csv")
    q = pd.read_csv(cell / "targets.csv")[JOINTS].to_numpy()
    wanted = calibration.model.nominal.flange(q) @ T_SENSOR
    assert np.abs(frames(cell / "frames.csv")[:, :3] - wanted[:, :3, 3]).max() < 1e-6
    assert np.abs(table[JOINTS].to_numpy() - q).max() > 1e-4


@pytest.mark.parametrize("given", ["frames", "frames and joints"])
def test_predicted_frames_are_taken_back_to_joints(given, cell):
    """Frames in: with the joints beside them in their posture, without them in one within the limits."""
    joints = pd.read_csv(cell / "targets.csv")
    wanted = predicted(cell, "targets.csv")
    rest = joints.drop(columns=["pose", *([] if given != "frames" else JOINTS)])
    pd.concat([wanted, rest], axis=1).to_csv(cell / "wanted.csv", index=False, float_format="%.17g")
    table = corrected(cell, "wanted.csv")
    predicted(cell, "joints.csv")
    assert np.abs(frames(cell / "frames.csv")[:, :3] - wanted[FRAME[:3]].to_numpy()).max() < 1e-6
    if given != "frames":
        np.testing.assert_allclose(table[JOINTS], joints[JOINTS], atol=1e-5)


def test_degrees_and_millimetres_give_the_same(cell):
    """Tables in degrees and millimetres, by option or by their names, say the same as those in SI; what is written states its unit."""
    si = corrected(cell, "targets.csv")
    si_frames = predicted(cell, "joints.csv", "--std")
    joints = pd.read_csv(cell / "targets.csv")
    joints[JOINTS] = np.rad2deg(joints[JOINTS])
    joints.to_csv(cell / "by_option.csv", index=False, float_format="%.17g")
    by_name = joints.rename(columns={name: f"{name}_deg" for name in JOINTS})
    by_name.to_csv(cell / "by_name.csv", index=False, float_format="%.17g")
    degrees = corrected(cell, "by_option.csv", "--units", "deg,mm")
    assert "q1" not in degrees
    np.testing.assert_allclose(np.deg2rad(degrees[[f"{n}_deg" for n in JOINTS]]), si[JOINTS], atol=1e-9)
    in_units = predicted(
        cell, "joints.csv", "--std", "--units", "deg,mm"
    )  # names say deg: no doubt what is meant
    for name, unit, size in (("x", "mm", 1e3), ("rz", "deg", np.rad2deg(1))):
        np.testing.assert_allclose(in_units[f"{name}_{unit}"], si_frames[name] * size, atol=1e-6)
    np.testing.assert_allclose(in_units["y_std_mm"], si_frames["y_std"] * 1e3, rtol=1e-6)
    np.testing.assert_allclose(in_units["x_y_correlation"], si_frames["x_y_correlation"], atol=1e-6)
    named = corrected(cell, "by_name.csv")
    np.testing.assert_allclose(np.deg2rad(named[[f"{n}_deg" for n in JOINTS]]), si[JOINTS], atol=1e-9)
    assert {"x", "rz_deg"} <= set(predicted(cell, "joints.csv"))


def test_written_frames_are_read_again_in_their_units(cell):
    """What `predict` writes in millimetres and degrees, `correct` takes without being told."""
    joints = pd.read_csv(cell / "targets.csv")
    wanted = predicted(cell, "targets.csv")
    named = joints.rename(columns={name: f"{name}_rad" for name in JOINTS})
    # named with their unit, the joints stay in rad
    named.to_csv(cell / "named.csv", index=False, float_format="%.17g")
    in_units = predicted(cell, "named.csv", "--units", "mm,deg")
    pd.concat([in_units, joints.drop(columns="pose")], axis=1).to_csv(
        cell / "wanted.csv", index=False, float_format="%.17g"
    )
    corrected(cell, "wanted.csv")
    predicted(cell, "joints.csv")
    assert np.abs(frames(cell / "frames.csv")[:, :3] - wanted[FRAME[:3]].to_numpy()).max() < 1e-6


def test_what_a_tracker_does_not_know_of_a_target_is_left_out(cell):
    """A target is a point: the standard deviations of its place are written, those of an orientation that nothing showed are not."""
    table = predicted(cell, "targets.csv", "--std")
    assert {"x_std", "y_z_correlation"} <= set(table.columns)
    assert not {"rx_std", "x_rx_correlation", "rx_ry_correlation"} & set(table.columns)


@pytest.mark.parametrize("with_joints", [False, True])
def test_frames_out_of_reach_do_not_stop_the_program(cell, with_joints):
    """All others are corrected to 1e-6 m; those out of reach have no joint angles and corrected = 0; exit 2 with a line for each. With --leave-out
    they are left out, and the status is 0."""
    joints = pd.read_csv(cell / "targets.csv")
    wanted = predicted(cell, "targets.csv")
    wanted.loc[[3, 29], "x"] += 3.0
    rest = joints.drop(columns=["pose", *([] if with_joints else JOINTS)]).assign(speed=250.0)
    pd.concat([wanted, rest], axis=1).to_csv(cell / "wanted.csv", index=False, float_format="%.17g")
    arguments = ("correct", cell / "calibration.json", cell / "wanted.csv", "-o", cell / "out.csv")
    status, said = run(*arguments)
    faults = [line for line in said.splitlines() if line.startswith("scalar:")]
    assert status == 2 and "30 poses, 28 of them corrected" in said
    assert [re.search(r"wanted.csv: (pose \d+: not corrected)", line)[1] for line in faults] == [
        "pose 103: not corrected",
        "pose 129: not corrected",
    ]
    table = pd.read_csv(cell / "out.csv").set_index("pose")
    assert list(table.index) == list(range(100, 130)) and (table["speed"] == 250.0).all()
    assert list(table.index[table["corrected"] == 0]) == [103, 129]
    assert table.loc[[103, 129], [*JOINTS, "beyond_limits", "near_singular"]].isna().all(axis=None)
    status, said = run(*arguments, "--leave-out")
    assert status == 0 and said.count("left out: pose") == 2
    reached = pd.read_csv(cell / "out.csv").set_index("pose")
    pd.testing.assert_frame_equal(reached, table.drop([103, 129]), check_dtype=False)
    predicted(cell, "out.csv")
    off = frames(cell / "frames.csv")[:, :3] - wanted.drop([3, 29])[FRAME[:3]].to_numpy()
    assert np.abs(off).max() < 1e-6


def test_a_program_that_is_out_of_reach_throughout_is_refused(cell):
    """Nothing is written where no frame can be taken; ten lines name poses, and one counts the others."""
    wanted = predicted(cell, "targets.csv")
    wanted["x"] += 3.0
    rest = pd.read_csv(cell / "targets.csv").drop(columns=["pose", *JOINTS])
    pd.concat([wanted, rest], axis=1).to_csv(cell / "wanted.csv", index=False)
    for options in ([], ["--leave-out"]):
        status, said = run(
            "correct", cell / "calibration.json", cell / "wanted.csv", "-o", cell / "out.csv", *options
        )
        assert status == 2 and len(said.splitlines()) == 11 and "20 more poses" in said
        assert not (cell / "out.csv").exists()


def test_a_row_out_of_reach_is_no_move(tmp_path, calibration):
    """The direction from which a joint arrives is that from the last pose that is reached: a frame out of reach between two changes nothing."""
    made = replace(
        calibration,
        model=replace(calibration.model, effects=(JointBacklash(2, "moves", coefficients=np.array([2e-3])),)),
    )
    made.save(tmp_path / "calibration.json")
    q = np.array(
        [[0.1, 0.2, 1.2, 0.1, 0.8, 0.0], [0.0, 0.4, 1.1, 0.0, 0.9, 0.1], [0.2, 0.6, 1.0, 0.2, 0.7, 0.2]]
    )
    T = made.model.nominal.flange(q) @ T_SENSOR
    values = np.column_stack([T[:, :3, 3], log_so3(T[:, :3, :3])])
    found = []
    for far in ([], [1]):
        table = pd.DataFrame(values, columns=FRAME).assign(**dict(zip(JOINTS, q.T, strict=True)))
        between = table.iloc[far].assign(x=9.0, q2=2.0)
        table = pd.concat([table.iloc[:2], between, table.iloc[2:]]).reset_index(names="old")
        table.insert(0, "pose", np.arange(len(table)))
        table.drop(columns="old").to_csv(tmp_path / "wanted.csv", index=False, float_format="%.17g")
        arguments = (
            "correct",
            tmp_path / "calibration.json",
            tmp_path / "wanted.csv",
            "-o",
            tmp_path / "out.csv",
        )
        status, said = run(*arguments, "--leave-out")
        assert status == 0, said
        found.append(pd.read_csv(tmp_path / "out.csv")[JOINTS].to_numpy())
    np.testing.assert_allclose(found[0], found[1], atol=1e-9)


def test_limits_and_singular_poses_are_said(cell):
    """A joint beyond its limits, and a stretched wrist, are named by their pose, and marked in the table."""
    joints = pd.read_csv(cell / "targets.csv")
    limits = Robot.from_mapping(load_yaml(ROBOT_CONFIGS / "vs060.yaml")).limits
    joints.loc[0, "q1"] = limits[0, 1] + 0.05
    joints.loc[1, "q5"] = 0.0
    joints.to_csv(cell / "targets.csv", index=False, float_format="%.17g")
    status, said = run(
        "correct", cell / "calibration.json", cell / "targets.csv", "-o", cell / "joints.csv", "--leave-out"
    )
    assert status == 0
    assert "pose 100: joint 1 at" in said and "beyond its limits" in said
    assert pd.read_csv(cell / "joints.csv").set_index("pose").loc[100, "beyond_limits"] >= 1
    found = pd.read_csv(cell / "joints.csv").set_index("pose")
    assert 101 in found.index[found["near_singular"] == 1]
    (line,) = [line for line in said.splitlines() if line.startswith("  pose 101:")]
    stated = float(re.search(r"smallest singular value (\S+):", line)[1])
    assert stated == pytest.approx(found.loc[101, "smallest_singular_value"], rel=0.1) and stated < 0.02
    assert re.search(r"to shift the sensor by 1 mm, joint \d moves by (up to|more than) \S+ deg\)$", line)
    assert (found["smallest_singular_value"] < 0.02).equals(found["near_singular"] == 1)


def test_a_home_pose_at_a_singularity_does_not_stop_the_program(cell, calibration):
    """The rows that can be corrected are, to 1e-6 m; the home pose stays as it is and is marked; the exit status is 2, and one line says which row,
    how far it errs as it stands, and what to do. With --leave-out it is left out, and the status is 0."""
    joints = pd.read_csv(cell / "targets.csv")
    joints.loc[4, "q5"] = 0.0
    joints.to_csv(cell / "targets.csv", index=False, float_format="%.17g")
    arguments = ("correct", cell / "calibration.json", cell / "targets.csv", "-o", cell / "joints.csv")
    status, said = run(*arguments)
    assert status == 2
    (line,) = [line for line in said.splitlines() if line.startswith("scalar:")]
    assert "targets.csv" in line and "pose 104: not corrected" in line and "move the pose" in line
    assert "30 poses, 29 of them corrected" in said
    table = pd.read_csv(cell / "joints.csv").set_index("pose")
    given = joints.set_index("pose")
    assert list(table.index[table["corrected"] == 0]) == [104]
    np.testing.assert_allclose(table.loc[104, JOINTS], given.loc[104, JOINTS], atol=1e-14)
    predicted(cell, "joints.csv")
    wanted = calibration.model.nominal.flange(given[JOINTS].to_numpy()) @ T_SENSOR
    off = np.linalg.norm(frames(cell / "frames.csv")[:, :3] - wanted[:, :3, 3], axis=1)
    assert np.delete(off, 4).max() < 1e-6 < off[4]
    stated = float(re.search(r"errs by (\S+) mm", line)[1])
    assert stated == pytest.approx(off[4] * 1e3, rel=0.1)
    status, said = run(*arguments, "--leave-out")
    assert status == 0 and "left out: pose 104" in said
    table = pd.read_csv(cell / "joints.csv")
    assert 104 not in set(table["pose"]) and (table["corrected"] == 1).all() and len(table) == 29


def test_what_is_said_of_the_wanted_frame_is_not_said_of_the_joints(cell):
    """Frames with their uncertainties, as `predict --std` writes them, and a speed: the speed is carried along, the frame is not."""
    joints = pd.read_csv(cell / "targets.csv")
    for units in ([], ["--units", "deg,mm"]):
        if units:
            named = joints.rename(columns={name: f"{name}_rad" for name in JOINTS})
            named.to_csv(cell / "named.csv", index=False, float_format="%.17g")
        wanted = predicted(cell, "named.csv" if units else "targets.csv", "--std", *units)
        assert any("std" in name for name in wanted) and any("correlation" in name for name in wanted)
        rest = joints.drop(columns="pose").assign(speed=250.0)
        pd.concat([wanted, rest], axis=1).to_csv(cell / "wanted.csv", index=False, float_format="%.17g")
        table = corrected(cell, "wanted.csv")
        own = {"corrected", "beyond_limits", "near_singular", "smallest_singular_value"}
        assert set(table.columns) == {*joints.columns, "speed", *own}
        assert (table["speed"] == 250.0).all()


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
def test_targets_that_say_too_little_are_refused(change, options, words, cell):
    """Exit 2, what is missing by name, no output."""
    change(pd.read_csv(cell / "targets.csv")).to_csv(cell / "bad.csv", index=False)
    status, said = run(
        "correct", cell / "calibration.json", cell / "bad.csv", "-o", cell / "out.csv", *options
    )
    assert status == 2, said
    assert words in said
    assert "Traceback" not in said
    assert not (cell / "out.csv").exists()
