"""`scalar correct` repeats a calibration's doubts about numbers of the table of joints, and not those about the robot's name."""

from types import SimpleNamespace
from typing import Any

from scalar.cli.pose_lines import lines_on_setup


def calibration(*doubts: dict[str, str]) -> Any:
    """Return a calibration with these entries of ``setup``."""
    return SimpleNamespace(summary={"setup": list(doubts)})


def test_a_doubtful_number_is_repeated_and_a_doubtful_name_is_not():
    """A mistyped length makes corrections wrong; a name changes nothing. Files of earlier releases may lack a key."""
    length = {"what": "robot", "where": "a_3", "sentence": "a_3 comes out 30 mm longer"}
    name = {
        "what": "robot",
        "where": "robot.name",
        "sentence": "the robot is called 'ur5e', but its table is another",
    }
    (line,) = lines_on_setup(calibration(length, name))
    assert "a_3 comes out 30 mm longer" in line and "ur5e" not in line
    assert lines_on_setup(calibration({"what": "noise", "sentence": "the noise is stated too large"})) == []


def test_a_sign_or_zero_that_is_the_plainer_reading_is_repeated():
    """It is said in place of a doubtful number, so that a program would be corrected by the wrong table without a word."""
    sign = {
        "what": "joint_reading",
        "where": "joint 5",
        "sentence": "a_6 comes out 116 mm off. But all come out if joint 5 counts back",
    }
    (line,) = lines_on_setup(calibration(sign))
    assert "if joint 5 counts back" in line
