"""Each kind of sensor: a perfect measurement has no residual, and rows are whitened for the noise."""

from dataclasses import replace

import numpy as np
import pytest

from scalar.geometry.planes import Planes
from scalar.sensors import measure
from scalar.sensors.tracker_frames import TrackerFrames
from tests import kinematics
from tests.random_scene import make_scene
from tests.workcell import PLANE_NAMES


def true_target(scene):
    """Return the target at its truth."""
    truth = scene.truth
    if scene.dataset.sensor.kind == "tracker":
        T = truth.T_tracker_base
        coordinates = np.r_[T[:3, 3], kinematics.rotation_vector(T[:3, :3])][None]
        return TrackerFrames(("tracker",), np.eye(3)[None], coordinates)
    return Planes.at(PLANE_NAMES, truth.normals, truth.distances)


@pytest.mark.parametrize("kind", ["line-laser", "probe", "tracker"])
@pytest.mark.parametrize("robot", ["vs060", "panda"])
def test_perfect_measurements_leave_no_residual(robot, kind):
    """At the truth of an independently simulated workcell, every row and every distance is zero to rounding."""
    scene = make_scene(robot, kind, noise=0.0, stated_noise=1.0, poses_per_plane=6, points_per_scan=(1, 20))
    measurement = measure(scene.dataset)
    T = scene.truth.sensor(scene.dataset.q)
    assert np.abs(measurement.rows(T, true_target(scene)).residual).max() < 1e-13
    squares, counts = measurement.distances(T, true_target(scene))
    assert np.sqrt(squares.sum() / counts.sum()) < 1e-14


@pytest.mark.parametrize("kind", ["line-laser", "probe", "tracker"])
def test_the_target_that_fits_best_is_the_true_one(kind):
    """With the sensor's true poses and no noise the closed-form target is the truth, for any initial guess."""
    scene = make_scene(kind=kind, noise=0.0, stated_noise=1e-4, plane_tilt=0.4, plane_offset=0.1)
    measurement = measure(scene.dataset)
    found = measurement.fitted_target(
        scene.truth.sensor(scene.dataset.q), measurement.initial_target(scene.dataset)
    )
    if kind == "tracker":
        np.testing.assert_allclose(found.transforms[0], scene.truth.T_tracker_base, atol=1e-12)
    else:
        np.testing.assert_allclose(found.normals, scene.truth.normals, atol=1e-9)
        np.testing.assert_allclose(found.distances, scene.truth.distances, atol=1e-9)


@pytest.mark.parametrize("error_axis", ["ray", "z"])
def test_rows_of_a_scan_have_unit_variance(error_axis):
    """Whitened at the truth, the rows' sum of squares is chi-squared with one degree of freedom for each point."""
    scene = make_scene(error_axis=error_axis, noise=2e-4, seed=4)
    T, target = scene.truth.sensor(scene.dataset.q), true_target(scene)
    measurement = measure(scene.dataset).reweighted(T, target)
    total, points = np.sum(measurement.rows(T, target).residual ** 2), len(scene.dataset.points)
    assert abs(total - points) < 4.5 * np.sqrt(2 * points)


@pytest.mark.parametrize("error_axis", ["ray", "z"])
def test_the_scatter_within_scans_gives_the_noise(error_axis):
    """A noise that is not stated is estimated from the scatter of scans about their own lines, to its sampling error."""
    scene = make_scene(error_axis=error_axis, noise=2e-4, stated_noise=None, seed=5)
    T, target = scene.truth.sensor(scene.dataset.q), true_target(scene)
    measurement = measure(scene.dataset).reweighted(T, target)
    freedom = len(scene.dataset.points) - 2 * scene.dataset.n_poses
    assert measurement.sigma == pytest.approx(2e-4, rel=4.5 / np.sqrt(2 * freedom))
    scatter, freedoms = measurement.reweighted(T, target).scatter(T, target)
    assert freedoms.sum() == freedom
    assert abs(scatter.sum() - freedom) < 1e-6 * freedom


def test_the_scatter_does_not_depend_on_where_robot_and_target_planes_are():
    """The scatter about a scan's own line is the same at a wrong pose of the target plane, to first order in the
    noise.
    """
    scene = make_scene(noise=1e-4, seed=6)
    T, target = scene.truth.sensor(scene.dataset.q), true_target(scene)
    measurement = measure(scene.dataset).reweighted(T, target)
    moved = replace(target, distances=target.distances + 0.02)
    np.testing.assert_allclose(measurement.scatter(T, moved)[0], measurement.scatter(T, target)[0], rtol=2e-2)


def test_a_scan_may_be_one_point_or_noise_free():
    """Weights and rows are finite for scans of one or two points without noise, whether or not a noise is stated."""
    for stated in (1e-4, None):
        scene = make_scene(noise=0.0, stated_noise=stated, points_per_scan=(1, 2), poses_per_plane=5)
        T, target = scene.truth.sensor(scene.dataset.q), true_target(scene)
        measurement = measure(scene.dataset).reweighted(T, target)
        assert np.isfinite(measurement.R).all()
        assert np.isfinite(measurement.rows(T, target).residual).all()


def test_sessions_have_targets_of_their_own():
    """Each plane is a target of its own in each session in which it is measured."""
    scene = make_scene(poses_per_plane=4, points_per_scan=5)
    poses = scene.dataset.poses.copy()
    poses["session"] = ["a"] * 6 + ["b"] * 6
    measurement = measure(replace(scene.dataset, poses=poses))
    target = measurement.initial_target(replace(scene.dataset, poses=poses))
    assert target.names == ("floor@1", "wall_x@1", "wall_y@1", "floor@2", "wall_x@2", "wall_y@2")
    assert measurement.target_index.tolist() == [0, 1, 2, 0, 1, 2, 3, 4, 5, 3, 4, 5]
