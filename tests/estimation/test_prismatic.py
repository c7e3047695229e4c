"""Joints that slide, from a dataset to predictions and corrections: an arm on a rail that is simulated without the estimator's formulas."""

import numpy as np
import pytest

from scalar.data.dataset import Dataset
from scalar.data.declared import Sensor
from scalar.data.poses import Poses
from scalar.effects.joint_scale import JointScale
from scalar.estimation.calibrate import calibrate
from scalar.estimation.correction import correct_joints
from scalar.estimation.result import load_calibration
from scalar.estimation.unknown_scale import unknown_scale
from scalar.geometry.robot import Robot
from tests import kinematics
from tests.rail_and_arm import RailAndArm, off_by_a_motion, poses

TO_DIGITS = 1e-9  # m


@pytest.fixture(scope="module")
def exact():
    """Return a workcell and its calibration from 80 poses without noise."""
    rng = np.random.default_rng(1)
    cell = RailAndArm.drawn(rng)
    return cell, calibrate(cell.dataset(poses(80, rng), 0.0, rng))


def test_noise_free_points_give_the_truth_back(exact):
    """At poses that were not measured the tool is where it really is, up to the place of the base frame."""
    cell, calibration = exact
    q = poses(500, np.random.default_rng(2))
    off = off_by_a_motion(calibration.predict(q)[:, :3, 3], cell.tool(q)[:, :3, 3])
    assert off.max() < TO_DIGITS


def test_scans_of_planes_show_a_rail_and_the_scale():
    """Scans without noise give the truth and every length, because the travel is in metres, while angles alone leave the scale open."""
    rng = np.random.default_rng(5)
    cell = RailAndArm.drawn(rng)
    found = calibrate(cell.scans(poses(4000, rng), 40))
    q = poses(300, rng)
    off = off_by_a_motion(found.predict(q)[:, :3, 3], cell.tool(q)[:, :3, 3])
    assert off.max() < 1e-7
    assert "may be scaled" not in " ".join(found.fixed.values())


def test_a_slide_has_two_parameters_less(exact):
    """A chain of R revolute and P prismatic joints has 4 R + 2 P + 6 parameters; a tracker does not see three of the tool.

    One more is fixed between the arm's two parallel axes, where beta would stand.
    """
    _, calibration = exact
    assert len(calibration.free) == 4 * 6 + 2 * 1 + 6 - 3 - 1
    reasons = " ".join(calibration.fixed.values())
    assert {"a_1", "d_1"} <= set(calibration.fixed)
    assert "slides" in reasons
    assert "may be scaled" not in reasons


def test_two_lengths_along_a_slide_are_exchanged_and_not_the_scale():
    """The instrument of a surgical robot slides into its trocar, and its shaft is about as long as the zero of the slide lies behind it.

    Exchanging one length for the other stretches both in proportion. The tracker and the travel are in metres, so the scale is known.
    """
    quarter, rows = np.pi / 2, [(0.0, 1, 0.0, 1), (0.0, -1, 0.0, -1), (0.0, 1, -0.432, 0), (0.0, 0, 0.416, 0)]
    rows += [(0.0, -1, 0.0, -1), (0.009, -1, 0.0, -1)]
    joints = [{"a": a, "alpha": turn * quarter, "d": d, "theta": zero * quarter} for a, turn, d, zero in rows]
    joints[2] |= {"type": "prismatic", "limits": [0.05, 0.24]}
    robot = Robot.from_mapping({"name": "instrument", "convention": "modified-dh", "joints": joints})
    rng = np.random.default_rng(8)
    q = rng.uniform(-0.7, 0.7, (80, 6))
    q[:, 2] = rng.uniform(0.1, 0.24, 80)
    tool = kinematics.translation(0, 0.02) @ kinematics.translation(2, 0.01)
    points = (robot.flange(q) @ tool)[:, :3, 3] + rng.normal(0.0, 1e-4, (80, 3))
    found = calibrate(
        Dataset.from_arrays(robot=robot, sensor=Sensor("tracker", tool, noise=1e-4), q=q, points=points)
    )
    (held,) = {"d_3", "d_4"} & set(found.fixed)
    assert "slides" in found.fixed[held] and "may be scaled" not in " ".join(found.fixed.values())
    assert unknown_scale(found) is None


def test_noise_shows_in_standard_errors(exact):
    """Over draws of the noise, errors of predicted places, up to the base frame's, are as large as the stated covariance has them."""
    cell, _ = exact
    z = []
    for seed in range(4):
        rng = np.random.default_rng(100 + seed)
        q = poses(60, rng)
        found = calibrate(cell.dataset(q, 1e-4, rng))
        elsewhere = poses(40, rng)
        off = off_by_a_motion(found.predict(elsewhere)[:, :3, 3], cell.tool(elsewhere)[:, :3, 3])
        std = np.sqrt(np.trace(found.predict_covariance(elsewhere)[:, :3, :3], axis1=1, axis2=2))
        z.append(np.sqrt(np.mean(off**2) / np.mean(std**2)))
    assert 0.5 < np.median(z) < 1.3


def test_correction_is_the_inverse_of_prediction(exact, tmp_path):
    """Corrected travels and angles take the sensor where the nominal arm would have it, with a scale error of the rail as well."""
    from dataclasses import replace

    _, calibration = exact
    scale = JointScale(1, slides=True, coefficients=np.array([3e-4]))
    model = replace(calibration.model, effects=(scale,))
    q = poses(300, np.random.default_rng(3))
    found = correct_joints(model, Poses.from_arrays(q, {}, model.robot.slides))
    assert found.reached.mean() > 0.9  # others are at the edge of the arm's reach
    replace(calibration, model=model).save(tmp_path / "c.json")
    again = load_calibration(tmp_path / "c.json")
    T = again.predict(found.q[found.reached])
    np.testing.assert_allclose(T, found.T_wanted[found.reached], atol=1e-6)
    plain = calibration.predict(q[:3] + [3e-4, 0, 0, 0, 0, 0, 0] * q[:3])
    np.testing.assert_allclose(again.predict(q[:3]), plain, atol=1e-12)
