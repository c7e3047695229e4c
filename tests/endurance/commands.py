"""Run a command of ``scalar`` within this process, and judge how it ends."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from pathlib import Path

from click.testing import CliRunner

from scalar.cli import cli
from scalar.errors import Undetermined


def outcome(arguments: Sequence[object], output: Path) -> str:
    """Return what a command prints, and then what it writes.

    Args:
        arguments: Of the command line, without the name of the program.
        output: What the command is told to write; it is removed before.

    Raises:
        Undetermined: The command refused its input, exit status 2 or 3; with its lines on stderr.
        AssertionError: It ended otherwise, said nothing, or left something behind.
    """
    if output.is_dir():
        shutil.rmtree(output)
    output.unlink(missing_ok=True)
    result = CliRunner().invoke(cli, [str(argument) for argument in arguments])
    if result.exit_code in (2, 3):
        assert not output.exists(), f"refused, and {output.name} was written: {result.output}"
        assert result.stderr.startswith("scalar: "), result.output
        raise Undetermined(result.stderr.splitlines())
    assert result.exit_code == 0, result.output
    files = sorted(output.iterdir()) if output.is_dir() else [output]
    return result.output + "".join(path.read_text(encoding="utf-8") for path in files)
