"""What ``scalar predict`` and ``scalar evaluate`` refuse, and outputs that cannot be written."""

import json
import shutil
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tests.cli.running import INPUT_AT_FAULT, JOINTS, refused, run
from tests.random_scene import make_scene


@pytest.mark.parametrize(("spoil", "words"), [
    (lambda t: t.drop(columns="q3"), ["joints.csv", "q3", "missing"]),
    (lambda t: t.drop(columns=["q3", "pose"]), ["q3", "pose"]),
    (lambda t: t.assign(q7=0.0), ["joints.csv", "q7"]),
    (lambda t: t.assign(q2=[0.1, np.nan, 0.1, 0.1, 0.1]), ["joints.csv, row 3, column q2"]),
    (lambda t: t.assign(q2=["0.1", "0.1", "north", "0.1", "0.1"]), ["joints.csv, row 4, column q2", "north"]),
    (lambda t: t.assign(q2=np.inf), ["joints.csv, row 2, column q2"]),
    (lambda t: t.assign(**{name: t[name] * 100 for name in JOINTS}), ["joints.csv", "degrees"]),
    (lambda t: t.assign(pose=1), ["joints.csv", "pose"]),
])  # fmt: skip
def test_predict_refuses_joints_it_cannot_read(spoil, words, sound, tmp_path):
    """Missing columns, too many joints, NaN, text, infinity, degrees and repeated ids are named, and no file is written."""
    spoil(pd.read_csv(sound / "joints.csv")).to_csv(tmp_path / "joints.csv", index=False, na_rep="nan")
    result = run(
        "predict", sound / "out/calibration.json", tmp_path / "joints.csv", "-o", tmp_path / "frames.csv"
    )
    refused(result, INPUT_AT_FAULT, *words, output=tmp_path / "frames.csv")


def test_predict_leaves_comments_aside(sound, tmp_path):
    """A column of text that no effect needs, such as those that `correct` copies, changes nothing."""
    calibration, table = sound / "out/calibration.json", pd.read_csv(sound / "joints.csv")
    table.assign(comment="weld").to_csv(tmp_path / "joints.csv", index=False)
    assert run("predict", calibration, tmp_path / "joints.csv", "-o", tmp_path / "a.csv").exit_code == 0
    assert run("predict", calibration, sound / "joints.csv", "-o", tmp_path / "b.csv").exit_code == 0
    assert (tmp_path / "a.csv").read_bytes() == (tmp_path / "b.csv").read_bytes()


@pytest.mark.parametrize("lacks", [True, False])
def test_standard_errors_of_an_incomplete_model_are_said_to_be_too_small(lacks, sound, tmp_path):
    """They hold chance errors alone: one line says so where the residual clearly exceeds the noise."""
    content = json.loads((sound / "out/calibration.json").read_text(encoding="utf-8"))
    content["summary"] |= {"misfit": 5.0 if lacks else 1.0, "misfit_p_value": 0.0 if lacks else 0.5}
    (tmp_path / "calibration.json").write_text(json.dumps(content), encoding="utf-8")
    given = (tmp_path / "calibration.json", sound / "joints.csv", "-o", tmp_path / "a.csv", "--std")
    result = run("predict", *given)
    assert result.exit_code == 0, result.output
    assert ("the model lacks something" in result.output) == lacks


@pytest.mark.parametrize("kind", ["tracker", "probe", "line-laser"])
def test_an_orientation_that_nothing_shows_is_said_once(kind, sound, tmp_path):
    """Of a tracker's point and of a probe, orientations are those of the declared mount: one line says so, with --std and without. A scanner
    shows its own, with standard deviations."""
    calibration = sound / "out/calibration.json"
    if kind != "line-laser":
        folder = make_scene(kind=kind, seed=21, poses_per_plane=30).write(tmp_path / "dataset")
        assert run("calibrate", folder, "-o", tmp_path / "out").exit_code == 0
        calibration = tmp_path / "out/calibration.json"
    for options in ((), ("--std",)):
        result = run("predict", calibration, sound / "joints.csv", "-o", tmp_path / "frames.csv", *options)
        assert result.exit_code == 0, result.output
        said = result.output.count("orientations are those of the declared mount")
        assert said == (0 if kind == "line-laser" else 1)
    columns = set(pd.read_csv(tmp_path / "frames.csv").columns)
    assert {"rx", "ry", "rz", "x_std"} <= columns and ("rx_std" in columns) == (kind == "line-laser")


