"""Which dots are drawn where there are too many for one page.

A dot with its title takes about a hundred bytes. A page has a fixed number of dots for all its pictures
together, so that thousands of poses with many effects still make a page of less than 3 MB. Where a picture has
more values than its part, it shows those that lie farthest out, which a reader looks for, and an even choice of
the others; its caption says so. Means, curves and numbers always take all values.
"""

from __future__ import annotations

import numpy as np

from scalar.geometry.se3 import Array

DOTS_IN_PAGE = 20_000
LEAST_DOTS = 200  # in a picture, however many pictures there are
_SHARE_OF_OUTLIERS = 0.1  # of the dots that are drawn where not all are


def dots_per_panel(panels: int) -> int:
    """Return how many dots each of so many panels may draw."""
    return max(DOTS_IN_PAGE // max(panels, 1), LEAST_DOTS)


def thinned(oddness: Array, most: int) -> Array:
    """Return which of many values to draw, as a mask ``(N,)``.

    Args:
        oddness: ``(N,)``, how far out each lies, in any unit; not finite counts as nothing.
        most: How many to draw at most.
    """
    count = len(oddness)
    if count <= most:
        return np.ones(count, dtype=bool)
    drawn = np.zeros(count, dtype=bool)
    far = int(_SHARE_OF_OUTLIERS * most)
    drawn[np.argsort(-np.where(np.isfinite(oddness), np.abs(oddness), 0.0), kind="stable")[:far]] = True
    others = np.flatnonzero(~drawn)
    drawn[others[np.linspace(0, len(others) - 1, most - far).astype(int)]] = True
    return drawn


def in_caption(drawn: int, count: int) -> str:
    """Return the sentence that tells of thinning; empty where all dots are drawn."""
    if drawn >= count:
        return ""
    return f"{drawn} of {count} values are drawn: those farthest out, and an even choice of the others."
