"""From a dataset to frames and errors by the commands, on a workcell of the tests' own."""

import json
import re

import numpy as np
import pandas as pd
import pytest

from tests import kinematics
from tests.cli.running import run
from tests.kinematics import joint_names
from tests.random_scene import make_scene


def test_validate_says_what_a_dataset_holds(sound):
    """`validate` writes robot, sensor, poses by plane and points to stdout, and ends with exit status 0."""
    result = run("validate", sound / "dataset")
    assert result.exit_code == 0
    for words in ("vs060", "line-laser", "90 poses", "floor 30", "1800 points"):
        assert words in result.stdout


def test_calibrate_prints_every_parameter_with_its_std_and_what_is_not_observed(sound):
    """The summary has the residual, the joint parameters with their std or the reason why they are fixed, sensor, planes and gauge."""
    text = (sound / "summary.txt").read_text(encoding="utf-8")
    parameters = json.loads((sound / "out" / "calibration.json").read_text())["parameters"]
    for name in parameters:
        if name.startswith(("a_", "alpha_", "d_", "theta_")):
            assert re.search(rf"\b{name}\b", text), name
    for words in (
        "90 poses",
        "residual",
        "std",
        "sensor on flange",
        "plane floor",
        "d_6",
        "the data do not show where the base is",
    ):
        assert words in text
    assert [path.name for path in (sound / "out").iterdir()] == ["calibration.json"]


def test_predict_writes_the_true_frames_to_within_the_noise(sound, scene, tmp_path):
    """Columns and ids are those of the documented format, frames are within 0.2 mm of the truth, and the bytes are the same each time."""
    for name in ("one.csv", "two.csv"):
        result = run(
            "predict", sound / "out/calibration.json", sound / "joints.csv", "-o", tmp_path / "new" / name
        )
        assert result.exit_code == 0, result.output
    frames = pd.read_csv(tmp_path / "new/one.csv")
    assert list(frames.columns) == ["pose", "x", "y", "z", "rx", "ry", "rz"]
    joints = pd.read_csv(sound / "joints.csv")
    assert frames["pose"].tolist() == joints["pose"].tolist()
    T = scene.truth.sensor(joints[joint_names(6)].to_numpy())
    assert np.abs(frames[["x", "y", "z"]].to_numpy() - T[:, :3, 3]).max() < 2e-4
    for i, turn in enumerate(frames[["rx", "ry", "rz"]].to_numpy()):
        R = kinematics.rotate_about(turn, float(np.linalg.norm(turn)))
        assert np.linalg.norm(kinematics.rotation_vector(R @ T[i, :3, :3].T)) < 1e-3
    assert (tmp_path / "new/one.csv").read_bytes() == (tmp_path / "new/two.csv").read_bytes()


def test_evaluate_compares_with_the_truth(sound, tmp_path):
    """Raw and aligned errors, mean and maximum, stand in the file and on the terminal."""
    result = run("evaluate", sound / "out/calibration.json", sound / "truth", "-o", tmp_path / "e")
    assert result.exit_code == 0, result.output
    assert "raw" in result.stdout and "aligned" in result.stdout
    content = json.loads((tmp_path / "e" / "evaluation.json").read_text())
    assert content["poses"] == 500
    assert content["raw"]["position_mean_mm"] < 0.1
    assert content["aligned"]["position_mean_mm"] <= content["raw"]["position_mean_mm"] * 1.01
    assert len(content["planes"]) == 3 and len(content["parameters"]) == 36


def test_the_same_input_gives_the_same_bytes(sound, tmp_path):
    """If a calibration is run again, its file is the same byte for byte."""
    assert run("calibrate", sound / "dataset", "-o", tmp_path).exit_code == 0
    again = (tmp_path / "calibration.json").read_bytes()
    assert again == (sound / "out/calibration.json").read_bytes()


@pytest.mark.parametrize("kind", ["probe", "tracker"])
def test_probe_and_tracker_are_calibrated_and_predict(kind, tmp_path):
    """The datasets of a probe and of a tracker are calibrated, and their calibrations predict frames."""
    scene = make_scene("panda", kind, poses_per_plane=40)
    scene.write(tmp_path / "dataset")
    result = run("calibrate", tmp_path / "dataset", "-o", tmp_path / "out")
    assert result.exit_code == 0, result.output
    scene.truth.poses(5, np.random.default_rng(1)).to_csv(tmp_path / "joints.csv", index=False)
    result = run(
        "predict", tmp_path / "out/calibration.json", tmp_path / "joints.csv", "-o", tmp_path / "frames.csv"
    )
    assert result.exit_code == 0, result.output
