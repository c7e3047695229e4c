"""Write on the terminal what may quote users' files: nothing in a name steers the terminal, and none stops the program."""

from __future__ import annotations

import sys
from io import TextIOWrapper

import click

from scalar.errors import printable


def say(text: str, *, err: bool = False) -> None:
    """Write lines on stdout, or on stderr; control characters in them become escapes."""
    click.echo("\n".join(printable(line) for line in text.split("\n")), err=err)


def accept_every_name() -> None:
    """Let characters outside the terminal's encoding be written as escapes, where Python would raise."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
