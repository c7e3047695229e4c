"""Choose the dots that are drawn if there are too many for one page.

A dot with its title takes about a hundred bytes. A page has at most a fixed number of dots for all its pictures
together, so that thousands of poses with many effects still make a page of less than 3 MB. A picture with
more values than its share of the dots shows those that lie farthest out, which a reader looks for, and an even choice of
the others; its caption says so. Means, curves and numbers always use all values.
"""

from __future__ import annotations

import numpy as np

from scalar.geometry.se3 import Array

DOTS_IN_PAGE = 20_000
LEAST_DOTS = 200  # a panel may have at least this many dots, however many panels there are
_SHARE_OF_OUTLIERS = 0.1  # share of the drawn dots that are those farthest out


def dots_per_panel(panels: int) -> int:
    """Return how many dots each of ``panels`` panels may draw."""
    return max(DOTS_IN_PAGE // max(panels, 1), LEAST_DOTS)


def thinned(oddness: Array, most: int) -> Array:
    """Return which of many values to draw, as a mask ``(N,)``.

    Args:
        oddness: ``(N,)``, how far out each value lies, in any unit; a value that is not finite counts as 0.
        most: The most values to draw.
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
    """Return the sentence of a caption that states how many values are drawn; empty if all are."""
    if drawn >= count:
        return ""
    return f"{drawn} of {count} values are drawn: those farthest out, and an even choice of the others."