def test_predict_refuses_what_is_no_table_or_no_calibration(sound, tmp_path):
    """A missing file, a folder, an empty file and a file that is no calibration are refused."""
    (tmp_path / "empty.csv").touch()
    calibration, joints, out = sound / "out/calibration.json", sound / "joints.csv", tmp_path / "f.csv"
    for bad in (tmp_path / "missing.csv", tmp_path, tmp_path / "empty.csv"):
        refused(run("predict", calibration, bad, "-o", out), INPUT_AT_FAULT, output=out)
    for bad in (tmp_path / "missing.json", tmp_path, sound / "joints.csv", sound / "truth/truth.json"):
        refused(run("predict", bad, joints, "-o", out), INPUT_AT_FAULT, output=out, lines=1)


def test_a_column_that_an_effect_needs_is_named(sound, tmp_path):
    """A calibration with drift over time predicts only if the time is given: otherwise the exit status is 2, and the message names the column."""
    dataset = tmp_path / "dataset"
    shutil.copytree(sound / "dataset", dataset)
    poses = pd.read_csv(dataset / "poses.csv")
    poses.assign(time=10.0 * np.arange(len(poses))).to_csv(dataset / "poses.csv", index=False)
    result = run("calibrate", dataset, "-o", tmp_path / "out", "--effects", "thermal_drift")
    assert result.exit_code == 0, result.output
    calibration = tmp_path / "out/calibration.json"
    result = run("predict", calibration, sound / "joints.csv", "-o", tmp_path / "f.csv")
    refused(result, INPUT_AT_FAULT, "joints.csv, column time", "[s]", "missing", output=tmp_path / "f.csv")
    pd.read_csv(sound / "joints.csv").assign(time=0.0).to_csv(tmp_path / "joints.csv", index=False)
    assert run("predict", calibration, tmp_path / "joints.csv", "-o", tmp_path / "f.csv").exit_code == 0


def test_frames_of_an_arm_that_drifted_are_said_to_be_those_of_the_end(sound, tmp_path):
    """Without a column order, how far the drift moved the arm is said; with one, and for an arm that does not drift, nothing is."""
    dataset = tmp_path / "dataset"
    shutil.copytree(sound / "dataset", dataset)
    result = run("calibrate", dataset, "-o", tmp_path / "out", "--effects", "thermal_drift:order")
    assert result.exit_code == 0, result.output
    path = tmp_path / "out/calibration.json"
    content = json.loads(path.read_text())
    drift = content["effects"][0]
    (growth,) = drift["coefficients"].values()
    growth["value"] = 1e-5  # a thousandth of all lengths in a hundred poses
    path.write_text(json.dumps(content))
    joints, out = sound / "joints.csv", ("-o", tmp_path / "f.csv", "--force")
    said = "those after the last measured pose; at the first one they were up to"
    assert said in run("predict", path, joints, *out).output
    assert said not in run("predict", sound / "out/calibration.json", joints, *out).output
    table = pd.read_csv(joints)
    table.assign(order=np.arange(len(table))).to_csv(tmp_path / "ordered.csv", index=False)
    ordered = run("predict", path, tmp_path / "ordered.csv", *out)
    assert ordered.exit_code == 0 and said not in ordered.output


@pytest.mark.parametrize(("command", "output"), [("predict", "f.csv"), ("export", "table.md")])
def test_a_doubt_about_the_set_up_goes_with_the_calibration(command, output, sound, tmp_path):
    """Whoever predicts with a calibration, or exports it, may not have seen what `scalar calibrate` said of the set-up."""
    content = json.loads((sound / "out/calibration.json").read_text())
    content["summary"]["setup"] = [
        {"what": "noise", "where": "sensor.noise", "sentence": "the noise is stated too large"}
    ]
    (tmp_path / "calibration.json").write_text(json.dumps(content))
    rows = [sound / "joints.csv"] if command == "predict" else []
    result = run(command, tmp_path / "calibration.json", *rows, "-o", tmp_path / output)
    assert result.exit_code == 0 and "doubt about its set-up: the noise is stated too large" in result.output


def test_poses_beyond_the_limits_are_predicted_and_named(sound, tmp_path):
    """A joint that the arm cannot turn so far is named with its limits; poses within them are not mentioned."""
    joints = pd.read_csv(sound / "joints.csv")
    joints.loc[2, "q3"] = 3.1
    joints.to_csv(tmp_path / "joints.csv", index=False)
    arguments = ("predict", sound / "out/calibration.json", tmp_path / "joints.csv", "-o", tmp_path / "f.csv")
    result = run(*arguments)
    assert result.exit_code == 0 and len(pd.read_csv(tmp_path / "f.csv")) == len(joints)
    named = [line for line in result.output.splitlines() if "beyond its limits" in line]
    assert (
        len(named) == 1
        and f"pose {joints['pose'][2]}: joint 3 at 177.617 deg is beyond its limits" in named[0]
    )


