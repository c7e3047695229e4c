"""What the tables have wrong at poses that were set aside: a joint that was not logged there, or a row that was lost or doubled before them."""

from __future__ import annotations

from collections.abc import Sequence

from scalar.data.dataset import Dataset
from scalar.estimation.model import Model
from scalar.estimation.setup.suspicion import Suspicion
from scalar.estimation.setup.tables.lost_row import lost_row_in_words
from scalar.estimation.setup.tables.stuck_joint import stuck_joint_in_words


def wrongly_logged(dataset: Dataset, set_aside: Sequence[int], model: Model) -> list[Suspicion]:
    """Return the suspicion that explains why poses contradict the others by what was written of them; none if nothing does.

    Args:
        dataset: All that was measured, in the order of acquisition.
        set_aside: Ids of the poses that contradict the others.
        model: Fitted to the others.
    """
    if not set_aside:
        return []
    if stuck := stuck_joint_in_words(dataset, set_aside):
        return [Suspicion("stuck_joint", "poses.csv", stuck)]
    if lost := lost_row_in_words(dataset, model, set_aside):
        return [Suspicion("lost_row", "poses.csv", lost)]
    return []
