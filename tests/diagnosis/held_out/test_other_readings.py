"""Poses that were measured several times: a wrong measurement is told by the others of its pose, whatever the model lacks there."""

from dataclasses import replace

import numpy as np
import pytest

from scalar.diagnosis import cleaning, diagnose
from scalar.diagnosis.fit.fitted_state import refit
from scalar.diagnosis.fit.measured_rows import rows_given_own_noise
from scalar.diagnosis.held_out.repetitions import distances_from_other_readings
from scalar.diagnosis.settings import DEFAULTS
from scalar.estimation.geometry_fit import geometry_fit
from scalar.units import MM
from tests.diagnosis.tracked_arm import LIMITS
from tests.estimation.test_data_sheet_priors import NOISE, workcell

WRONG = 47
BY = 1.4 * MM
POSES, TIMES = 20, 5
GEAR = 1e-3  # rad


def measured(times=TIMES):
    """Return a tracked arm with worn gears, its poses measured in several rounds, and the same with one measurement that is off."""
    rng = np.random.default_rng(11)
    poses = np.tile(rng.uniform(-1, 1, (POSES, 6)) * LIMITS, (TIMES, 1))
    poses += 1e-5 * rng.standard_normal(poses.shape)
    direction = rng.standard_normal(3)
    dataset = workcell(1, poses, gear=GEAR)[0].subset(np.arange(len(poses)) < times * POSES)
    points = dataset.points.copy()
    points[min(WRONG, len(points) - 1)] += BY * direction / np.linalg.norm(direction)
    return dataset, replace(dataset, points=points)


def fitted(dataset):
    """Return the fit of all measurements without effects."""
    model, prepared = geometry_fit(dataset, DEFAULTS.estimation, effects_follow=True)
    rows = rows_given_own_noise(dataset, model, DEFAULTS.estimation.within_scan_noise)
    return refit(dataset, model, prepared.free, (), DEFAULTS, rows)


def test_a_wrong_measurement_is_set_aside_where_the_model_lacks_much():
    """Gears of all joints are worn, so that many poses are off; the one that differs from its own repetitions is wrong."""
    right, wrong = measured()
    assert diagnose(right).cleaned.outlier_poses == ()
    assert diagnose(wrong).cleaned.outlier_poses == (WRONG,)


def test_it_is_not_found_by_its_distance_from_the_fit_alone(monkeypatch):
    monkeypatch.setattr(cleaning, "distances_from_other_readings", lambda _: None)
    assert diagnose(measured()[1]).cleaned.outlier_poses == ()


def test_distances_hold_no_error_of_the_model():
    """Gears leave much at the poses; the measurements of each differ by their noise alone, and one by what it is off."""
    right, wrong = (fitted(dataset) for dataset in measured())
    distances = distances_from_other_readings(right)
    assert np.median(right.residuals.pose_distances(right.model)) > 2 * np.median(distances)
    assert 0.5 * NOISE < np.median(distances) < 2 * NOISE
    off = distances_from_other_readings(wrong)
    assert np.argmax(off) == WRONG and off[WRONG] == pytest.approx(BY, rel=0.15)


def test_two_measurements_of_a_pose_cannot_tell_which_is_wrong():
    assert distances_from_other_readings(fitted(measured(times=2)[1])) is None


def test_poses_measured_once_are_as_far_off_as_the_others_usually():
    dataset = measured()[0]
    # Of the first pose only the first measurement is left.
    left = np.delete(np.arange(dataset.n_poses), np.arange(POSES, dataset.n_poses, POSES))
    distances = distances_from_other_readings(fitted(dataset.subset(left)))
    assert distances[0] == pytest.approx(np.median(distances[1:]))


def test_play_is_no_gross_error():
    """One measurement in five from the other side of a joint's play: too many of them are off to be gross errors."""
    dataset = measured()[0]
    shifted = dataset.points + 0.5 * MM * (np.arange(dataset.n_poses) % TIMES == 0)[:, None]
    assert diagnose(replace(dataset, points=shifted)).cleaned.outlier_poses == ()
