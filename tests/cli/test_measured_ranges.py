"""`scalar predict` and `correct` say how many poses lie clearly outside the ranges of the joints that were measured."""

import json

import numpy as np
import pandas as pd
import pytest

from scalar.estimation.measured_ranges import clearly_outside, measured_ranges
from tests.cli.running import INPUT_AT_FAULT, JOINTS, refused, run

WORDS = "clearly outside the ranges of the joints that were measured"


def measured(sound) -> np.ndarray:
    """Return the joint angles ``(N, 6)`` [rad] of the dataset that was calibrated."""
    return pd.read_csv(sound / "dataset/poses.csv")[JOINTS].to_numpy()


def table(path, q) -> None:
    """Write a table of joint angles ``(N, 6)`` [rad]."""
    pd.DataFrame(q, columns=JOINTS).rename_axis("pose").to_csv(path)


@pytest.mark.parametrize("command", ["predict", "correct"])
def test_poses_beyond_the_measured_ranges_are_counted(command, sound, tmp_path):
    """Three poses of which two have joint 2 far beyond every measured angle: both are counted, with the joint and its measured range in degrees."""
    q = measured(sound)
    low, high = np.degrees([q[:, 1].min(), q[:, 1].max()])
    wanted = q[:3].copy()
    wanted[1:, 1] = q[:, 1].max() + 0.3 * np.ptp(q[:, 1])
    table(tmp_path / "joints.csv", wanted)
    result = run(command, sound / "out/calibration.json", tmp_path / "joints.csv", "-o", tmp_path / "out.csv")
    assert f"2 poses lie {WORDS}" in result.output
    assert f"joint 2 was measured from {low:.0f} to {high:.0f} deg" in result.output


def test_how_a_posture_was_chosen_is_said_where_it_lies_outside(sound, tmp_path):
    """Frames without joint angles get postures near one another, which may lie outside the ranges: a line says how to choose others."""
    q, calibration = measured(sound)[:2], tmp_path / "calibration.json"
    content = json.loads((sound / "out/calibration.json").read_text())
    content["summary"]["measured_ranges"][0] = [5.0, 5.1]  # no posture of these frames turns joint 1 so far
    calibration.write_text(json.dumps(content))
    table(tmp_path / "joints.csv", q)
    assert run("predict", calibration, tmp_path / "joints.csv", "-o", tmp_path / "frames.csv").exit_code == 0
    frames = pd.read_csv(tmp_path / "frames.csv")
    pd.concat([frames, pd.DataFrame(q, columns=JOINTS)], axis=1).to_csv(tmp_path / "both.csv", index=False)
    for name, chosen in (("frames", True), ("both", False)):
        result = run("correct", calibration, tmp_path / f"{name}.csv", "-o", tmp_path / f"{name}_out.csv")
        assert WORDS in result.output and ("each posture was chosen" in result.output) == chosen


@pytest.mark.parametrize("command", ["predict", "correct"])
@pytest.mark.parametrize(("temperature", "is_said"), [(300.0, True), (25.0, False)])
def test_a_temperature_beyond_what_was_measured_is_said(command, temperature, is_said, sound, tmp_path):
    """An effect that follows the temperature was measured from 18 to 30 degrees: 300 degrees are said, with that range, and 25 are not."""
    calibration = tmp_path / "calibration.json"
    content = json.loads((sound / "out/calibration.json").read_text())
    content["summary"]["measured_columns"] = {"temperature": [18.0, 30.0]}
    calibration.write_text(json.dumps(content))
    rows = pd.DataFrame(measured(sound)[:3], columns=JOINTS).assign(temperature=temperature)
    rows.rename_axis("pose").to_csv(tmp_path / "joints.csv")
    result = run(command, calibration, tmp_path / "joints.csv", "-o", tmp_path / "out.csv")
    assert ("3 poses have a temperature outside of what was measured (18 to 30" in result.output) == is_said


@pytest.mark.parametrize("command", ["predict", "correct"])
def test_poses_within_the_measured_ranges_are_not_mentioned(command, sound, tmp_path):
    """At measured poses, and with a calibration that states no ranges, nothing is said of ranges."""
    q = measured(sound)
    table(tmp_path / "joints.csv", q[:3])
    calibration = sound / "out/calibration.json"
    result = run(command, calibration, tmp_path / "joints.csv", "-o", tmp_path / "out.csv")
    assert result.exit_code == 0 and WORDS not in result.output

    content = json.loads(calibration.read_text())
    del content["summary"]["measured_ranges"]
    (tmp_path / "old.json").write_text(json.dumps(content))
    table(tmp_path / "far.csv", q[:3] + np.eye(6)[3])
    result = run(command, tmp_path / "old.json", tmp_path / "far.csv", "-o", tmp_path / "far_out.csv")
    assert WORDS not in result.output


def test_ranges_of_another_number_of_joints_are_refused(sound, tmp_path):
    """A calibration with five ranges for six joints is damaged; the key is named."""
    content = json.loads((sound / "out/calibration.json").read_text())
    content["summary"]["measured_ranges"].pop()
    (tmp_path / "bad.json").write_text(json.dumps(content))
    table(tmp_path / "joints.csv", measured(sound)[:1])
    result = run("predict", tmp_path / "bad.json", tmp_path / "joints.csv", "-o", tmp_path / "out.csv")
    refused(result, INPUT_AT_FAULT, "summary.measured_ranges", "5 ranges", output=tmp_path / "out.csv")


def test_a_tenth_of_the_range_counts_as_within():
    """Of a joint measured from 0 to 1, 1.09 counts as within and 1.11 as outside; likewise below."""
    ranges = measured_ranges({"measured_ranges": [[0.0, 1.0]]})
    assert ranges is not None
    assert clearly_outside(ranges, np.array([[1.09], [1.11], [-0.09], [-0.11]]))[:, 0].tolist() == [
        False,
        True,
        False,
        True,
    ]
    assert measured_ranges({}) is None
