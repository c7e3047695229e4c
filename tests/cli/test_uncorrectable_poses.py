"""``scalar correct`` with poses out of reach, beyond the limits or singular."""

import json
import re
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from scalar.data.io.plain_yaml import load_yaml
from scalar.effects.joint_backlash import JointBacklash
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import log_so3
from tests.calibrated_arms import T_SENSOR
from tests.cli.correcting import FRAME, JOINTS, frames, predicted, run
from tests.robot_configs import ROBOT_CONFIGS


@pytest.mark.parametrize("with_joints", [False, True])
def test_frames_out_of_reach_do_not_stop_the_program(program, with_joints):
    """Frames out of reach get no joint angles and corrected = 0, and all others are corrected to 1e-6 m.

    The exit status is 2, with a line for each; with --leave-out they are left out and the status is 0.
    """
    joints = pd.read_csv(program / "targets.csv")
    wanted = predicted(program, "targets.csv")
    wanted.loc[[3, 29], "x"] += 3.0
    rest = joints.drop(columns=["pose", *([] if with_joints else JOINTS)]).assign(speed=250.0)
    pd.concat([wanted, rest], axis=1).to_csv(program / "wanted.csv", index=False, float_format="%.17g")
    arguments = ("correct", program / "calibration.json", program / "wanted.csv", "-o", program / "out.csv")
    status, said = run(*arguments)
    faults = [line for line in said.splitlines() if line.startswith("scalar:")]
    assert status == 2 and "30 poses, 28 of them corrected" in said
    assert [re.search(r"wanted.csv: (pose \d+: not corrected)", line)[1] for line in faults] == [
        "pose 103: not corrected",
        "pose 129: not corrected",
    ]
    table = pd.read_csv(program / "out.csv").set_index("pose")
    assert list(table.index) == list(range(100, 130)) and (table["speed"] == 250.0).all()
    assert list(table.index[table["corrected"] == 0]) == [103, 129]
    assert table.loc[[103, 129], [*JOINTS, "beyond_limits", "near_singular"]].isna().all(axis=None)
    status, said = run(*arguments, "--leave-out")
    assert status == 0 and said.count("left out: pose") == 2
    reached = pd.read_csv(program / "out.csv").set_index("pose")
    pd.testing.assert_frame_equal(reached, table.drop([103, 129]), check_dtype=False)
    predicted(program, "out.csv")
    off = frames(program / "frames.csv")[:, :3] - wanted.drop([3, 29])[FRAME[:3]].to_numpy()
    assert np.abs(off).max() < 1e-6


def test_a_tool_of_absurd_length_is_refused_without_a_warning(program):
    """A calibration whose sensor is 1e98 m off the flange reaches no frame; that is said as for any other arm."""
    path = program / "calibration.json"
    content = json.loads(path.read_text())
    content["parameters"]["sensor_y"]["value"] = -1e98
    path.write_text(json.dumps(content))
    status, said = run("correct", path, program / "targets.csv", "-o", program / "out.csv")
    assert status == 2 and "not corrected" in said, said


def test_a_program_that_is_out_of_reach_throughout_is_refused(program):
    """If no frame can be reached, nothing is written; ten lines name poses, and one counts the others."""
    wanted = predicted(program, "targets.csv")
    wanted["x"] += 3.0
    rest = pd.read_csv(program / "targets.csv").drop(columns=["pose", *JOINTS])
    pd.concat([wanted, rest], axis=1).to_csv(program / "wanted.csv", index=False)
    for options in ([], ["--leave-out"]):
        status, said = run(
            "correct",
            program / "calibration.json",
            program / "wanted.csv",
            "-o",
            program / "out.csv",
            *options,
        )
        assert status == 2 and len(said.splitlines()) == 11 and "20 more poses" in said
        assert not (program / "out.csv").exists()


