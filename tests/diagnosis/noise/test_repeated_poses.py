"""The scatter of poses to which the arm came back is that of the arm and the tracker, whatever the geometry."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from scalar import calibrate
from scalar.data.dataset import Dataset
from scalar.diagnosis.noise.repeated_poses import repeated_poses
from scalar.report.diagnosed_workspace import repeated_in_words
from tests.diagnosis.tracked_arm import LIMITS
from tests.estimation.test_data_sheet_priors import workcell
from tests.random_scene import make_scene
from tests.tracked_targets import drawn_arm

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
    assert repeated_in_words(dataset, calibrate(dataset).model) == ""


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
    dataset = taken(np.tile(np.arange(20), 6))
    said = repeated_in_words(dataset, calibrate(dataset).model)
    assert said.startswith("Repeated poses scatter by 0.0")
    assert "the arm came back 100 times, to 20 poses" in said


def with_noise(dataset: Dataset, noise: float | None) -> Dataset:
    """Return the dataset with another stated noise [m]."""
    return replace(dataset, sensor=replace(dataset.sensor, noise=noise))


@pytest.mark.parametrize("still", [1, 3])
def test_the_scatter_is_compared_with_the_stated_noise(still):
    """Means of several readings scatter by less of the noise; the report speaks only where scatter and stated noise disagree, either way."""
    dataset = taken(
        np.tile(np.arange(20), 6), seed=2, still=still
    )  # a shift that scatters by 1.01 times its size
    found = repeated_poses(with_noise(dataset, SCATTER))
    assert found is not None
    assert found.by_stated_noise == pytest.approx(np.sqrt(3 / still) * SCATTER)
    right, large, small = (SCATTER * np.sqrt(still) * factor for factor in (1.0, 2.0, 0.5))
    model = calibrate(with_noise(dataset, None)).model
    assert "stated" not in repeated_in_words(with_noise(dataset, right), model)
    assert "the noise is stated too large" in repeated_in_words(with_noise(dataset, large), model)
    assert "unless the noise is stated too small" in repeated_in_words(with_noise(dataset, small), model)
    assert "stated" not in repeated_in_words(with_noise(dataset, None), model)


def test_what_logged_angles_differ_by_is_no_scatter():
    """Returns to angles that differ by hundredths of a milliradian are found, and what these differences move is not taken for scatter."""
    rng = np.random.default_rng(2)
    q = np.tile(rng.uniform(-1, 1, (10, 6)) * LIMITS, (12, 1)) + rng.uniform(-4e-5, 4e-5, (120, 6))
    dataset, where = workcell(2, q)
    dataset = replace(dataset, points=where(q) + 1e-5 * rng.standard_normal((120, 3)))
    alone, given = repeated_poses(dataset), repeated_poses(dataset, calibrate(dataset).model)
    assert alone is not None and given is not None
    assert given.returns == alone.returns == 110
    assert given.scatter == pytest.approx(np.sqrt(3) * 1e-5, rel=0.12)
    assert alone.scatter > 1.3 * given.scatter


def test_each_of_several_targets_is_expected_at_its_own_place():
    """With three targets of which some are hidden, a reading is compared with where its own target should be."""
    rng = np.random.default_rng(3)
    arm = drawn_arm(rng, ("A", "B", "C"))
    q = np.tile(arm.poses(30, rng), (4, 1)) + rng.uniform(-4e-5, 4e-5, (120, 6))
    seen = rng.random((len(q), 3)) < 0.8
    seen[:, 0] |= ~seen.any(axis=1)
    dataset = arm.dataset(q, rng, noise=1e-5, seen=seen)
    found = repeated_poses(dataset, calibrate(dataset).model)
    assert found is not None and found.returns > 80
    assert found.scatter == pytest.approx(np.sqrt(3) * 1e-5, rel=0.15)
