"""The scatter of poses to which the arm came back is that of the arm and the tracker, whatever the geometry."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from scalar.data.dataset import Dataset
from scalar.diagnosis.noise.repeated_poses import repeated_poses
from scalar.report.diagnosed_workspace import repeated_in_words
from tests.random_scene import make_scene

SCATTER = 4e-5  # m, along each axis


def taken(rows: np.ndarray, seed: int = 1, still: int = 1) -> Dataset:
    """Return a tracked arm whose poses are visited in the order ``rows``, and read ``still`` times before the arm moves on.

    Each visit has a shift of its own.
    """
    dataset = make_scene("vs060", "tracker", poses_per_plane=20, noise=1e-9, seed=4).dataset
    shift = SCATTER * np.random.default_rng(seed).standard_normal((len(rows), 3))
    rows, shift = np.repeat(rows, still), np.repeat(shift, still, axis=0)
    number = np.arange(len(rows))
    poses = pd.DataFrame(dataset.poses.iloc[rows]).assign(pose=number, order=number.astype(float))
    return replace(
        dataset,
        poses=poses.reset_index(drop=True),
        points=dataset.points[rows] + shift,
        starts=np.arange(len(rows) + 1),
    )


@pytest.mark.parametrize("still", [1, 3])
def test_the_scatter_of_returns_is_that_of_the_arm(still):
    """Twelve rounds through ten poses scatter as they were made to, by the degrees of freedom; readings of one visit count once."""
    found = repeated_poses(taken(np.tile(np.arange(10), 12), still=still))
    assert found is not None
    assert (found.returns, found.poses) == (110, 10)
    # 330 degrees of freedom: a standard error of 4 %.
    assert found.scatter == pytest.approx(np.sqrt(3) * SCATTER, rel=0.12)


def test_readings_of_a_standstill_are_no_returns():
    """Poses that are read three times in succession, and never again, show nothing of how the arm comes back."""
    dataset = taken(np.arange(20), still=3)
    assert repeated_poses(dataset) is None
    assert repeated_in_words(dataset) == ""


def test_another_session_or_load_is_another_pose():
    """The tracker may stand elsewhere in another session, and the arm bends under another load."""
    dataset = taken(np.tile(np.arange(10), 2))
    later = np.repeat([0, 1], 10)
    assert repeated_poses(dataset) is not None
    sessions = dataset.poses.assign(session=np.where(later, "evening", "morning"))
    assert repeated_poses(replace(dataset, poses=sessions)) is None
    loads = dataset.poses.assign(payload=2.0 * later)
    assert repeated_poses(replace(dataset, poses=loads)) is None


def test_the_report_states_the_scatter():
    """The sentence has the size and how often the arm came back."""
    said = repeated_in_words(taken(np.tile(np.arange(10), 12)))
    assert said.startswith("Repeated poses scatter by 0.0")
    assert "the arm came back 110 times, to 10 poses" in said


def with_noise(dataset: Dataset, noise: float | None) -> Dataset:
    """Return the dataset with another stated noise [m]."""
    return replace(dataset, sensor=replace(dataset.sensor, noise=noise))


@pytest.mark.parametrize("still", [1, 3])
def test_the_scatter_is_compared_with_the_stated_noise(still):
    """Means of several readings scatter by less of the noise; the report speaks only where scatter and stated noise disagree, either way."""
    dataset = taken(
        np.tile(np.arange(10), 12), seed=2, still=still
    )  # a shift that scatters by 1.01 times its size
    found = repeated_poses(with_noise(dataset, SCATTER))
    assert found is not None
    assert found.by_stated_noise == pytest.approx(np.sqrt(3 / still) * SCATTER)
    right, large, small = (SCATTER * np.sqrt(still) * factor for factor in (1.0, 2.0, 0.5))
    assert "stated" not in repeated_in_words(with_noise(dataset, right))
    assert "the noise is stated too large" in repeated_in_words(with_noise(dataset, large))
    assert "unless the noise is stated too small" in repeated_in_words(with_noise(dataset, small))
    assert "stated" not in repeated_in_words(with_noise(dataset, None))


def test_angles_that_were_logged_need_a_wider_limit():
    """Returns whose logged angles differ by hundredths of a milliradian are found with the limit that is asked for, and not without it."""
    dataset = taken(np.tile(np.arange(10), 2))
    names = [f"q{i}" for i in range(1, 7)]
    jitter = np.random.default_rng(2).uniform(-3e-5, 3e-5, (20, 6))
    logged = dataset.poses.assign(**dict(zip(names, (dataset.q + jitter).T, strict=True)))
    dataset = replace(dataset, poses=logged)
    assert repeated_poses(dataset) is None
    found = repeated_poses(dataset, 1e-4)
    assert found is not None and found.returns == 10
