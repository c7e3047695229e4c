"""Datasets whose measurements stand beside other joint angles than they are listed with."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from scalar.data.dataset import Dataset
from scalar.geometry.se3 import Array

if TYPE_CHECKING:
    import pandas as pd


def angles_replaced(dataset: Dataset, q: Array) -> Dataset:
    """Return a dataset with other joint positions ``(N, n)`` [rad; m for a prismatic joint]."""
    columns = {f"q{j + 1}": q[:, j] for j in range(q.shape[1])}
    return replace(dataset, poses=dataset.poses.assign(**columns))


def swapped_columns(q: Array, i: int, j: int) -> Array:
    """Return joint positions ``(N, n)`` with the columns of two joints (from 0) exchanged."""
    swapped = q.copy()
    swapped[:, [i, j]] = q[:, [j, i]]
    return swapped


def shifted(dataset: Dataset, shifts: Array, labels_go_along: bool) -> Dataset:
    """Return the dataset with the angles of each row taken from a row near it; rows for which there is none are left out.

    Args:
        dataset: Poses in the order of acquisition.
        shifts: ``(N,)`` integers, how many rows before each row its angles stand.
        labels_go_along: Whether the label of the plane stands with the angles, or with the measurement.
    """
    source = np.arange(dataset.n_poses) - shifts
    rows = np.flatnonzero((source >= 0) & (source < dataset.n_poses))
    return with_angles_of(dataset.subset(rows), dataset.poses.iloc[source[rows]], labels_go_along)


def with_angles_of(dataset: Dataset, others: pd.DataFrame, labels_go_along: bool) -> Dataset:
    """Return the dataset with the angles of other poses, as many as it has, and their labels of the plane as well if these stand with the angles."""
    columns = [f"q{j + 1}" for j in range(dataset.robot.n_joints)] + (["plane"] if labels_go_along else [])
    return replace(dataset, poses=dataset.poses.assign(**{name: others[name].to_numpy() for name in columns}))
