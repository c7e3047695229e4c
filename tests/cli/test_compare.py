"""``scalar compare``: what it says and writes of changes of the geometry, and what it refuses."""

import json
from dataclasses import replace

import numpy as np
import pytest

from scalar.estimation.result import load_calibration
from scalar.geometry.robot import Robot
from tests.calibrated_arms import calibrated
from tests.cli.comparing import save_calibrations
from tests.cli.running import run
from tests.robot_configs import robot_mapping


@pytest.fixture
def folder(tmp_path):
    """Return a folder with calibrations of one arm and of two others."""
    return save_calibrations(tmp_path)


def test_a_changed_zero_is_said_and_written(folder):
    """The terminal names the joint, the size of its change in degrees and the move.

    The JSON has the same in SI units, and states what was compared.
    """
    result = run("compare", folder / "a.json", folder / "b.json", "-o", folder / "c.json")
    assert result.exit_code == 0, result.output
    assert "1 change beyond chance" in result.output
    assert "joint 3, zero theta_3: +0.0573" in result.output
    content = json.loads((folder / "c.json").read_text(encoding="utf-8"))
    assert content["changed"] is True
    parameter = content["changes"][0]["parameters"]["theta_3"]
    assert parameter["value"] == pytest.approx(1e-3)
    assert parameter["unit"] == "rad"
    assert content["changes"][0]["moves_positions"]["rms_mm"] > 0
    assert "what to do: use B from now on" in result.output and "master the joint again" in result.output


def test_nothing_is_advised_where_nothing_changed(folder):
    """Two equal calibrations, and a tool that moved on the flange, ask for nothing to be done to the arm."""
    for other in ("a.json", "bent.json"):
        assert "what to do" not in run("compare", folder / "a.json", folder / other).output


def test_a_tool_that_was_bent_is_no_change_of_the_arm_and_is_said(folder):
    """A sensor that moved on the flange leaves the arm unchanged; its distance is stated, with what that means if nobody took it off."""
    result = run("compare", folder / "a.json", folder / "bent.json")
    assert result.exit_code == 0, result.output
    (line,) = [line for line in result.output.splitlines() if "place on the flange differs" in line]
    assert "1.000 +- 0.014 mm" in line and "not of the arm" in line and "bent" in line


def test_a_sensor_that_stayed_in_its_place_is_not_called_bent(folder):
    """Without a shift there is nothing to explain."""
    assert (
        "0.000 +- 0.014 mm: not beyond chance\n"
        in run("compare", folder / "a.json", folder / "b.json").output
    )


def test_a_user_of_standard_dh_reads_the_rows_of_that_table(folder):
    """The a_3 of modified DH is shown as the length in row 2 of standard DH, and the JSON keeps the names of the model."""
    for name, step in (("a.json", 0.0), ("b.json", 2e-4)):
        made = load_calibration(folder / name)
        model = made.model.with_vector(made.model.vector + step * (np.array(made.model.names) == "a_3"))
        robots = {
            part: replace(getattr(model, part), standard_end=(0.0, 0.0)) for part in ("nominal", "robot")
        }
        replace(made, model=replace(model, **robots)).save(folder / f"standard_{name}")
    written = folder / "c.json"
    result = run("compare", folder / "standard_a.json", folder / "standard_b.json", "-o", written)
    assert "joint 2, length a 2: +0.20" in result.output and "a_3" not in result.output
    assert "a_3" in written.read_text(encoding="utf-8")


def test_calibrations_whose_noise_nobody_stated_are_compared(folder):
    """For a tracker without stated noise, the numbers that would compare the residual with the noise are null."""
    for name in ("a.json", "b.json"):
        content = json.loads((folder / name).read_text(encoding="utf-8"))
        content["summary"] |= {"misfit": 1.0, "misfit_p_value": None}
        (folder / name).write_text(json.dumps(content), encoding="utf-8")
    result = run("compare", folder / "a.json", folder / "b.json")
    assert result.exit_code == 0, result.output
    assert "joint 3, zero theta_3" in result.output


def test_models_that_lack_something_show_no_change_of_the_arm(folder):
    """If the residual is many times the noise, a difference beyond chance is not called a change. The message says what would show one."""
    for name in ("a.json", "b.json"):
        content = json.loads((folder / name).read_text(encoding="utf-8"))
        content["summary"] |= {"misfit": 28.0, "misfit_p_value": 0.0}
        (folder / name).write_text(json.dumps(content), encoding="utf-8")
    result = run("compare", folder / "a.json", folder / "b.json")
    assert result.exit_code == 0, result.output
    assert "the calibrations differ: 1 difference beyond chance" in result.output
    assert (
        "the arm changed" not in result.output
        and "both by scalar calibrate with the same --effects" in result.output
    )


def test_the_same_calibration_twice_shows_no_change(folder):
    """Comparing a file with itself, or with a copy, ends with exit status 0; that nothing changed is said, and that both are one calibration."""
    (folder / "copy.json").write_bytes((folder / "a.json").read_bytes())
    for other, same in (("a.json", True), ("copy.json", True), ("b.json", False)):
        result = run("compare", folder / "a.json", folder / other)
        assert result.exit_code == 0
        assert ("no change of the arm beyond chance" in result.output) == same
        assert ("A and B are the same calibration" in result.output) == same


@pytest.mark.parametrize(
    ("other", "words"),
    [("puma.json", "another arm"), ("panda.json", "7 joints"), ("none.json", "no such file")],
)
def test_what_cannot_be_compared_is_refused(other, words, folder):
    """For another arm or a missing file the exit status is 2, with one line, and nothing is written."""
    result = run("compare", folder / "a.json", folder / other, "-o", folder / "c.json")
    assert result.exit_code == 2
    assert words in result.stderr
    assert len(result.stderr.splitlines()) == 1
    assert not (folder / "c.json").exists()


def test_a_calibration_without_standard_errors_is_refused(folder):
    """A calibration that was never fitted has no standard errors by which chance could be judged, and is refused."""
    made = calibrated(Robot.from_mapping(robot_mapping("vs060")), np.random.default_rng(1))
    made.save(folder / "nominal.json")
    result = run("compare", folder / "a.json", folder / "nominal.json")
    assert result.exit_code == 2
    assert "no standard errors" in result.stderr
