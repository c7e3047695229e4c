"""Peak memory of this process. Standard library alone, since programs in other environments import it too."""

from __future__ import annotations

import resource
import sys
from pathlib import Path

_KIB = 1024
_UNIT = 1 if sys.platform == "darwin" else _KIB  # of ru_maxrss


def peak_bytes() -> int:
    """Return the peak of the resident memory of this process [bytes].

    Linux: ``VmHWM``, since ``ru_maxrss`` begins with what the process that started this one occupied. Elsewhere ``ru_maxrss``.
    """
    try:
        lines = Path("/proc/self/status").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    for line in lines:
        if line.startswith("VmHWM:"):
            return _KIB * int(line.split()[1])
    return _UNIT * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
