"""From which pose on something of a set-up is different: the one that leaves the smallest residual, sought over all poses and then near the best."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from scalar.data.dataset import Dataset
from scalar.estimation.setup.trial import MOST_POSES, full_fit, nominal_fit
from scalar.geometry.se3 import Array

WithBreak = Callable[[Dataset, int], Dataset]
"""What returns a dataset in which something is different from a row (from 0) on."""
BREAKS = 12  # tried at once; the next ones lie between the neighbours of the best


def best_break(dataset: Dataset, with_break: WithBreak, least: int) -> int | None:
    """Return the row (from 0) of the first pose after a change that leaves the smallest residual; None if there are too few poses.

    The errors of the nominal arm hide a small change at single poses. The last rows are therefore compared with the arm as fitted with the best
    break.

    Args:
        dataset: What was measured.
        with_break: Returns the dataset with the change from a row on.
        least: Fewest poses before the change, and after it.
    """
    first, last = least, dataset.n_poses - least
    if first > last:
        return None
    k = _least_residual(dataset, with_break, first, last)
    trial = full_fit(with_break(dataset, k))
    if trial is None:
        return k
    fitted = replace(dataset, robot=trial.model.robot)
    return _least_residual(fitted, with_break, max(first, k - BREAKS), min(last, k + BREAKS))


def _least_residual(dataset: Dataset, with_break: WithBreak, low: int, high: int) -> int:
    """Return the row from ``low`` to ``high`` at which a change leaves the smallest residual, all tried poses counted."""
    while True:
        tried = np.unique(np.linspace(low, high, BREAKS).round().astype(int))
        rows = _rows_about(dataset.n_poses, low, high)
        at = int(np.argmin([nominal_fit(with_break(dataset, int(k)).subset(rows)).of_all for k in tried]))
        if high - low < BREAKS:
            return int(tried[at])
        low, high = int(tried[max(at - 1, 0)]), int(tried[min(at + 1, len(tried) - 1)])


def _rows_about(n_poses: int, low: int, high: int) -> Array:
    """Return at most ``MOST_POSES`` rows: half of them over all poses, the rest between two rows, where they are denser."""
    everywhere = np.linspace(0, n_poses - 1, MOST_POSES // 2)
    between = np.linspace(low - 1, high, MOST_POSES // 2)
    return np.unique(np.concatenate([everywhere, between]).round().astype(int))
