"""Errors where nothing was measured: halves of the poses, each predicted by the same model fitted to the other half."""

import numpy as np
import pytest

from scalar.diagnosis.accuracy.stated_errors import where_unmeasured
from scalar.diagnosis.fit.fitted_state import FittedState, refit
from scalar.diagnosis.held_out.halves_left_out import halves_left_out
from scalar.diagnosis.held_out.hold_out import held_out_errors
from scalar.estimation.geometry_fit import geometry_fit
from scalar.estimation.residuals import Residuals
from tests.effects.injected import Flaws, make_cell, on_joint
from tests.random_scene import make_scene

POSES = 60  # of each plane


def fitted(dataset) -> FittedState:
    model, prepared = geometry_fit(dataset)
    return refit(dataset, model, prepared.free, ())


def cell(flaws: Flaws, seed: int):
    return make_cell(flaws, seed=seed, points_per_scan=20, poses_per_plane=POSES).dataset


def bent(q: np.ndarray) -> np.ndarray:
    """Return an error of joint 2 that no effect explains and that grows towards the ends of its range [rad], ``(N,)``."""
    return 2e-3 * np.sin(1.3 * q[:, 1]) ** 3


@pytest.fixture(scope="module")
def complete() -> FittedState:
    return fitted(cell(Flaws(), 11))


def test_each_half_is_predicted_by_a_fit_without_it(complete):
    """A half along a joint, and the earlier half, are predicted as by least squares on the rows of the other poses."""
    halves = {(half.along, half.upper): half for half in halves_left_out(complete)}
    q, m = complete.dataset.q, complete.residuals.measurement.rows_per_pose
    later = np.arange(len(q)) >= len(q) // 2
    residual, J = complete.linearised()
    for key, out in ((("q3", True), q[:, 2] > np.median(q[:, 2])), (("order", False), ~later)):
        rows = np.repeat(out, m)
        step = np.zeros(len(complete.free))
        step[complete.free] = np.linalg.lstsq(J[~rows], -residual[~rows], rcond=None)[0]
        moved = complete.model.with_vector(complete.model.vector + step)
        squares, counts = Residuals.of(complete.dataset, moved).squared_distances(moved)
        assert halves[key].poses == out.sum()
        assert halves[key].rms == pytest.approx(np.sqrt(squares[out].sum() / counts[out].sum()), rel=0.02)


def test_a_complete_model_errs_elsewhere_as_at_the_measured_poses():
    """Nothing is lacking in 300 tracked poses: the worst of some twenty halves errs by hardly more than the held-out poses."""
    state = fitted(make_scene(kind="tracker", seed=5, poses_per_plane=100).dataset)
    halves, held_out = halves_left_out(state), held_out_errors(state).rms
    assert 16 <= len(halves) <= 20
    assert halves[-1].rms > 0.9 * held_out
    assert halves[0].rms < 1.15 * held_out


def test_what_a_complete_model_errs_by_in_a_half_is_chance(complete):
    """The scans of 90 poses determine the model so badly that halves err by more than the noise; that is the chance error that is expected."""
    held_out = held_out_errors(complete).rms
    halves = halves_left_out(complete)
    assert halves[0].rms > 1.5 * held_out
    for half in halves:
        assert half.rms < 1.4 * np.hypot(half.chance, held_out)


@pytest.mark.parametrize("seed", [3, 4])
def test_what_a_model_lacks_shows_where_nothing_was_measured(seed):
    """An arm calibrated where joint 2 has small angles errs elsewhere by more than is stated for held-out poses, and by no more than is stated for
    poses where nothing was measured; chance explains little of the latter.
    """
    whole = cell(Flaws(joints=on_joint(2, lambda at: bent(at.q))), seed)
    upper = whole.q[:, 1] > np.median(whole.q[:, 1])
    state = fitted(whole.subset(~upper))
    squares, counts = Residuals.of(whole, state.model).squared_distances(state.model)
    found = float(np.sqrt(squares[upper].sum() / counts[upper].sum()))
    held_out = held_out_errors(state).rms
    entry = where_unmeasured(state, state, [1e3 * held_out])
    assert entry is not None
    assert found > 1.5 * held_out
    assert found < 1e-3 * entry["rms_mm"] < 5 * found
    worst = entry["worst_half"]
    assert entry["median_rms_mm"] < 0.8 * worst["rms_mm"]
    assert 1e-3 * worst["rms_mm"] > 1.8 * np.hypot(1e-3 * worst["chance_rms_mm"], held_out)


def test_few_poses_have_no_halves(complete):
    """Halves that have fewer equations than the model has parameters say nothing of it."""
    few = complete.dataset.subset(np.arange(complete.dataset.n_poses) % 11 == 0)
    state = refit(few, complete.model, complete.geometry_free, ())
    assert few.n_poses >= 12
    assert not halves_left_out(state)
    assert where_unmeasured(state, state, [0.1]) is None


@pytest.mark.parametrize("stated", [[9.0, None, 3.0], [0.1, None, 9.0]])
def test_the_error_elsewhere_is_no_smaller_than_others_that_are_stated(complete, stated):
    """If the error stated for measured poses, or that over the joint limits, is larger than that of the worst half, it is stated instead."""
    entry = where_unmeasured(complete, complete, stated)
    assert entry is not None and entry["rms_mm"] == 9.0
    assert entry["worst_half"]["rms_mm"] < 9.0
