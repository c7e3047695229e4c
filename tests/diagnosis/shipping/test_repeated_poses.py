"""Poses that were measured several times: what the model lacks repeats with them, so that they count as one pose where a correction is judged."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from scalar.diagnosis.fit.fitted_state import FittedState, refit
from scalar.diagnosis.held_out.repetitions import distinct_equations, distinct_poses
from scalar.diagnosis.shipping.doubtful_effects import equations_per_parameter
from scalar.diagnosis.shipping.jackknife import Linearised, poses_by_repetitions
from scalar.diagnosis.shipping.nested_models import NestedModels
from scalar.effects.joint_harmonic import JointHarmonic
from scalar.estimation.geometry_fit import geometry_fit
from tests.random_scene import make_scene

ROUNDS = 3
POSES = 45


def measured(times: int, noise: float = 1e-5) -> FittedState:
    """Return the fit of an arm whose joint 3 errs, measured so often at each pose, each time with noise of its own."""
    scene = make_scene("vs060", "tracker", poses_per_plane=POSES // 3, noise=1e-4, seed=31)
    dataset = scene.dataset.subset(np.repeat(np.arange(POSES), times))
    rng = np.random.default_rng(32)
    rows = np.arange(len(dataset.points))
    poses = dataset.poses.assign(
        pose=rows, order=rows, q3=dataset.poses["q3"] + 2e-4 * np.sin(9 * dataset.poses["q3"])
    )
    again = replace(dataset, poses=poses, points=dataset.points + noise * rng.standard_normal((len(rows), 3)))
    model, prepared = geometry_fit(again)
    return refit(again, model, prepared.free, (JointHarmonic(3, (8,)),))


@pytest.fixture(scope="module")
def repeated() -> FittedState:
    return measured(ROUNDS)


@pytest.mark.parametrize(
    ("first", "groups"),
    [
        ([0, 1, 2], [[[0], [1], [2]]]),
        ([0, 1, 0, 3, 1, 0], [[[3]], [[1, 4]], [[0, 2, 5]]]),
        ([0, 0, 2, 2], [[[0, 1], [2, 3]]]),
    ],
)
def test_poses_are_grouped_by_how_often_they_were_measured(first, groups):
    """Every row stands in one group, those of one pose together."""
    assert [rows.tolist() for rows in poses_by_repetitions(np.array(first))] == groups


def test_repetitions_of_a_pose_are_left_out_together(repeated):
    """The step without a pose is that of least squares on the rows of all other poses."""
    linear = Linearised(repeated, None)
    residual, J = repeated.linearised()
    J = J / linear.scale
    m, rounds = repeated.residuals.measurement.rows_per_pose, np.arange(ROUNDS)[:, None]
    step, left_out = linear.fitted(np.ones(J.shape[1], dtype=bool))
    assert len(left_out) == POSES
    for pose in (0, 20):
        out = ((rounds + pose * ROUNDS) * m + np.arange(m)).ravel()
        rest = np.delete(np.arange(len(residual)), out)
        without = np.linalg.lstsq(J[rest], -residual[rest], rcond=None)[0]
        np.testing.assert_allclose(left_out[pose], without - step, rtol=1e-5, atol=1e-9)


def test_repetitions_add_no_equations_by_which_a_correction_is_judged(repeated):
    """Three readings of each pose give as many equations for each parameter as one, and as much evidence for a doubtful effect, but for the noise."""
    once = measured(1)
    assert distinct_poses(repeated).sum() == POSES and distinct_poses(repeated)[::ROUNDS].all()
    assert distinct_equations(repeated) == distinct_equations(once) == 3 * POSES
    assert equations_per_parameter(repeated) == equations_per_parameter(once)
    f_repeated, f_once = (NestedModels(state).f_statistic((0,), (0,)) for state in (repeated, once))
    assert f_repeated == pytest.approx(f_once, rel=0.1)


def test_repetitions_make_predictions_hardly_surer(repeated):
    """What the model lacks at a pose is the same each time: the standard errors of predictions are those of one reading."""
    errors = [
        np.sqrt(np.mean((linear.fitted(np.ones(len(linear.scale), dtype=bool))[1] @ linear.columns.T) ** 2))
        for linear in (Linearised(state, None) for state in (repeated, measured(1)))
    ]
    assert errors[0] == pytest.approx(errors[1], rel=0.1)