def test_a_joint_that_is_more_than_a_turn_beyond_its_limits_is_refused_by_its_pose(sound, tmp_path):
    """All cells are numbers and no effect needs the column, which had been said. The unit is that in which people write an angle."""
    joints = pd.read_csv(sound / "joints.csv")
    joints.loc[3, "q6"] = 20.0
    joints.to_csv(tmp_path / "joints.csv", index=False)
    result = run("predict", sound / "out/calibration.json", tmp_path / "joints.csv", "-o", tmp_path / "f.csv")
    refused(result, INPUT_AT_FAULT, "joints.csv, column q6", "limits", output=tmp_path / "f.csv", lines=1)
    joints.loc[3, "q6"] = 13.0  # not so far that the table itself is refused
    joints.to_csv(tmp_path / "joints.csv", index=False)
    result = run("predict", sound / "out/calibration.json", tmp_path / "joints.csv", "-o", tmp_path / "f.csv")
    assert f"pose {joints['pose'][3]}: 744.845 deg is far beyond the limits of joint 6" in result.output


def test_every_joint_beyond_its_limits_is_named(sound, tmp_path):
    """A pose with three joints beyond their limits is one line that has all three, and not the others."""
    joints = pd.read_csv(sound / "joints.csv")
    joints.loc[1, ["q1", "q3", "q5"]] = 3.1, -3.1, 3.2
    joints.to_csv(tmp_path / "joints.csv", index=False)
    result = run("predict", sound / "out/calibration.json", tmp_path / "joints.csv", "-o", tmp_path / "f.csv")
    assert result.exit_code == 0, result.output
    (line,) = [line for line in result.output.splitlines() if "beyond its limits" in line]
    assert [f"joint {i} at" in line for i in range(1, 7)] == [True, False, True, False, True, False]


def test_advice_on_limits_leads_to_a_calibration_that_has_them(sound, tmp_path):
    """A table of poses has no dataset.yaml of its own: limits that are too narrow are those of the dataset that was calibrated."""
    joints = pd.read_csv(sound / "joints.csv").assign(q2=40.0)
    joints.to_csv(tmp_path / "joints.csv", index=False)
    result = run("predict", sound / "out/calibration.json", tmp_path / "joints.csv", "-o", tmp_path / "f.csv")
    refused(result, INPUT_AT_FAULT, "column q2", "dataset.yaml of the dataset and calibrate again", lines=1)


@pytest.mark.parametrize("command", ["predict", "correct"])
def test_radians_that_are_read_as_degrees_are_suspected(command, sound, tmp_path):
    """Joint angles in radians under `--units deg` are all tiny: a line says so. The same angles in degrees, or a few poses near zero, are not."""
    calibration, joints = sound / "out/calibration.json", pd.read_csv(sound / "joints.csv")
    tables = {
        "rad": (joints, True),
        "deg": (joints.assign(**{name: np.rad2deg(joints[name]) for name in JOINTS}), False),
        "home": (joints.assign(**{name: 0.5 for name in JOINTS}), False),
    }
    for name, (table, suspect) in tables.items():
        table.to_csv(tmp_path / f"{name}.csv", index=False)
        out = tmp_path / f"{name}_out.csv"
        result = run(command, calibration, tmp_path / f"{name}.csv", "-o", out, "--units", "deg,mm")
        assert out.exists() and ("if they are radians" in result.output) == suspect


def test_what_stands_beside_a_calibration_leads_to_it(sound, tmp_path):
    """The folder of a calibration, and a diagnosis, are refused with the name of the file that is wanted."""
    joints, out = sound / "joints.csv", tmp_path / "f.csv"
    refused(
        run("predict", sound / "out", joints, "-o", out), INPUT_AT_FAULT, "give", "calibration.json", lines=1
    )
    (tmp_path / "diagnosis.json").write_text('{"format": "scalar-diagnosis/2"}', encoding="utf-8")
    result = run("predict", tmp_path / "diagnosis.json", joints, "-o", out)
    refused(result, INPUT_AT_FAULT, "a diagnosis, not a calibration", "after.json", lines=1)


def test_an_output_that_cannot_be_written_is_said(sound, tmp_path):
    """With a folder in the place of the file, or a file in the place of the folder, the exit status is 2, with one line, and nothing is changed."""
    (tmp_path / "taken").write_text("mine", encoding="utf-8")
    calibration, joints = sound / "out/calibration.json", sound / "joints.csv"
    refused(run("predict", calibration, joints, "-o", tmp_path), INPUT_AT_FAULT, "cannot be written", lines=1)
    below = tmp_path / "taken" / "frames.csv"
    refused(run("predict", calibration, joints, "-o", below), INPUT_AT_FAULT, "cannot be written", lines=1)
    for command in (["calibrate", sound / "dataset"], ["evaluate", calibration, sound / "truth"]):
        refused(run(*command, "-o", tmp_path / "taken"), INPUT_AT_FAULT, "cannot be written", lines=1)
    assert (tmp_path / "taken").read_text(encoding="utf-8") == "mine"
    assert [path.name for path in tmp_path.iterdir()] == ["taken"]


