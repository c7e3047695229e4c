"""Where a posture is free, one is chosen within the ranges of the joints that were measured, where the calibration holds."""

from dataclasses import replace

import numpy as np

from scalar.estimation.correction import postures_for
from scalar.estimation.measured_ranges import clearly_outside
from scalar.robots import read_arm
from tests.calibrated_arms import calibrated

MEASURED = np.array([[-2.0, 2.0], [-2.6, -0.4], [0.4, 2.2], [-2.5, 2.5], [0.4, 2.2], [-2.5, 2.5]])  # rad


def arm():
    """Return a UR whose joints turn twice."""
    robot = replace(read_arm("ur10e").robot, limits=np.tile([-2 * np.pi, 2 * np.pi], (6, 1)))
    return calibrated(robot, np.random.default_rng(6)).model


def frames(model, q):
    """Return the frames of the sensor ``(N, 4, 4)`` at joint angles ``(N, 6)`` [rad]."""
    return model.robot.flange(q) @ model.T_flange_sensor


def test_targets_far_from_each_other_get_postures_within_the_measured_ranges():
    """At most half as many as without the ranges lie outside; each frame came from a posture within."""
    model = arm()
    T = frames(model, np.random.default_rng(7).uniform(*MEASURED.T, (40, 6)))
    outside = [
        clearly_outside(MEASURED, postures_for(model, T, measured=ranges)[0]).any(axis=1).mean()
        for ranges in (None, MEASURED)
    ]
    assert outside[1] < 0.5 * outside[0]


def test_a_path_keeps_its_posture_outside_of_them():
    """Small moves continue the posture of the row before, wherever it lies."""
    model = arm()
    share = np.linspace(0, 1, 30)[:, None]
    path = np.array([0.2, 0.3, 1.0, 0.2, 0.7, 0.1]) + share * np.array([0.6, 0.2, 0.3, -0.3, 0.4, 0.5])
    assert clearly_outside(MEASURED, path).any(axis=1).all()
    found, there = postures_for(model, frames(model, path), first=path[0], measured=MEASURED)
    assert there.all()
    np.testing.assert_allclose(found, path, atol=1e-4)
