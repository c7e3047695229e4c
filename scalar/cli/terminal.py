"""Write text that may quote users' files on the terminal: control characters are escaped, and no character raises an error."""

from __future__ import annotations

import sys
from io import TextIOWrapper

import click

from scalar.errors import printable


def say(text: str, *, err: bool = False) -> None:
    """Write lines on stdout, or on stderr; control characters in them become escapes."""
    click.echo("\n".join(printable(line) for line in text.split("\n")), err=err)


def accept_every_name() -> None:
    """Write characters that the terminal's encoding lacks as escapes, instead of raising an error."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
