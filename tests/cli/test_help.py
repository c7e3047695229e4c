"""The help of the commands."""

import re
from pathlib import Path

import pytest

from tests.cli.correcting import WRITTEN
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


def test_help_of_correct_is_short_and_leads_to_the_rest():
    """It fits on a screen with its options, and names a heading of the documentation that is there; each column that is written stands under it."""
    text = run("correct", "--help").stdout
    assert len(text.splitlines()) <= 45
    page, heading = re.search(r"(docs/\w+\.md), under \"(.*?)\"", " ".join(text.split())).groups()
    headed = (
        (Path(__file__).parents[2] / page)
        .read_text(encoding="utf-8")
        .replace("`scalar correct`", "scalar correct")
    )
    _, _, section = headed.partition(f"### {heading}\n")
    for column in WRITTEN:
        assert f"`{column}`" in section
