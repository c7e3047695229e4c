"""The measurements of a scene: exact without noise, and with the declared noise."""

import numpy as np

from scalar.simulation import simulate
from scalar.units import DEG
from tests.simulation.conftest import scene_config
from tests.simulation.geometry import fan_hits, sensor_frames
from tests.simulation.noise_checks import assert_standard_normal, noise, ranges_of


def test_noise_free_points_lie_on_their_planes(paper):
    """Without noise, every point satisfies n . p = d by kinematics that is not pybullet's."""
    assert "noise" not in paper.dataset["sensor"]
    for k, T in enumerate(sensor_frames(paper.workcell.arm, paper.q)):
        target_plane = paper.workcell.target_planes[paper.plane_index[k]]
        points = T[:3, 3] + paper.points[k, :, :1] * T[:3, 0] + paper.points[k, :, 1:] * T[:3, 2]
        np.testing.assert_allclose(points @ target_plane.normal, target_plane.distance, atol=1e-14, rtol=0)


def test_noise_free_points_are_where_their_rays_end(paper):
    """Points are spread evenly over the fan, each at the range of the analytic hit."""
    fan = np.linspace(-15 * DEG, 15 * DEG, paper.config["sensor"]["points_per_scan"])
    measured = np.arctan2(paper.points[..., 0], paper.points[..., 1])
    np.testing.assert_allclose(measured, np.tile(fan, (36, 1)), atol=1e-14)
    for k, T in enumerate(sensor_frames(paper.workcell.arm, paper.q)):
        target_plane = paper.workcell.target_planes[paper.plane_index[k]]
        expected, _, _ = fan_hits(T, fan, target_plane.normal, target_plane.distance)
        np.testing.assert_allclose(ranges_of(paper)[k], expected, atol=1e-14, rtol=0)


def test_range_noise_has_the_declared_spread():
    """Range errors are independent Gaussian of the declared standard deviation, along the ray."""
    scene = simulate(scene_config("paper", noise=noise(range_noise_std_m=2e-4)))
    assert_standard_normal((ranges_of(scene) - scene.ranges) / 2e-4)
    np.testing.assert_allclose(
        np.arctan2(scene.points[..., 0], scene.points[..., 1]), scene.angles, atol=1e-14
    )
    assert scene.dataset["sensor"]["noise"] == 2e-4


def test_noise_along_z_leaves_x_alone(paper):
    """With error_axis z, as a triangulating profiler has it, x is exact and z carries the noise."""
    config = scene_config("paper", noise=noise(range_noise_std_m=2e-4))
    config["sensor"] |= {"error_axis": "z", "selection": "even"}
    scene = simulate(config)
    np.testing.assert_array_equal(scene.points[..., 0], paper.points[..., 0])
    assert_standard_normal((scene.points[..., 1] - paper.points[..., 1]) / 2e-4)


def test_scan_bias_is_common_to_a_scan():
    """A scan's bias shifts all its ranges alike, with the declared spread from scan to scan."""
    scene = simulate(scene_config("paper", poses_per_plane=60, noise=noise(scan_bias_std_m=3e-4)))
    error = ranges_of(scene) - scene.ranges
    np.testing.assert_allclose(error, np.broadcast_to(error[:, :1], error.shape), atol=1e-14, rtol=0)
    assert_standard_normal(error[:, 0] / 3e-4)


def test_joint_noise_moves_the_arm_and_not_the_encoders(paper):
    """With joint noise the dataset's q stays, and the arm stands elsewhere."""
    scene = simulate(scene_config("paper", poses_per_plane=60, noise=noise(joint_noise_std_rad=1e-4)))
    assert_standard_normal((scene.q_true - scene.q) / 1e-4)
    np.testing.assert_allclose(
        scene.T_base_sensor, sensor_frames(scene.workcell.arm, scene.q_true), atol=1e-13, rtol=0
    )
    np.testing.assert_array_equal(scene.poses[[f"q{i + 1}" for i in range(6)]].to_numpy(), scene.q)


def test_ranges_are_rounded_to_their_quantum(paper):
    """A quantum rounds each range to the nearest multiple, after the noise."""
    config = scene_config("paper", noise=noise(range_quantum_m=5e-5))
    config["sensor"]["selection"] = "even"
    steps = ranges_of(simulate(config)) / 5e-5
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-9)
    np.testing.assert_allclose(steps, paper.ranges / 5e-5, atol=0.5 + 1e-9)
