"""Rows that were copied are said, since they count as measurements of their own."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from scalar.data.dataset import Dataset
from scalar.estimation.calibrate import calibrate
from scalar.estimation.setup.copies import copied_poses
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
