"""Run ``scalar`` in this process, and check how it refuses."""

from pathlib import Path

from click.testing import CliRunner, Result

from scalar.cli import cli
from tests.kinematics import joint_names

INPUT_AT_FAULT, UNDETERMINED = 2, 3


def run(*arguments: object) -> Result:
    """Run ``scalar`` in this process."""
    return CliRunner().invoke(cli, [str(argument) for argument in arguments])


def begun(folder: Path, *robot: object, sensor: str = "tracker") -> Path:
    """Return a folder that `scalar init` has written."""
    result = run("init", folder, *robot, "--sensor", sensor)
    assert result.exit_code == 0, result.output
    return folder


def refused(
    result: Result, status: int, *words: str, output: Path | None = None, lines: int | None = None
) -> None:
    """Check a refusal: its status, one line a fault on stderr, the words, no traceback, and no output."""
    assert result.exit_code == status, result.output
    assert isinstance(result.exception, SystemExit)
    assert result.stdout == ""
    said = result.stderr.splitlines()
    assert said and all(line.startswith("scalar: ") for line in said)
    assert "Traceback" not in result.stderr
    if lines is not None:
        assert len(said) == lines, result.stderr
    for word in words:
        assert word in result.stderr, result.stderr
    if output is not None:
        assert not output.exists()


JOINTS = joint_names(6)
