"""Positions that a controller computed from the joint angles are said to be that: they leave too little, or what the data sheet leaves."""

from __future__ import annotations

import warnings
from dataclasses import replace

import numpy as np
import pytest

from scalar.cli.diagnosis_words import describe_diagnosis
from scalar.diagnosis.diagnose import diagnose
from scalar.estimation.calibrate import calibrate
from scalar.report.unstated_noise import unstated_noise_in_words
from scalar.units import MM
from tests.kinematics import random_transform
from tests.random_scene import make_scene


def said_of(scatter, noise, poses=75):
    """Return what is suspected of the nominal positions of an arm that scatter by so much [mm]; ``noise`` is what the dataset states [mm]."""
    dataset = make_scene("vs060", "tracker", poses_per_plane=25, noise=1e-4, seed=7).dataset.subset(
        np.arange(poses)
    )
    T = dataset.sensor.T_flange_sensor
    points = (dataset.robot.flange(dataset.q) @ T)[:, :3, 3]
    points = points + np.random.default_rng(4).normal(0.0, scatter * MM, points.shape)
    sensor = replace(dataset.sensor, noise=None if noise is None else noise * MM)
    summary = calibrate(replace(dataset, points=points, sensor=sensor)).summary
    return [s["sentence"] for s in summary["setup"] if s["what"] == "computed"]


@pytest.mark.parametrize("noise", [None, 0.05])
def test_positions_without_any_scatter_are_said_to_be_computed(noise):
    """Half a micrometre is less than any tracker scatters, whatever noise is stated."""
    (sentence,) = said_of(0.0005, noise)
    assert "computed from the joint angles" in sentence and "points.csv" in sentence


@pytest.mark.parametrize("scatter", [0.005, 0.015])
def test_positions_that_scatter_about_the_data_sheet_are_said_to_be_computed(scatter):
    """As where they are logged a moment after the angles, or rounded: no arm is as its data sheet has it."""
    (sentence,) = said_of(scatter, 0.03)
    assert "the data sheet of the arm" in sentence and "computed from the joint angles" in sentence


def test_positions_that_were_rounded_in_a_frame_of_the_user_are_said_to_be_computed():
    """A controller states positions in the frame that is chosen, with two decimals of a millimetre."""
    dataset = make_scene("vs060", "tracker", poses_per_plane=25, noise=1e-4, seed=7).dataset
    points = (dataset.robot.flange(dataset.q) @ dataset.sensor.T_flange_sensor)[:, :3, 3]
    frame = random_transform(np.random.default_rng(3), 1.0, 1.0)
    points = np.round(points @ frame[:3, :3].T + frame[:3, 3], 5)
    stated = replace(dataset, points=points, sensor=replace(dataset.sensor, noise=3e-5))
    (sentence,) = [s["sentence"] for s in calibrate(stated).summary["setup"] if s["what"] == "computed"]
    assert "one turned against it" in sentence


@pytest.mark.parametrize(
    ("scatter", "noise", "poses"), [(0.0005, 0.0005, 10), (0.0005, None, 15), (0.04, None, 75)]
)
def test_measured_positions_are_not(scatter, noise, poses):
    """Nothing is said of so few poses that a fit may leave nothing, nor of a scatter that an arm about its data sheet may have."""
    assert not said_of(scatter, noise, poses)


def test_an_exact_tracker_before_an_arm_with_errors_is_not():
    """Five micrometres of scatter are those of an instrument, as long as the data sheet leaves far more."""
    measured = make_scene("vs060", "tracker", poses_per_plane=25, noise=5e-6, seed=7).dataset
    assert "computed" not in [s["what"] for s in calibrate(measured).summary["setup"]]


def test_an_error_that_was_put_into_computed_positions_does_not_hide_them():
    """A simulation of a wrong gear leaves a residual without effects, and none that an instrument would leave with them."""
    dataset = make_scene("vs060", "tracker", poses_per_plane=25, noise=1e-4, seed=7).dataset
    points = (dataset.robot.flange(dataset.q) @ dataset.sensor.T_flange_sensor)[:, :3, 3]
    poses = dataset.poses.assign(q3=dataset.poses["q3"] + 1e-3 * np.sin(2 * dataset.poses["q3"]))
    simulated = replace(dataset, points=points, poses=poses, sensor=replace(dataset.sensor, noise=None))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        answer = diagnose(simulated)
    assert [s["what"] for s in answer.setup].count("computed") == 1
    assert "no instrument measures so exactly" in describe_diagnosis(answer)
    assert "computed" not in [s["what"] for s in answer.calibration_before.summary["setup"]]


STEP = np.deg2rad(0.1)


def rounded(dataset, points):
    """Return what is suspected of positions ``(N, 3)`` [m] if the joint angles are written in tenths of a degree, and what is said of the noise."""
    names = [f"q{i + 1}" for i in range(dataset.robot.n_joints)]
    poses = dataset.poses.assign(**{name: np.round(dataset.poses[name] / STEP) * STEP for name in names})
    sensor = replace(dataset.sensor, noise=None)
    calibration = calibrate(replace(dataset, poses=poses, points=points, sensor=sensor))
    said = {s["what"]: s["sentence"] for s in calibration.summary["setup"]}
    return said, unstated_noise_in_words(calibration)


def test_displayed_positions_beside_rounded_angles_are_said_to_be_computed():
    """With 0.1 mm and 0.1 degrees, the fit leaves what the rounding of the angles leaves, and so does the data sheet with the tool that was set.

    The residual then says nothing of gears or deflection.
    """
    dataset = make_scene("vs060", "tracker", poses_per_plane=40, noise=1e-4, seed=7).dataset
    tool = dataset.sensor.T_flange_sensor
    points = np.round((dataset.robot.flange(dataset.q) @ tool)[:, :3, 3] / (0.1 * MM)) * 0.1 * MM
    said, noise = rounded(dataset, points)
    assert "computed from the joint angles" in said["computed"] and "as well as the fit" in said["computed"]
    assert "rounded_angles" in said and not noise


def test_a_real_arm_in_the_frame_of_its_base_is_not():
    """Measured points that were moved onto those of the nominal arm as well as they go still show that the arm is not its data sheet."""
    dataset = make_scene("vs060", "tracker", poses_per_plane=40, noise=1e-4, seed=7).dataset
    nominal = (dataset.robot.flange(dataset.q) @ dataset.sensor.T_flange_sensor)[:, :3, 3]
    a, b = dataset.points - dataset.points.mean(axis=0), nominal - nominal.mean(axis=0)
    U, _, Vt = np.linalg.svd(a.T @ b)
    moved = a @ (U @ np.diag([1, 1, np.linalg.det(U @ Vt)]) @ Vt) + nominal.mean(axis=0)
    said, noise = rounded(dataset, moved)
    assert "rounded_angles" in said and "computed" not in said and noise
