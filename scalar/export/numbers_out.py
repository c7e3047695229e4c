"""Numbers in files for other programs: as short as they read back exactly."""

from __future__ import annotations


def shortest(value: float) -> str:
    """Return the shortest text that reads back as the same float64, without a sign of zero: 0.2363, and not 0.23630000000000001."""
    return repr(float(value) + 0.0).removesuffix(".0")
