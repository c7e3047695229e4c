"""Report an unexpected error, a fault of the software itself, in one line that says how to report it."""

from __future__ import annotations

import os
import shlex
import traceback
from collections.abc import Sequence

from scalar.cli.terminal import say

EXIT_STATUS = 70
"""A fault of the software itself, as in ``sysexits.h`` (EX_SOFTWARE)."""
TRACEBACK = "SCALAR_TRACEBACK"
"""The environment variable that, if it is 1, makes the traceback of such an error appear."""


def report(error: Exception, arguments: Sequence[str]) -> None:
    """Write one line on stderr about an unexpected error, after its traceback if ``SCALAR_TRACEBACK`` is 1.

    Args:
        error: The error.
        arguments: Arguments of the command line, without the name of the program.
    """
    if os.environ.get(TRACEBACK) == "1":
        traceback.print_exception(error)
    what = " ".join([type(error).__name__, *str(error).split()])[:200]
    command = f"{TRACEBACK}=1 scalar {shlex.join(arguments)}"
    say(
        f"scalar: a fault of this program ({what}), not of your data; to report it, send what this prints: {command}",
        err=True,
    )
