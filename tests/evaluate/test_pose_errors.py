"""Errors at random poses agree with cases worked out by hand, and with the tests' own arithmetic."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scalar.estimation.calibrate import calibrate
from scalar.estimation.result import Calibration
from scalar.evaluate import aligned_to, best_rigid_motion, evaluate, pose_errors
from scalar.units import DEG, MM
from tests import kinematics
from tests.kinematics import joint_names
from tests.random_scene import make_scene
from tests.workcell import PLANE_NAMES, Scene

component = st.floats(-3, 3)
vectors = st.tuples(component, component, component).map(np.array)


def true_model(scene: Scene, T_base_0: np.ndarray | None = None) -> Calibration:
    """Return the true workcell as a calibration, its robot moved as a whole by ``T_base_0`` if that is given."""
    robot = replace(scene.dataset.robot, geometry=scene.truth.geometry)
    if T_base_0 is not None:
        robot = replace(robot, T_base_0=T_base_0 @ robot.T_base_0)
    return Calibration.nominal(replace(scene.dataset, robot=robot), scene.truth.T_flange_sensor)


@pytest.fixture(scope="module")
def scene() -> Scene:
    """Return a workcell of the paper's size."""
    return make_scene(seed=11, poses_per_plane=20, points_per_scan=20)


def test_the_truth_has_no_error(scene):
    """A calibration that is the truth is off by rounding, raw and aligned."""
    result = evaluate(true_model(scene), scene.truth.poses(300, np.random.default_rng(0)))
    for errors in (result.raw, result.aligned):
        assert errors.position.max() < 1e-14
        assert errors.orientation.max() < 1e-14


def test_a_moved_base_gives_raw_errors_and_no_aligned_ones(scene):
    """If the base is moved by 3 mm along x, raw errors are 3 mm and no angle at every pose, and aligned errors are zero."""
    moved = true_model(scene, kinematics.translation(0, 3 * MM))
    result = evaluate(moved, scene.truth.poses(300, np.random.default_rng(0)))
    np.testing.assert_allclose(result.raw.position, 3 * MM, atol=1e-14)
    assert result.raw.orientation.max() < 1e-14
    assert result.aligned.position.max() < 1e-13
    assert result.aligned.orientation.max() < 1e-13


def test_a_turned_base_gives_raw_errors_and_no_aligned_ones(scene):
    """If the base is turned by 2 degrees about the vertical, raw position errors are the chords at each pose's radius.

    Raw orientation errors are 2 degrees everywhere, and aligned errors are zero.
    """
    poses = scene.truth.poses(300, np.random.default_rng(0))
    result = evaluate(true_model(scene, kinematics.rotation(2, 2 * DEG)), poses)
    radius = np.hypot(poses["x"], poses["y"])
    np.testing.assert_allclose(result.raw.position, 2 * radius * np.sin(1 * DEG), atol=1e-13)
    np.testing.assert_allclose(result.raw.orientation, 2 * DEG, atol=1e-13)
    assert result.aligned.position.max() < 1e-13
    assert result.aligned.orientation.max() < 1e-13
    mapping = result.to_mapping()
    assert mapping["raw"]["orientation_max_deg"] == pytest.approx(2.0)
    assert mapping["raw"]["position_mean_mm"] == pytest.approx(2e3 * radius.mean() * np.sin(1 * DEG))


def test_errors_agree_with_an_independent_computation(scene):
    """For a nominal arm, equations 17 and 18 give what other code does: the length and the angle of ``T_true^-1 T_hat``."""
    poses = scene.truth.poses(200, np.random.default_rng(1))
    q = poses[joint_names(6)].to_numpy()
    nominal = Calibration.nominal(scene.dataset)
    result = evaluate(nominal, poses).raw
    robot = scene.dataset.robot
    T_hat = kinematics.chain(robot.geometry, q) @ robot.T_n_flange @ scene.dataset.sensor.T_flange_sensor
    difference = np.linalg.inv(scene.truth.sensor(q)) @ T_hat
    cosine = (np.trace(difference[:, :3, :3], axis1=1, axis2=2) - 1) / 2
    np.testing.assert_allclose(result.position, np.linalg.norm(difference[:, :3, 3], axis=1), atol=1e-13)
    np.testing.assert_allclose(result.orientation, np.arccos(cosine), atol=1e-9)


