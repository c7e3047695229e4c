"""A warm-up after each stop is named where it was injected, and drifts that continue through the stops are named otherwise.

The heat is the simulator's (motors that warm the links); the data are those of ``tests.effects.injected``.
"""

import numpy as np
import pytest

from scalar import diagnose
from scalar.simulation.injected.heat import warmed
from tests.effects.injected import A, D, Flaws, PoseData, make_cell

GROWTH = 5e-4  # m/m
STOP = 3600.0  # s


def pausing(rng: np.random.Generator, n_poses: int, n_joints: int) -> dict[str, np.ndarray]:
    """Return a time with two pauses."""
    worked = np.cumsum(rng.uniform(5.0, 15.0, n_poses))
    return {"time": worked + STOP * (np.arange(n_poses) * 3 // n_poses)}


def restarting(time: np.ndarray) -> np.ndarray:
    """Return the warmth of links that motors warm at work, and that cool in the pauses."""
    works = np.diff(time) <= 60.0
    return warmed(time, works, 0.3 * np.diff(time)[works].sum())[1]


def through(time: np.ndarray) -> np.ndarray:
    """Return a warm-up of the hall that goes on through the pauses."""
    return 1.0 - np.exp(-3.0 * (time - time[0]) / (time[-1] - time[0]))


def at_work_only(time: np.ndarray) -> np.ndarray:
    """Return a growth with the poses that were measured, which no pause takes back."""
    return np.arange(len(time)) / (len(time) - 1)


def findings(seed: int, course, columns=pausing) -> list[str]:
    """Return the names that a diagnosis gives to an arm whose lengths grow along a course of the time."""
    truth = make_cell(seed=seed, poses_per_plane=3).scene.truth
    lengths = np.zeros_like(truth.geometry)
    lengths[[A, D]] = truth.geometry[[A, D]]

    def growth(at: PoseData) -> np.ndarray:
        return GROWTH * course(at.columns["time"])[:, None, None] * lengths

    cell = make_cell(
        Flaws(geometry=growth), seed=seed, poses_per_plane=30, points_per_scan=20, columns=columns
    )
    return [finding.effect.name for finding in diagnose(cell.dataset).findings]


@pytest.mark.parametrize("seed", [500, pytest.param(501, marks=pytest.mark.slow)])
def test_a_warm_up_after_each_stop_is_named(seed):
    """If the lengths grow from cold three times, this effect is named, and nothing else is."""
    assert findings(seed, restarting) == ["restarted_warm_up"]


@pytest.mark.parametrize("course", [through, at_work_only])
@pytest.mark.parametrize("seed", [500, pytest.param(501, marks=pytest.mark.slow)])
def test_a_drift_without_cooling_is_no_warm_up_after_stops(seed, course):
    """Growth that stops of the arm do not take back, with the time or with each pose, is named a thermal drift and not a warm-up after each stop."""
    assert findings(seed, course) == ["thermal_drift"]


@pytest.mark.parametrize("seed", [500, pytest.param(501, marks=pytest.mark.slow)])
def test_stops_alone_are_no_finding(seed):
    """If a record has stops and the arm has no error, nothing is named."""
    assert findings(seed, np.zeros_like) == []