def test_the_approach_is_from_the_last_pose_in_reach(tmp_path, arm_calibration):
    """A joint's direction of approach is taken from the last pose that is reached, so a frame out of reach between two others changes nothing."""
    made = replace(
        arm_calibration,
        model=replace(
            arm_calibration.model, effects=(JointBacklash(2, "moves", coefficients=np.array([2e-3])),)
        ),
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


def test_limits_and_singular_poses_are_said(program):
    """A joint beyond its limits, and a stretched wrist, are named by their pose, and marked in the table."""
    joints = pd.read_csv(program / "targets.csv")
    limits = Robot.from_mapping(load_yaml(ROBOT_CONFIGS / "vs060.yaml")).limits
    joints.loc[0, "q1"] = limits[0, 1] + 0.05
    joints.loc[1, "q5"] = 0.0
    joints.to_csv(program / "targets.csv", index=False, float_format="%.17g")
    status, said = run(
        "correct",
        program / "calibration.json",
        program / "targets.csv",
        "-o",
        program / "joints.csv",
        "--leave-out",
    )
    assert status == 0
    assert "pose 100: joint 1 at" in said and "beyond its limits" in said
    assert pd.read_csv(program / "joints.csv").set_index("pose").loc[100, "beyond_limits"] >= 1
    found = pd.read_csv(program / "joints.csv").set_index("pose")
    assert 101 in found.index[found["near_singular"] == 1]
    (line,) = [line for line in said.splitlines() if line.startswith("  pose 101:")]
    stated = float(re.search(r"smallest singular value (\S+):", line)[1])
    assert stated == pytest.approx(found.loc[101, "smallest_singular_value"], rel=0.1) and stated < 0.02
    assert re.search(r"to shift the sensor by 1 mm, joint \d moves by (up to|more than) \S+ deg\)$", line)
    assert (found["smallest_singular_value"] < 0.02).equals(found["near_singular"] == 1)


def test_a_home_pose_at_a_singularity_does_not_stop_the_program(program, arm_calibration):
    """The other rows are corrected to 1e-6 m, and the home pose comes as near as small changes bring it, and is marked.

    The exit status is 2, and one line states the row, its error with and without these changes, and what to do; with --leave-out the row is left out,
    and the status is 0.
    """
    joints = pd.read_csv(program / "targets.csv")
    joints.loc[4, "q5"] = 0.0
    joints.to_csv(program / "targets.csv", index=False, float_format="%.17g")
    arguments = (
        "correct",
        program / "calibration.json",
        program / "targets.csv",
        "-o",
        program / "joints.csv",
    )
    status, said = run(*arguments)
    assert status == 2
    (line,) = [line for line in said.splitlines() if line.startswith("scalar:")]
    assert "targets.csv" in line and "pose 104: not corrected" in line and "move the pose" in line
    assert "30 poses, 29 of them corrected" in said
    table = pd.read_csv(program / "joints.csv").set_index("pose")
    given = joints.set_index("pose")
    assert list(table.index[table["corrected"] == 0]) == [104]
    wanted = arm_calibration.model.nominal.flange(given[JOINTS].to_numpy()) @ T_SENSOR
    predicted(program, "joints.csv")
    off = np.linalg.norm(frames(program / "frames.csv")[:, :3] - wanted[:, :3, 3], axis=1)
    predicted(program, "targets.csv")
    uncorrected = np.linalg.norm(frames(program / "frames.csv")[4, :3] - wanted[4, :3, 3])
    assert np.delete(off, 4).max() < 1e-6 and off[4] < uncorrected / 10
    assert np.abs(table.loc[104, JOINTS] - given.loc[104, JOINTS]).max() < 0.1
    stated = float(re.search(r"uncorrected by (\S+) mm", line)[1])
    assert stated == pytest.approx(uncorrected * 1e3, rel=0.1)
    status, said = run(*arguments, "--leave-out")
    assert status == 0 and "left out: pose 104" in said
    table = pd.read_csv(program / "joints.csv")
    assert 104 not in set(table["pose"]) and (table["corrected"] == 1).all() and len(table) == 29


def straight_elbow(robot, joints):
    """Return the angle of joint 3 [rad] at which the wrist is farthest from joint 2, and the direction from joint 2 to the wrist."""
    angles = np.linspace(*robot.limits[2], 4001)
    q = np.tile(np.asarray(joints, dtype=float), (len(angles), 1))
    q[:, 2] = angles
    chain = robot.frames(q)
    arms = chain[:, 5, :3, 3] - chain[:, 2, :3, 3]
    reach = np.linalg.norm(arms, axis=1)
    best = int(np.argmax(reach))
    assert 0 < best < len(angles) - 1
    return angles[best], arms[best] / reach[best]


@pytest.mark.parametrize("with_joints", [False, True])
def test_a_singular_frame_gets_the_nearest_joint_angles(program, arm_calibration, with_joints):
    """A frame a millimetre beyond the straight elbow is written with the joint angles that come nearest: within the limits, its position within
    0.05 mm, `corrected` 0, and the errors that the table states are those of `scalar predict`. A frame three metres away has no joint angles."""
    joints = pd.read_csv(program / "targets.csv")
    joints.loc[4, "q3"], outward = straight_elbow(arm_calibration.model.robot, joints.loc[4, JOINTS])
    T = arm_calibration.model.robot.flange(joints[JOINTS].to_numpy()) @ T_SENSOR
    T[4, :3, 3] += 1e-3 * outward
    wanted = pd.DataFrame(np.column_stack([T[:, :3, 3], log_so3(T[:, :3, :3])]), columns=FRAME)
    wanted.loc[7, "x"] += 3.0
    rest = joints.drop(columns=[] if with_joints else JOINTS)
    pd.concat([rest, wanted], axis=1).to_csv(program / "wanted.csv", index=False, float_format="%.17g")
    status, said = run(
        "correct", program / "calibration.json", program / "wanted.csv", "-o", program / "out.csv"
    )
    faults = [line for line in said.splitlines() if line.startswith("scalar:")]
    assert status == 2 and "30 poses, 28 of them corrected" in said and len(faults) == 2
    assert "pose 104: not corrected, and written as near as it comes" in faults[0] and "errs by" in faults[0]
    assert "pose 107: not corrected, and written without joint angles" in faults[1]
    table = pd.read_csv(program / "out.csv").set_index("pose")
    assert list(table.index[table["corrected"] == 0]) == [104, 107]
    assert table.loc[107, [*JOINTS, "position_error", "orientation_error"]].isna().all()
    limits = arm_calibration.model.robot.limits
    assert np.all((table.loc[104, JOINTS] >= limits[:, 0]) & (table.loc[104, JOINTS] <= limits[:, 1]))
    there = table.drop(index=107)
    there.reset_index().to_csv(program / "there.csv", index=False, float_format="%.17g")
    predicted(program, "there.csv")
    off = frames(program / "frames.csv")[:, :3] - np.delete(T[:, :3, 3], 7, axis=0)
    np.testing.assert_allclose(np.linalg.norm(off, axis=1), there["position_error"], atol=1e-9)
    assert there.loc[104, "position_error"] < 5e-5 and 1e-5 < there.loc[104, "orientation_error"] < 0.05
    assert there.drop(index=104)["position_error"].max() < 1e-6