@given(vectors, vectors, st.integers(3, 30), st.integers(0, 2**32 - 1))
def test_the_best_rigid_motion_is_found(translation, turn, count, seed):
    """Points moved rigidly are moved back exactly, and the motion is never a reflection."""
    points = np.random.default_rng(seed).standard_normal((count, 3))
    T = np.eye(4)
    T[:3, 3] = translation
    if np.linalg.norm(turn) > 0:
        T[:3, :3] = kinematics.rotate_about(turn, float(np.linalg.norm(turn)))
    found = best_rigid_motion(points, points @ T[:3, :3].T + T[:3, 3])
    np.testing.assert_allclose(found, T, atol=1e-9)


def test_no_other_motion_aligns_better():
    """With noise, small steps of the base in all six directions make the sum of squared position errors larger."""
    rng = np.random.default_rng(3)
    T_true = np.array([kinematics.random_transform(rng, 1.0, 1.0) for _ in range(50)])
    T_hat = T_true.copy()
    T_hat[:, :3, 3] += 0.01 * rng.standard_normal((50, 3))
    best = aligned_to(T_true, T_hat)
    least = np.sum(pose_errors(T_true, best).position ** 2)
    for axis in range(3):
        for step in (-1e-4, 1e-4):
            for motion in (kinematics.translation(axis, step), kinematics.rotation(axis, step)):
                assert np.sum(pose_errors(T_true, motion @ best).position ** 2) > least


def test_parameters_and_planes_against_their_truth(scene):
    """The table has every parameter of robot and scanner; errors are a few standard errors, and zero for fixed parameters."""
    result = evaluate(
        calibrate(scene.dataset), scene.truth.poses(10, np.random.default_rng(0)), scene.truth.mapping()
    )
    table = result.parameters.set_index("parameter")
    assert list(table.index) == list(scene.truth.parameters())
    free = table[~table["held"]]
    assert np.all(np.abs(free["error"] / free["std"]) < 5.5)
    assert np.abs(table[table["held"]]["error"]).max() == 0.0
    assert result.planes["plane"].tolist() == list(PLANE_NAMES)
    assert result.planes["normal_error_deg"].max() < 0.05
    assert result.planes["distance_error_mm"].abs().max() < 0.5


def test_half_a_turn_of_the_scanner_is_no_error(scene):
    """The paper's scanner is turned by pi, where a rotation vector of either sign is the same rotation: the error is small for both."""
    poses = scene.truth.poses(10, np.random.default_rng(0))
    for sign in (1.0, -1.0):
        nudge = kinematics.rotation(2, sign * 1e-6)
        turned = replace(
            scene, truth=replace(scene.truth, T_flange_sensor=scene.truth.T_flange_sensor @ nudge)
        )
        for other in (1.0, -1.0):
            mapping = scene.truth.mapping()
            mapping["parameters"]["r"] = [0.0, 0.0, other * (np.pi - 1e-7)]
            table = evaluate(true_model(turned), poses, mapping).parameters.set_index("parameter")
            assert table["error"][["sensor_rx", "sensor_ry", "sensor_rz"]].abs().max() < 2e-6


def test_a_plane_of_opposite_sign_is_the_same_plane(scene):
    """A truth that writes (-n, -d) gives the same errors."""
    poses = scene.truth.poses(10, np.random.default_rng(0))
    calibration = calibrate(scene.dataset)
    mapping = scene.truth.mapping()
    one = evaluate(calibration, poses, mapping).planes
    mapping["planes"]["normals"][1] = [-x for x in mapping["planes"]["normals"][1]]
    mapping["planes"]["distances"][1] *= -1
    pd.testing.assert_frame_equal(evaluate(calibration, poses, mapping).planes, one)


def test_a_truth_without_parameters_is_enough(scene):
    """With true poses alone there are errors and predicted standard deviations, and both tables are empty."""
    result = evaluate(calibrate(scene.dataset), scene.truth.poses(50, np.random.default_rng(0)))
    assert result.planes.empty and result.parameters.empty
    assert result.predicted_position_std.shape == (50,)
    assert 0.2 < result.raw.position.mean() / result.predicted_position_std.mean() < 3
