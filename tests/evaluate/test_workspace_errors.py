"""Errors over the workspace: motions of base and sensor are removed, and the band holds the truth as often as it says."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.optimize import least_squares

from scalar.data.poses import Poses
from scalar.estimation.calibrate import calibrate
from scalar.estimation.random_poses import limits_or_measured_ranges, poses_within_limits
from scalar.estimation.result import Calibration
from scalar.evaluate.model_discrepancy import ModelDiscrepancy
from scalar.evaluate.workspace_errors import (
    aligned_errors,
    mean_over_poses,
    rms_over_poses,
    workspace_errors,
)
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import exp_so3, transform_from_rotation_vector
from tests.calibrated_arms import calibrated
from tests.random_scene import make_scene
from tests.robot_configs import robot_mapping

ROBOT = Robot.from_mapping(robot_mapping("vs060"))


def frames(robot: Robot, count: int = 200) -> np.ndarray:
    """Return flange frames at random poses."""
    rng = np.random.default_rng(5)
    return robot.flange(rng.uniform(robot.limits[:, 0], robot.limits[:, 1], (count, robot.n_joints)))


def with_covariance(calibration: Calibration, size: float) -> Calibration:
    """Return a calibration whose lengths and angles are uncertain, and correlated."""
    free = tuple(n for n in calibration.model.names if n.split("_")[0] in ("a", "d", "alpha", "theta"))
    root = size * np.random.default_rng(8).normal(size=(len(free), len(free))) / np.sqrt(len(free))
    return replace(calibration, free=free, covariance=root @ root.T)


def test_motions_of_base_and_sensor_are_removed():
    """A base that is moved by centimetres and degrees and a sensor that sits elsewhere are no error of the arm."""
    T = frames(ROBOT)
    moved = transform_from_rotation_vector([0.02, -0.01, 0.03], [0.02, 0.03, -0.01]) @ T
    moved = moved @ transform_from_rotation_vector([0.004, 0.01, -0.003], [0.0, 0.0, 0.0])
    assert np.abs(aligned_errors(moved, T)).max() < 1e-12


def test_the_alignment_is_the_best_one():
    """The errors are those of a general solver over nine numbers: turn and shift of the base, shift of the sensor."""
    T = frames(ROBOT)
    other = frames(calibrated(ROBOT, np.random.default_rng(1)).model.robot)

    def left(x: np.ndarray) -> np.ndarray:
        points = other[:, :3, 3] + other[:, :3, :3] @ x[6:]
        return (points @ exp_so3(x[:3]).T + x[3:6] - T[:, :3, 3]).ravel()

    best = least_squares(left, np.zeros(9), xtol=1e-15, ftol=1e-15, gtol=1e-15)
    found = aligned_errors(other, T)
    assert np.sum(found**2) > 1e-7
    np.testing.assert_allclose(found.ravel(), best.fun, atol=1e-9)


def test_the_band_is_that_of_the_parameters():
    """The draws scatter like the mean errors of models drawn from the covariance, each predicted without linearization."""
    rng = np.random.default_rng(3)
    calibration = with_covariance(calibrated(ROBOT, rng), 2e-4)
    poses = Poses(rng.uniform(ROBOT.limits[:, 0], ROBOT.limits[:, 1], (300, 6)), np.zeros(300), {})
    found = workspace_errors(calibration, {"same": calibration.model}, poses)
    assert found is not None
    draws = mean_over_poses(found.sizes("same").found)
    T = calibration.predict(poses.q)
    index = [calibration.model.names.index(name) for name in calibration.free]
    exact = []
    for _ in range(200):
        vector = calibration.model.vector.copy()
        vector[index] += rng.multivariate_normal(np.zeros(len(index)), calibration.covariance)
        other = replace(calibration, model=calibration.model.with_vector(vector))
        exact.append(np.linalg.norm(aligned_errors(other.predict(poses.q), T), axis=1).mean())
    # The scatter of the draws is about a third of their mean, so means of 200 differ by a tenth, three standard errors, only rarely.
    assert abs(np.mean(draws) / np.mean(exact) - 1.0) < 0.1
    assert abs(np.std(draws) / np.std(exact) - 1.0) < 0.3


def test_hidden_effects_raise_the_upper_end_alone():
    """Deviations that the measurements do not show leave number and lower end as they are, and raise the upper end as if they were present."""
    rng = np.random.default_rng(3)
    calibration = with_covariance(calibrated(ROBOT, rng), 2e-4)
    poses = Poses(rng.uniform(ROBOT.limits[:, 0], ROBOT.limits[:, 1], (300, 6)), np.zeros(300), {})
    by_joint = rng.normal(0.0, 3e-4, (3 * len(poses), 4))
    bands = []
    for hidden in (None, lambda _: by_joint):
        lacks = ModelDiscrepancy(hidden=hidden)
        found = workspace_errors(calibration, {"same": calibration.model}, poses, lacks)
        assert found is not None
        bands.append(found.sizes("same").banded(mean_over_poses))
    without, hidden_too = bands
    assert (hidden_too.low, hidden_too.value) == (without.low, without.value)
    assert hidden_too.high > np.hypot(without.value, np.sqrt(3 * 4) * 3e-4 * 0.9)


def test_a_residual_beyond_the_noise_raises_the_upper_end_alone():
    """It may be noise that is larger than stated, so number and lower end do not count it."""
    rng = np.random.default_rng(3)
    calibration = with_covariance(calibrated(ROBOT, rng), 2e-4)
    poses = Poses(rng.uniform(ROBOT.limits[:, 0], ROBOT.limits[:, 1], (300, 6)), np.zeros(300), {})
    bands = []
    for excess in (0.0, 1e-3):
        lacks = ModelDiscrepancy(excess)
        found = workspace_errors(calibration, {"same": calibration.model}, poses, lacks)
        assert found is not None
        bands.append(found.sizes("same").banded(rms_over_poses))
    without, beyond = bands
    assert (beyond.low, beyond.value) == (without.low, without.value)
    assert np.hypot(without.high, 1e-3) * 0.9 < beyond.high < np.hypot(without.high, 1e-3) * 1.1


def test_effects_that_may_be_lacking_count_in_every_figure():
    """Draws of displacements that differ from pose to pose add to the squares of the chance errors, in the number and in both ends."""
    rng = np.random.default_rng(3)
    calibration = with_covariance(calibrated(ROBOT, rng), 2e-4)
    poses = Poses(rng.uniform(ROBOT.limits[:, 0], ROBOT.limits[:, 1], (300, 6)), np.zeros(300), {})

    def independent(at: Poses, count: int, seed: int) -> np.ndarray:
        return 2e-3 / np.sqrt(3) * np.random.default_rng(seed).standard_normal((3 * len(at), count))

    bands = []
    for possible in (None, independent):
        lacks = ModelDiscrepancy(possible=possible)
        found = workspace_errors(calibration, {"same": calibration.model}, poses, lacks)
        assert found is not None
        bands.append(found.sizes("same").banded(rms_over_poses))
    without, counted = bands
    for name in ("low", "value", "high"):
        expected = np.hypot(getattr(without, name), 2e-3)
        assert abs(getattr(counted, name) / expected - 1.0) < 0.05


def test_a_shift_of_the_sensor_counts_where_the_tool_is_the_calibrations_own():
    """A sensor whose place on the flange is uncertain is no error if the tool is fitted anew, and up to its own size if it is not."""
    rng = np.random.default_rng(3)
    calibration = replace(calibrated(ROBOT, rng), free=("sensor_x",), covariance=np.array([[1e-8]]))
    poses = Poses(rng.uniform(ROBOT.limits[:, 0], ROBOT.limits[:, 1], (300, 6)), np.zeros(300), {})
    sizes = []
    for fitted in (True, False):
        found = workspace_errors(calibration, {"same": calibration.model}, poses, sensor_fitted=fitted)
        assert found is not None
        sizes.append(np.sqrt(np.sum(found.deviations**2) / len(poses)))
    assert sizes[0] < 1e-10
    assert 0.5e-4 < sizes[1] <= 1e-4 * (1 + 1e-9)


def test_without_covariance_nothing_is_claimed():
    """A fit whose covariance is not finite gives no errors instead of a band of nothing."""
    calibration = with_covariance(calibrated(ROBOT, np.random.default_rng(3)), 2e-4)
    unknown = replace(calibration, covariance=np.full_like(calibration.covariance, np.inf))
    assert workspace_errors(unknown, {}, Poses(np.zeros((4, 6)), np.zeros(4), {})) is None


def test_the_band_holds_the_truth_as_often_as_it_says():
    """Over campaigns that differ in their noise, the true mean error of the data sheet lies in the band in 95 of 100. That fewer than 34 of
    40 do has a probability of 1 in 300. The deviation of the truth from the band's middle scatters as half a width of 1.96 standard deviations
    says.
    """
    inside, scatter = 0, []
    for seed in range(40):
        scene = make_scene(kind="tracker", seed=seed, poses_per_plane=14, noise=2e-4)
        calibration = calibrate(scene.dataset)
        robot = scene.dataset.robot
        seen = Poses.from_frame(scene.dataset.poses, robot.slides, order_is_row=True)
        poses = poses_within_limits(limits_or_measured_ranges(robot.limits, seen.q), seen, 300, 1)
        nominal = replace(calibration.model, robot=robot)
        found = workspace_errors(calibration, {"data sheet": nominal}, poses)
        assert found is not None
        band = found.sizes("data sheet").banded(mean_over_poses)
        T_nominal = Calibration.nominal(scene.dataset, calibration.model.T_flange_sensor).predict(poses.q)
        true = np.linalg.norm(aligned_errors(T_nominal, scene.truth.sensor(poses.q)), axis=1).mean()
        inside += band.low <= true <= band.high
        scatter.append((true - band.value) / (band.high - band.low) * 2)
    assert inside >= 34
    assert 0.3 < np.std(scatter) * 1.96 < 1.5
