"""Where the arm's lengths follow a recorded temperature, the temperature is named, although a warm-up with a fitted constant explains as much."""

import numpy as np
import pytest

from scalar.diagnosis.fit.fitted_state import refit
from scalar.diagnosis.scoring.candidate_columns import named_candidates
from scalar.diagnosis.selection.forward_selection import select_forward
from scalar.estimation.geometry_fit import geometry_fit
from tests.effects.injected import A, D, Flaws, PoseData, make_cell

GROWTH = 2.3e-5  # 1/K
WARMING, CONSTANT = 12.0, 60.0  # K, poses
THERMOMETER = 0.03  # K: its last digit


def warming(rng: np.random.Generator, n_poses: int, n_joints: int) -> dict[str, np.ndarray]:
    """Return the temperature of an arm that warms up while it is measured, as a thermometer on it shows it."""
    temperature = 20.0 + WARMING * (1.0 - np.exp(-np.arange(n_poses) / CONSTANT))
    return {"temperature": temperature + THERMOMETER * rng.standard_normal(n_poses)}


def growing(seed: int):
    """Return a dataset of an arm whose lengths grow with that temperature."""
    truth = make_cell(seed=seed, poses_per_plane=3).scene.truth
    lengths = np.zeros_like(truth.geometry)
    lengths[[A, D]] = truth.geometry[[A, D]]

    def growth(at: PoseData) -> np.ndarray:
        return GROWTH * (at.columns["temperature"] - 20.0)[:, None, None] * lengths

    return make_cell(
        Flaws(geometry=growth), seed=seed, poses_per_plane=50, points_per_scan=20, columns=warming
    ).dataset


@pytest.mark.parametrize("seed", [400, *(pytest.param(s, marks=pytest.mark.slow) for s in range(401, 406))])
def test_the_temperature_is_named(seed):
    """A growth with the temperature is not called a warm-up by the clock: that would hold for this campaign alone, and be wrong in any other."""
    dataset = growing(seed)
    model, prepared = geometry_fit(dataset, effects_follow=True)
    before = refit(dataset, model, prepared.free, ())
    found = select_forward(before, named_candidates(dataset))
    assert [effect.title for effect in found.effects] == ["thermal drift with temperature"]
