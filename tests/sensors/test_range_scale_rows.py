"""The derivatives of a scan's rows by a factor on all ranges are those of rows of scans that were stretched."""

from dataclasses import replace

import numpy as np
import pytest

from scalar.diagnosis.fit.whitened_measurement import WhitenedMeasurement
from scalar.sensors import NoiseComponent, measure
from tests.random_scene import make_scene

STEP = 1e-5


def squares(dataset, T, target, whitening=None):
    """Return half the sum of squares of the rows of a dataset with equal weights, perhaps whitened, and its derivative by a factor on ranges."""
    measurement = measure(dataset)
    if whitening is not None:
        component = NoiseComponent("pose_jitter", {}, 1e-4, 1e-5, "rad", "")
        measurement = WhitenedMeasurement(measurement, whitening, component)
    residual = measurement.rows(T, target).residual
    return 0.5 * float(np.sum(residual**2)), float(np.sum(residual * measurement.by_range_scale(T, target)))


@pytest.mark.parametrize("axis", ["ray", "z"])
def test_stretched_scans_have_these_rows(axis):
    """Half the sum of squares of stretched scans, of a scanner that is 5 mm off, changes as the derivatives say, for errors along ray and z."""
    scene = make_scene("vs060", "line-laser", poses_per_plane=4, noise=1e-5, seed=2)
    dataset = replace(scene.dataset, sensor=replace(scene.dataset.sensor, error_axis=axis))
    T = dataset.robot.flange(dataset.q) @ dataset.sensor.T_flange_sensor
    T[:, :3, 3] += 0.005
    target = measure(dataset).initial_target(dataset)
    stretch = np.array([1.0, 1.0]) if axis == "ray" else np.array([0.0, 1.0])
    longer, shorter = (
        squares(replace(dataset, points=dataset.points * (1.0 + h * stretch)), T, target)[0]
        for h in (STEP, -STEP)
    )
    assert squares(dataset, T, target)[1] == pytest.approx((longer - shorter) / (2 * STEP), rel=1e-6)


def test_whitened_rows_have_whitened_derivatives():
    """With whitening W of the rows of each pose, the same half sum of squares has the derivative r' W' W dr."""
    scene = make_scene("vs060", "line-laser", poses_per_plane=4, noise=1e-5, seed=2)
    dataset = scene.dataset
    T = dataset.robot.flange(dataset.q) @ dataset.sensor.T_flange_sensor
    T[:, :3, 3] += 0.005
    inner = measure(dataset)
    target = inner.initial_target(dataset)
    m = inner.rows_per_pose
    whitening = np.tile(np.diag(1.0 + np.arange(m)), (dataset.n_poses, 1, 1))
    weights = np.diagonal(whitening, axis1=1, axis2=2) ** 2
    rows, by_scale = inner.rows(T, target).residual, inner.by_range_scale(T, target)
    assert by_scale is not None
    expected = float(np.sum(rows * weights * by_scale))
    assert squares(dataset, T, target, whitening)[1] == pytest.approx(expected, rel=1e-12)


def test_a_tracker_measures_no_ranges():
    """A kind of sensor whose rows depend on no range says so."""
    dataset = make_scene("vs060", "tracker", poses_per_plane=4, seed=2).dataset
    T = dataset.robot.flange(dataset.q)
    measurement = measure(dataset)
    assert measurement.by_range_scale(T, measurement.initial_target(dataset)) is None
