"""The environment variables that every job gets."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path

ONE_THREAD = {f"{library}_NUM_THREADS": "1" for library in ("OMP", "OPENBLAS", "MKL", "NUMEXPR")}
"""One thread for every library that does arithmetic."""


def job_environment(folders: Sequence[Path], now: Mapping[str, str]) -> dict[str, str]:
    """Return the variables to set: the path on which modules are searched, and one thread for every library that does arithmetic.

    With one thread for each job, the same seed gives the same bytes on any number of cores, and two jobs do not compete for two cores.

    Args:
        folders: Folders of the checkout that are searched first.
        now: The present environment; the folders in its PYTHONPATH are searched next.
    """
    search = [*map(str, folders), now.get("PYTHONPATH", "")]
    return {
        "PYTHONPATH": os.pathsep.join(filter(None, search)),
        **ONE_THREAD,
    }
