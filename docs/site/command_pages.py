"""The commands' own ``--help``, for the page ``commands``."""

from __future__ import annotations

from pathlib import Path

import click
from click.testing import CliRunner

import scalar.cli  # noqa: F401 - registers the commands
from scalar.cli.group import cli

_WIDTH = 100


def write_page(path: Path) -> None:
    """Write what `scalar --help` and `scalar COMMAND --help` say."""
    parts = [_help([])]
    for name in sorted(cli.list_commands(click.Context(cli))):
        parts += [f"## scalar {name}", _help([name])]
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n\n".join(parts) + "\n", encoding="utf-8")


def _help(words: list[str]) -> str:
    ran = CliRunner().invoke(
        cli, [*words, "--help"], prog_name="scalar", terminal_width=_WIDTH, catch_exceptions=False
    )
    return f"```text\n{ran.output.rstrip()}\n```"
