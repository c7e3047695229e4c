"""A zero of the last joint that is far off leaves no residual, and shows only in where the target sits on the flange."""

from dataclasses import replace

import numpy as np
import pytest

from scalar.estimation.calibrate import calibrate
from scalar.units import DEG
from tests.random_scene import make_scene


@pytest.mark.parametrize(("degrees", "is_said"), [(180, True), (30, False)])
def test_a_last_joint_whose_zero_is_half_a_turn_off_shows_in_the_targets_place(degrees, is_said):
    """No residual shows it, and the target's place is taken over; but it then sits on the other side of the last axis. A mount that is drawn thirty
    degrees wrong is not said.
    """
    tracked = make_scene("vs060", "tracker", poses_per_plane=25, noise=1e-4, seed=7).dataset
    T = calibrate(tracked).model.T_flange_sensor.copy()
    T[:2, 3] = 0.05, 0.02  # well off the axis
    q = tracked.q
    frames = tracked.robot.flange(q) @ T
    points = frames[:, :3, 3] + np.random.default_rng(3).normal(0.0, 1e-4, (tracked.n_poses, 3))
    stated = replace(tracked, points=points, sensor=replace(tracked.sensor, T_flange_sensor=T))
    turned = replace(stated, poses=stated.poses.assign(q6=q[:, 5] + degrees * DEG))
    said = [s["sentence"] for s in calibrate(turned).summary["setup"]]
    assert any("on another side" in sentence for sentence in said) == is_said
    assert not calibrate(stated).summary["setup"]
