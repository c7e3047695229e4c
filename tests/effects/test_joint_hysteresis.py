"""Hysteresis of a joint: on which records it is tried, what a calibration makes of it, and that its predictions follow the order of the poses."""

import json
from dataclasses import replace

import numpy as np
import pytest

from scalar.effects.command_line import parse_effects
from scalar.effects.joint_hysteresis import JointHysteresis
from scalar.effects.saving import effect_from_mapping, effect_to_mapping
from scalar.estimation.calibrate import calibrate
from tests.tracked_moves import tracked

WIDTH, TRAVEL = 3e-4, 0.2  # rad


def wound_up(angle):
    """Return the wind-up by the differential equation of Dahl's friction, in small steps along each move."""
    found, w = [0.0], 0.0
    for move in np.diff(angle):
        for _ in range(4000):
            w += (np.sign(move) - w) * abs(move) / 4000 / TRAVEL
        found.append(w)
    return np.array(found)


@pytest.fixture(scope="module")
def fitted():
    """Return the calibration of a tracked arm, almost without noise, of which joint 2 is wound up, with the effect freed; and its dataset."""
    dataset = tracked(lambda q: WIDTH * wound_up(q), joint=2, seed=5, noise=1e-8)
    effect = JointHysteresis(2, (TRAVEL,))
    return calibrate(dataset, effects=(effect,)), dataset


def test_the_width_of_the_hysteresis_is_found(fitted):
    """The columns solve the differential equation: the residual is that of its integration, and the injected width is found."""
    calibration, _ = fitted
    assert calibration.residual_rms < 2e-6
    assert calibration.model.effects[0].coefficients[0] == pytest.approx(WIDTH, rel=0.02)


def test_predictions_reproduce_the_fit(fitted):
    """After saving and reading, predictions for the measured poses in their order are the fitted positions.

    Without an order the effect does not act.
    """
    calibration, dataset = fitted
    model = calibration.model
    saved = json.loads(json.dumps(effect_to_mapping(model.effects[0], [None])))
    read = replace(calibration, model=replace(model, effects=(effect_from_mapping(saved),)))
    p = read.predict(dataset.poses)[:, :3, 3]
    measured = dataset.points
    a, b = p - p.mean(axis=0), measured - measured.mean(axis=0)
    U, _, Vt = np.linalg.svd(a.T @ b)
    R = U @ np.diag([1.0, 1.0, np.linalg.det(U @ Vt)]) @ Vt
    left = np.sqrt(np.mean(np.sum((a @ R - b) ** 2, axis=1)))
    assert left <= np.sqrt(3.0) * calibration.residual_rms * 1.001
    rigid = replace(calibration, model=replace(model, effects=()))
    q = dataset.q[:10]
    np.testing.assert_allclose(read.predict(q), rigid.predict(q), rtol=0, atol=1e-14)


def joints(dataset):
    """Return the joints for which hysteresis is tried."""
    return {effect.joint for effect in JointHysteresis.candidates(dataset)}


def test_it_is_tried_only_where_the_order_is_recorded_and_moves_are_direct():
    """Hysteresis is no candidate without an order or a time, nor for a joint whose direction of approach is recorded."""
    dataset = tracked(np.zeros_like, joint=2, seed=5)
    assert joints(dataset) == {1, 2, 3, 4, 5, 6}
    assert not joints(replace(dataset, poses=dataset.poses.drop(columns=["order"])))
    approach = np.where(np.arange(dataset.n_poses) % 2, 1.0, -1.0)
    assert joints(replace(dataset, poses=dataset.poses.assign(approach3=approach))) == {1, 2, 4, 5, 6}


def test_moves_that_are_all_long_leave_it_to_backlash():
    """If a joint moves by half a radian or more each time, a wind-up over a degree cannot be seen and is no candidate."""
    dataset = tracked(np.zeros_like, joint=2, seed=5, shortest=0.5)
    assert not {travel for e in JointHysteresis.candidates(dataset) for travel in e.travels} & {0.02, 0.06}


def test_the_effect_can_be_freed_by_its_joint():
    """The effect can be freed by its joint, even where a diagnosis would not try it."""
    dataset = tracked(np.zeros_like, joint=2, seed=5)
    (effect,) = parse_effects("joint_hysteresis:4", dataset)
    assert effect.target == {"joint": 4}
    assert len(parse_effects("joint_hysteresis", dataset)) == 6
