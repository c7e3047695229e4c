"""Effects of another arm are refused where its table differs, and asked about where only its name does."""

from dataclasses import replace

import pytest

from tests.cli.running import INPUT_AT_FAULT, refused, run
from tests.random_scene import make_scene


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return a folder with a calibration that has an effect, and datasets of arms of another name and another table."""
    folder = tmp_path_factory.mktemp("arms")
    dataset = make_scene("ur10e", "tracker", poses_per_plane=15, seed=5).dataset
    dataset.write(folder / "one")
    for name in ("UR10-e", "second arm"):
        replace(dataset, robot=replace(dataset.robot, name=name)).write(folder / name)
    make_scene("panda", "tracker", poses_per_plane=20, seed=5).dataset.write(folder / "panda")
    assert run("calibrate", folder / "one", "-o", folder / "out", "--effects", "joint_scale:2").exit_code == 0
    return folder


def calibrated(folder, name):
    """Return the result of calibrating a dataset with the effects of the first arm."""
    given = folder / "out" / "calibration.json"
    return run("calibrate", folder / name, "-o", folder / f"out {name}", "--effects-from", given)


def test_an_arm_of_another_name_is_asked_about(folder):
    """Two arms of one model share a table of joints and no errors; another spelling of one name is no other arm."""
    other = calibrated(folder, "second arm")
    assert other.exit_code == 0
    assert "found for an arm called 'ur10e', and this one is called 'second arm'" in other.output
    assert "check the arm" not in calibrated(folder, "UR10-e").output
    assert "check the arm" not in calibrated(folder, "one").output


def test_an_arm_with_another_number_of_joints_is_refused(folder):
    """The refusal names the option and both numbers, and nothing is written."""
    result = calibrated(folder, "panda")
    refused(result, INPUT_AT_FAULT, "--effects-from", "6 joints", "'panda' has 7")
