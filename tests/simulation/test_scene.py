"""The simulation of a scene: its plan, its effects, its progress and its picture."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from scalar.simulation import SimulationError, plan_poses, simulate
from scalar.simulation.effects import Effects
from scalar.simulation.render import render_scene
from tests.simulation.conftest import scene_config
from tests.simulation.geometry import fan_hits, sensor_frames
from tests.simulation.noise_checks import noise


def test_a_plan_serves_its_own_workcell_only():
    """A plan is refused for another workcell, and for more poses than it holds."""
    config = scene_config("paper", poses_per_plane=3)
    plan = plan_poses(config)
    with pytest.raises(SimulationError, match="another workcell"):
        simulate(config | {"seed": 2}, plan=plan)
    with pytest.raises(SimulationError, match="fewer poses"):
        simulate(config | {"poses_per_plane": 4}, plan=plan)


def test_a_scan_that_leaves_its_target_plane_is_an_error():
    """If the joints' noise throws rays off the target plane, the pose is named, and nothing is silently dropped."""
    config = scene_config("paper", noise=noise(joint_noise_std_rad=0.3))
    with pytest.raises(
        SimulationError, match=r"pose \d+ on plane \w+: \d+ of 100 rays left the target plane"
    ):
        simulate(config)


@dataclass(frozen=True)
class _Injected(Effects):
    """Turn joint 2 by 1 mrad, shift the sensor by 1 mm from half-way on, lift the target planes by 2 mm at last."""

    def joint_errors(self, world, q, poses):
        return np.tile([0, 1e-3, 0, 0, 0, 0], (len(q), 1))

    def arms(self, arm, poses, evaluating):
        half = 0 if evaluating else len(poses) // 2
        return [(slice(0, half), arm), (slice(half, None), arm.shifted({"t": np.array([1e-3, 0, 0])}))]

    def target_planes(self, target_planes, poses):
        lifted = tuple(
            replace(
                target_plane,
                centre=target_plane.centre + 2e-3 * target_plane.normal,
                distance=target_plane.distance + 2e-3,
            )
            for target_plane in target_planes
        )
        last = np.arange(len(poses)) >= len(poses) - 5
        return [(~last, target_planes), (last, lifted)]


def test_effects_act_where_they_are_injected(paper):
    """Hooks on joints, arm and target planes reach scans and evaluation poses, and do not change which poses."""
    config = scene_config("paper", noise={})
    config["sensor"]["selection"] = "even"
    scene = simulate(config, effects=_Injected())
    np.testing.assert_array_equal(scene.q, paper.q)
    arm, n = scene.workcell.arm, len(scene.q)
    dq = np.array([0, 1e-3, 0, 0, 0, 0])
    turned = scene.q + dq
    slipped = arm.shifted({"t": np.array([1e-3, 0, 0])})
    T = np.concatenate([sensor_frames(arm, turned[: n // 2]), sensor_frames(slipped, turned[n // 2 :])])
    np.testing.assert_allclose(scene.T_base_sensor, T, atol=1e-13, rtol=0)
    for k in range(n):
        target_plane = scene.workcell.target_planes[scene.plane_index[k]]
        lift = 2e-3 if k >= n - 5 else 0.0
        expected, _, _ = fan_hits(T[k], scene.angles[k], target_plane.normal, target_plane.distance + lift)
        np.testing.assert_allclose(scene.ranges[k], expected, atol=1e-13, rtol=0)
    q = scene.truth_poses[[f"q{i + 1}" for i in range(6)]].to_numpy() + dq
    np.testing.assert_allclose(
        scene.truth_poses[["x", "y", "z"]], sensor_frames(slipped, q)[:, :3, 3], atol=1e-12, rtol=0
    )


def test_progress_is_told(paper):
    """The callback hears of every stage, and each stage ends at its full count."""
    heard = {}
    simulate(
        scene_config("paper", poses_per_plane=2), progress=lambda *news: heard.update({news[0]: news[1:]})
    )
    assert heard == {"poses floor": (2, 2), "poses wall_x": (2, 2), "poses wall_y": (2, 2), "scans": (6, 6)}


def test_a_picture_shows_arm_and_laser(paper):
    """The picture has the asked size, the laser's red in it, and more than one other colour."""
    picture = render_scene(paper, 0, width=320, height=240, views=1).image
    assert picture.shape == (240, 320, 3) and picture.dtype == np.uint8
    red = picture[..., 0].astype(int) - picture[..., 1] > 60
    assert 5 < red.sum() < picture[..., 0].size / 4
    white = (picture == 255).all(2)  # the background
    assert white.mean() < 0.5  # most of the picture is target planes and arm
