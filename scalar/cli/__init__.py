"""The command line: each command reads, calls one function, writes, and says what was found.

A command is a file. A module imports what its command needs when the command runs, so that `scalar --help`
imports click alone, and a check of a dataset loads no solver.
"""

from __future__ import annotations

import os
import signal
import sys

# Small matrices lose time, and reproducible bytes, to threads. Set before NumPy is first imported, by a command.
for _variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_variable, "1")

from scalar.cli import (  # noqa: E402, F401
    calibrate,
    compare,
    correct,
    demo,
    diagnose,
    evaluate,
    export,
    import_,
    import_bag,
    init,
    plan,
    predict,
    simulate,
    validate,
)
from scalar.cli.group import cli  # noqa: E402
from scalar.cli.terminal import accept_every_name  # noqa: E402

_TERMINATED = 128 + signal.SIGTERM  # as a shell has it


def main() -> None:
    """Run the command line. A request to end (SIGTERM) removes what is half-written, like an interruption."""
    accept_every_name()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(_TERMINATED))
    cli(prog_name="scalar")
