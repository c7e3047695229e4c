"""One of several targets that does not move with the flange, as a reflector on a link before the last one, beside others that do."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from scalar.data.dataset import Dataset
from scalar.estimation.setup.alternatives import Alternative
from scalar.sensors import kind_of


def strange_targets(dataset: Dataset) -> Iterator[Alternative]:
    """Yield the alternatives in which one target is left out; none where there are no others."""
    if len(dataset.targets) < 2 or "target" not in dataset.point_columns:
        return
    for k, name in enumerate(dataset.targets):
        others = _without(dataset, k)
        if others is not None:
            yield Alternative(
                "strange_target",
                f"target {name}",
                f"target {name} does not move as the other targets do",
                "without it",
                "look whether it is on the flange, and whether it stayed in its place; or leave its rows out",
                others,
                file=kind_of(dataset).format.measured_in,
            )


def _without(dataset: Dataset, k: int) -> Dataset | None:
    """Return the dataset without one of its targets and the poses that show no other; None if it has no points, or all of them."""
    owner = dataset.point_columns["target"].astype(int)
    kept = owner != k
    if kept.all() or not kept.any():
        return None
    pose = dataset.pose_of_point[kept]
    columns = {name: values[kept] for name, values in dataset.point_columns.items()}
    columns["target"] = np.where(owner[kept] > k, owner[kept] - 1, owner[kept])
    counts = np.bincount(pose, minlength=dataset.n_poses)
    left = replace(
        dataset,
        points=dataset.points[kept],
        starts=np.concatenate([[0], np.cumsum(counts)]),
        point_columns=columns,
        targets=tuple(name for i, name in enumerate(dataset.targets) if i != k),
    )
    return left if np.all(counts > 0) else left.subset(np.flatnonzero(counts > 0))
