"""Rows that were copied, and readings that were repeated, are said, since they count as measurements of their own."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from scalar.data.dataset import Dataset
from scalar.estimation.calibrate import calibrate
from scalar.estimation.setup.tables.copies import copied_poses, repeated_readings
from tests.random_scene import make_scene


def with_copies(dataset: Dataset, copies: int, noise: float) -> Dataset:
    """Return a tracker's dataset with its first poses once more, measured with further noise [m]."""
    rows = np.r_[np.arange(dataset.n_poses), np.arange(copies)]
    poses = dataset.poses.iloc[rows].assign(pose=np.arange(len(rows)), order=np.arange(len(rows)))
    points = dataset.points[rows].copy()
    points[dataset.n_poses :] += noise * np.random.default_rng(3).standard_normal((copies, 3))
    return replace(
        dataset,
        poses=pd.DataFrame(poses).reset_index(drop=True),
        points=points,
        starts=np.arange(len(rows) + 1),
    )


@pytest.mark.parametrize(("copies", "said"), [(1, "poses 0 and 60 have"), (5, "and 4 more such pairs")])
def test_copies_are_said(copies, said):
    """The first pair is named, and the others are counted; poses that were measured again are none."""
    dataset = make_scene("vs060", "tracker", poses_per_plane=20, noise=5e-5, seed=4).dataset
    assert not copied_poses(dataset)
    assert not copied_poses(with_copies(dataset, copies, 1e-9))
    told = [entry["sentence"] for entry in calibrate(with_copies(dataset, copies, 0.0)).summary["setup"]]
    assert len(told) == 1 and said in told[0] and "remove copies" in told[0]


@pytest.mark.parametrize(("rows", "said"), [("readings", True), ("rounds", False), ("checks", False)])
def test_readings_of_one_standstill_are_said(rows, said):
    """Three readings of each pose before the arm moves on are said; a program that is run three times, and a pose or two taken again, are not."""
    dataset = make_scene("vs060", "tracker", poses_per_plane=20, noise=5e-5, seed=4).dataset
    n = dataset.n_poses
    taken = {
        "readings": np.repeat(np.arange(n), 3),
        "rounds": np.tile(np.arange(n), 3),
        "checks": np.r_[0, 0, np.arange(1, n), n - 1],
    }[rows]
    noise = 1e-6 * np.random.default_rng(3).standard_normal((len(taken), 3))
    poses = dataset.poses.iloc[taken].assign(pose=np.arange(len(taken)), order=np.arange(len(taken)))
    repeated = replace(
        dataset,
        poses=pd.DataFrame(poses).reset_index(drop=True),
        points=dataset.points[taken] + noise,
        starts=np.arange(len(taken) + 1),
    )
    told = [entry["sentence"] for entry in calibrate(repeated).summary["setup"]]
    assert len(told) == said
    if said:
        assert (
            f"{2 * n} of {3 * n} rows have the joint angles of the row before (first pose 1, after pose 0)"
            in told[0]
        )
    assert bool(repeated_readings(repeated)) == said