def test_evaluate_refuses_a_truth_that_is_none(sound, tmp_path):
    """A missing folder, missing poses, damaged JSON and too few joints are named, and there is no output."""
    calibration, out = sound / "out/calibration.json", tmp_path / "e"
    refused(
        run("evaluate", calibration, tmp_path / "no", "-o", out),
        INPUT_AT_FAULT,
        "truth_poses.csv",
        output=out,
    )
    truth = Path(shutil.copytree(sound / "truth", tmp_path / "truth"))
    (truth / "truth.json").write_text("{", encoding="utf-8")
    refused(run("evaluate", calibration, truth, "-o", out), INPUT_AT_FAULT, "truth.json", output=out)
    (truth / "truth.json").write_text('{"parameters": 3, "planes": "x"}', encoding="utf-8")
    refused(run("evaluate", calibration, truth, "-o", out), INPUT_AT_FAULT, "truth.json", output=out)
    (truth / "truth.json").unlink()
    assert run("evaluate", calibration, truth, "-o", tmp_path / "fine").exit_code == 0
    pd.read_csv(truth / "truth_poses.csv").drop(columns=["q6", "rz"]).to_csv(
        truth / "truth_poses.csv", index=False
    )
    refused(run("evaluate", calibration, truth, "-o", out), INPUT_AT_FAULT, "q6", "rz", output=out)


@pytest.mark.parametrize(
    "damage",
    [
        {"parameters": {"a": 3}},
        {"parameters": {"a": [[0.1], [0.2]]}},
        {"parameters": {"r": 0.1}},
        {"parameters": {"d": ["0.1"]}},
        {"planes": {"normals": [[0, 0, 1], [1, 0]], "distances": [0, 0]}},
        {"planes": {"normals": [[0, 0, 0]], "distances": [0]}},
        {"planes": {"normals": [[0, 0, 1]], "distances": [0], "names": "floor"}},
        {"planes": {"normals": [[0, 0, 1]], "distances": [0, 1]}},
    ],
)
def test_evaluate_refuses_a_truth_with_other_shapes(sound, tmp_path, damage):
    """A number in the place of a list, text in the place of a number and planes that do not belong together were once a fault of the program."""
    truth = Path(shutil.copytree(sound / "truth", tmp_path / "truth"))
    content = json.loads((truth / "truth.json").read_text(encoding="utf-8"))
    (truth / "truth.json").write_text(json.dumps(content | damage), encoding="utf-8")
    result = run("evaluate", sound / "out/calibration.json", truth, "-o", tmp_path / "e")
    refused(result, INPUT_AT_FAULT, "not a truth", output=tmp_path / "e", lines=1)


def test_a_truth_whose_planes_are_null_has_none(sound, tmp_path):
    """``planes: null`` is the same as no planes."""
    truth = Path(shutil.copytree(sound / "truth", tmp_path / "truth"))
    content = json.loads((truth / "truth.json").read_text(encoding="utf-8"))
    (truth / "truth.json").write_text(json.dumps(content | {"planes": None}), encoding="utf-8")
    result = run("evaluate", sound / "out/calibration.json", truth, "-o", tmp_path / "e")
    assert result.exit_code == 0, result.output


def test_evaluate_refuses_the_truth_of_another_robot(sound, tmp_path):
    """A truth with as many joints but another table is refused with the parameter that differs most."""
    calibration = sound / "out/calibration.json"
    make_scene("ur10e", "tracker", seed=3).write_truth(tmp_path / "truth", np.random.default_rng(0))
    result = run("evaluate", calibration, tmp_path / "truth", "-o", tmp_path / "e")
    refused(result, INPUT_AT_FAULT, "truth.json: the truth of another robot", output=tmp_path / "e", lines=1)


def test_a_robot_that_is_described_otherwise_is_evaluated(sound, tmp_path):
    """Where the predicted places are right, another table of joints or another name is no reason to refuse; the name is said."""
    truth = Path(shutil.copytree(sound / "truth", tmp_path / "truth"))
    content = json.loads((truth / "truth.json").read_text(encoding="utf-8"))
    content["robot"] = "arm of hall 3"
    content["parameters"]["alpha"] = [angle + np.pi for angle in content["parameters"]["alpha"]]
    (truth / "truth.json").write_text(json.dumps(content), encoding="utf-8")
    result = run("evaluate", sound / "out/calibration.json", truth, "-o", tmp_path / "e")
    assert result.exit_code == 0, result.output
    assert "arm of hall 3" in result.output
