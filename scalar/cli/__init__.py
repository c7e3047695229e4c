"""The command line: each command reads its input, calls one function, writes the result, and prints a summary.

Each command has its own file. A module imports what its command needs when the command runs, so that `scalar --help`
imports click alone, and a check of a dataset loads no solver.
"""

from __future__ import annotations

import os
import signal
import sys

# With several threads, small matrices take longer and results are not the same to the byte. NumPy reads these variables when it is first imported.
# They are set whatever they were: clusters set them to the cores of a job, and a result would then depend on its machine.
for _variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[_variable] = "1"

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
from scalar.cli.terminal import escape_unencodable  # noqa: E402

_TERMINATED = 128 + signal.SIGTERM  # the exit status that a shell gives a process ended by this signal


def main() -> None:
    """Run the command line. On SIGTERM, as on an interruption, half-written files are removed."""
    escape_unencodable()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(_TERMINATED))
    cli(prog_name="scalar")
