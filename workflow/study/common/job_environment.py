"""The variables of the environment that every job gets."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path

THREADED_LIBRARIES = ("OMP", "OPENBLAS", "MKL", "NUMEXPR")


def job_environment(folders: Sequence[Path], now: Mapping[str, str]) -> dict[str, str]:
    """Return the variables to set: where modules are looked for, and one thread for every library that does arithmetic.

    With one thread a job, the same seed gives the same bytes on any number of cores, and two jobs do not fight for two cores.

    Args:
        folders: Of the checkout; they come before those that PYTHONPATH names now. now: The environment as it is.
    """
    search = [*map(str, folders), now.get("PYTHONPATH", "")]
    return {
        "PYTHONPATH": os.pathsep.join(filter(None, search)),
        **{f"{library}_NUM_THREADS": "1" for library in THREADED_LIBRARIES},
    }
