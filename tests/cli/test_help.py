"""The help of the commands."""

import pytest

from tests.cli.running import run


@pytest.mark.parametrize(
    "command", ["simulate", "validate", "calibrate", "diagnose", "predict", "correct", "export", "evaluate"]
)
def test_help_shows_an_example(command):
    """Each command's help ends with a command line to copy."""
    result = run(command, "--help")
    assert result.exit_code == 0
    assert "Example" in result.stdout
    assert f"scalar {command} " in result.stdout.split("Example", 1)[1]


def test_help_of_all_names_every_command_and_status():
    """``scalar --help`` leads from a dataset to frames and says what the exit statuses mean."""
    text = run("--help").stdout
    for words in (
        "simulate",
        "validate",
        "calibrate",
        "diagnose",
        "predict",
        "export",
        "evaluate",
        "Exit status",
    ):
        assert words in text
    assert run("--version").stdout.startswith("scalar")
