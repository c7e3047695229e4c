"""Give memory that was freed back to the system.

The C library keeps freed arrays of some megabytes for later ones. After hundreds of fits to thousands of poses the pieces no longer suit, and the
process is twice as large as all that it holds.
"""

from __future__ import annotations

import ctypes
import sys


def give_back() -> None:
    """Give freed memory back; do nothing where the C library has no such call, as on macOS and Windows."""
    if sys.platform.startswith("linux"):
        trim = getattr(ctypes.CDLL(None), "malloc_trim", None)
        if trim is not None:  # musl has none
            trim(0)
