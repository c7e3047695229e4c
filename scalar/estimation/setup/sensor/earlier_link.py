"""A target or sensor on a link before the last one: the joints after this link do not move it."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from scalar.data.dataset import Dataset
from scalar.estimation.setup.alternatives import Alternative
from scalar.estimation.setup.other_angles import angles_replaced

EARLIER_LINK = "earlier_link"  # as an alternative and a suspicion name it


def earlier_links(dataset: Dataset) -> Iterator[Alternative]:
    """Yield the alternatives in which the last joints that move do not move what is measured, which is on the link before them.

    Args:
        dataset: The measurements as described, of places in space: planes may be anywhere, and are explained by any arm that hardly moves.
    """
    if dataset.planes:
        return
    moving = np.flatnonzero(np.ptp(dataset.q, axis=0) > 0)
    for j in moving[2:][::-1]:
        yield on_link_before(dataset, int(j))


def on_link_before(dataset: Dataset, joint: int) -> Alternative:
    """Return the alternative in which a joint (from 0) and those after it stand at zero, and do not move what is measured."""
    q = dataset.q.copy()
    q[:, joint:] = 0.0
    n = dataset.robot.n_joints
    after = f"joint {n}" if joint + 1 == n else f"joints {joint + 1} to {n}"
    return Alternative(
        EARLIER_LINK,
        after,
        f"{after} {'does' if joint + 1 == n else 'do'} not move what is measured: it is not on the flange, but on the link before joint {joint + 1}",
        f"with {after} left out",
        "put the target on the flange, or describe the arm without these joints (robot.joints of dataset.yaml, and their columns)",
        angles_replaced(dataset, q),
    )
