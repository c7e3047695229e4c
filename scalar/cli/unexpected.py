"""The last guard: what no part of this package foresaw becomes one line that says how to report it."""

from __future__ import annotations

import os
import shlex
import traceback
from collections.abc import Sequence

from scalar.cli.terminal import say

EXIT_STATUS = 70
"""A fault of the software itself, as in ``sysexits.h`` (EX_SOFTWARE)."""
TRACEBACK = "SCALAR_TRACEBACK"
"""The environment variable that shows where a fault of the software arose."""


def report(error: Exception, arguments: Sequence[str]) -> None:
    """Write one line on stderr about an error that nothing foresaw, after its traceback where that is asked for.

    Args:
        error: What was raised.
        arguments: Of the command line, without the name of the program.
    """
    if os.environ.get(TRACEBACK) == "1":
        traceback.print_exception(error)
    what = " ".join([type(error).__name__, *str(error).split()])[:200]
    command = f"{TRACEBACK}=1 scalar {shlex.join(arguments)}"
    say(
        f"scalar: a fault of this program ({what}), not of your data; to report it, send what this prints: {command}",
        err=True,
    )
