"""Write text that may quote users' files on the terminal: control characters are escaped, and no character raises an error."""

from __future__ import annotations

import sys
from io import TextIOWrapper
from pathlib import Path

import click

from scalar.errors import printable


def say(text: str, *, err: bool = False) -> None:
    """Write lines on stdout, or on stderr; control characters in them become escapes."""
    click.echo("\n".join(printable(line) for line in text.split("\n")), err=err)


def say_written(path: str | Path, count: int, thing: str, and_also: str = "") -> None:
    """Say that a table was written and how many things it holds, such as ``written: joints.csv, 12 poses``.

    Args:
        path: The table.
        count: Number of things.
        thing: What one of them is called.
        and_also: Words that end the line.
    """
    say(f"written: {path}, {count} {thing}{'' if count == 1 else 's'}{and_also}")


def escape_unencodable() -> None:
    """Write characters that the terminal's encoding lacks as escapes, instead of raising an error."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
