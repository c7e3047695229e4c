"""What a model lacks correlates the residuals of similar poses: priors then weigh more, and noise alone changes nothing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from scalar.estimation import data_sheet_priors
from scalar.estimation.calibrate import calibrate
from scalar.estimation.design_effect import design_effect, similar_poses, standstills
from scalar.estimation.geometry_fit import geometry_fit
from scalar.estimation.joint_fit import fit_all
from scalar.estimation.model import Model
from scalar.estimation.prepare import prepare
from scalar.sensors.tracker_frames import TrackerFrames
from tests.effects.injected import Flaws, make_cell, on_joint
from tests.estimation.test_data_sheet_priors import base_and_tool, elsewhere, rms, workcell


def wide_grid() -> np.ndarray:
    """Return a grid in q2 and q3 of which every joint moves by 10 degrees at each point, as campaigns of local calibration have it."""
    rng = np.random.default_rng(5)
    corners = [(a, b) for a in np.linspace(-0.9, 0.5, 6) for b in np.linspace(0.3, 1.7, 6)]
    rows = [
        [0.0, a, b, 0.0, 0.3, 0.0] + 0.17 * rng.uniform(-1, 1, 6) * [1, 0, 0, 1, 1, 1]
        for a, b in corners
        for _ in range(25)
    ]
    return np.array(rows)


def effect_of(dataset) -> float:
    """Return the design effect of a dataset's geometry fit."""
    model, prepared = geometry_fit(dataset)
    residuals = prepared.residuals.reweighted(model)
    ratio = max(residuals.rms(model) / (dataset.sensor.noise * np.sqrt(3)), 1.0)
    return design_effect(residuals, model, prepared.free, ratio)


@pytest.mark.parametrize("seed", range(6))
def test_independent_noise_has_a_design_effect_of_one(seed):
    """The design effect of independent noise is exactly one, so that the priors of a complete model keep their weight."""
    dataset, _ = workcell(seed, elsewhere(np.random.default_rng(seed), 200))
    assert effect_of(dataset) == 1.0


def test_gears_have_a_design_effect():
    """An error of the joints that is a wave over their angles is common to poses with similar angles, so the design effect is above one."""
    dataset, _ = workcell(1, wide_grid(), gear=1e-3)
    assert effect_of(dataset) > 3.0


@pytest.mark.parametrize("seed", range(3))
def test_the_design_effect_improves_predictions_off_a_grid(seed, monkeypatch):
    """A grid shows the gears' errors and little of the geometry; with the design effect the arm's lengths are not bent to fit the gears."""
    dataset, truth = workcell(seed, wide_grid(), gear=3e-4)
    q = elsewhere(np.random.default_rng(100 + seed), 400)

    def error(model: Model) -> float:
        assert isinstance(model.target, TrackerFrames)
        T = model.target.transforms[0]
        points = (model.robot.flange(q) @ model.T_flange_sensor)[:, :3, 3]
        return rms(points @ T[:3, :3].T + T[:3, 3] - truth(q))

    def calibrated() -> float:
        return error(fit_all(dataset, prepare(dataset))[0].model)

    found = calibrated()
    assert found < error(base_and_tool(dataset).model)
    monkeypatch.setattr(data_sheet_priors, "design_effect", lambda *_: 1.0)
    assert found < 0.95 * calibrated()


def test_standard_errors_hold_although_the_model_lacks_an_effect():
    """Parameters from two halves of the poses of an arm with a gear error differ by their standard errors, although both models lack it."""
    errors = []
    for seed in range(8):
        rng = np.random.default_rng([31, seed])
        size, phase, joint = rng.uniform(3e-4, 1e-3), rng.uniform(0, 2 * np.pi), int(rng.integers(2, 6))
        gear = on_joint(joint, lambda at, j=joint - 1, s=size, p=phase: s * np.sin(at.q[:, j] + p))
        dataset = make_cell(Flaws(joints=gear), seed=900 + seed, poses_per_plane=40).dataset
        halves = [calibrate(dataset.subset(np.arange(k, dataset.n_poses, 2))).parameters() for k in (0, 1)]
        for name in dataset.robot.parameter_names:
            one, other = (half[name] for half in halves)
            if one["std"] and other["std"]:
                errors.append((one["value"] - other["value"]) / np.hypot(one["std"], other["std"]))
    assert len(errors) > 100
    assert 0.7 < np.sqrt(np.mean(np.square(errors))) < 1.4  # 1.7 without the design effect
    assert np.mean(np.abs(errors) < 1.96) > 0.85


def test_groups_are_of_similar_poses():
    """Groups are halves along the joint that varies most, and none is smaller than allowed."""
    q = np.random.default_rng(0).uniform(-1, 1, (100, 3)) * [3.0, 1.0, 0.1]
    group = similar_poses(q, 8, 6)
    assert sorted(np.bincount(group)) == [12, 12, 12, 12, 13, 13, 13, 13]
    assert max(np.ptp(q[group == k, 0]) for k in range(8)) < 2.0
    assert len(np.unique(similar_poses(q[:11], 8, 6))) == 1
    assert len(np.unique(similar_poses(np.zeros((50, 3)), 8, 6))) == 1


def read_again(seed: int, times: int, in_rounds: bool):
    """Return a tracked arm that repeats a pose to 1e-4 rad in every joint, each of 60 poses read ``times`` times, and its truth.

    The arm stands still while a pose is read, or it comes back to every pose in rounds.
    """
    rng = np.random.default_rng([seed, 7])
    q = elsewhere(rng, 60)
    stood = q + 1e-4 * rng.standard_normal(q.shape)
    q, stood = (np.repeat(each, times, axis=0) for each in (q, stood))
    if in_rounds:
        stood = q + 1e-4 * rng.standard_normal(q.shape)
    dataset, truth = workcell(seed, stood)
    names = [f"q{j + 1}" for j in range(6)]
    poses = dataset.poses.assign(**{name: q[:, j] for j, name in enumerate(names)}, order=np.arange(len(q)))
    if in_rounds:
        poses["order"] = np.arange(len(q)).reshape(60, times).T.ravel().argsort()
    return replace(dataset, poses=pd.DataFrame(poses)), truth


@pytest.mark.parametrize("seed", range(3))
def test_readings_of_one_standstill_count_as_about_one(seed):
    """Four readings with a common error that is far above the noise of each determine what one does; four returns determine more."""
    still, rounds = (calibrate(read_again(seed, 4, in_rounds)[0]).summary for in_rounds in (False, True))
    assert 2.5 < still["design_effect"] < 5.5
    assert rounds["design_effect"] == 1.0


def test_rows_share_a_standstill_only_if_they_follow_one_another():
    """A pose to which the arm came back is another standstill, in whatever order the rows stand in the file."""
    q = np.array([[0.0], [1.0], [1.0], [0.0], [0.0]])
    assert standstills(q, np.arange(5.0)).tolist() == [0, 1, 1, 2, 2]
    assert standstills(q, np.array([0.0, 1.0, 4.0, 2.0, 3.0])).tolist() == [0, 1, 3, 2, 2]
