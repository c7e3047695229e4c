"""The residual and its Jacobian: against central differences, against all points one by one, and with
planes known beforehand.
"""

from dataclasses import replace

import numpy as np
import pytest

from scalar.estimation.model import Model, ParameterPrior
from scalar.estimation.residuals import Residuals
from scalar.sensors import measure
from tests import kinematics
from tests.random_scene import make_scene

RELATIVE = 1e-7  # issue 2: analytic Jacobian against central differences


def residuals_and_model(dataset, rng, *, reweight=True):
    """Return residuals and a model some degrees and centimetres from its reference: non-zero tangent
    coordinates everywhere.
    """
    measurement = measure(dataset)
    T = dataset.sensor.T_flange_sensor
    target = measurement.fitted_target(
        dataset.robot.flange(dataset.q) @ T, measurement.initial_target(dataset)
    )
    model = Model.at(dataset.robot, T, target)
    residuals = Residuals.of(dataset, model, measurement)
    if reweight:
        residuals = residuals.reweighted(model)
    return residuals, model.with_vector(model.vector + 0.05 * rng.standard_normal(len(model.vector)))


def by_differences(residuals, model):
    """Return the Jacobian by central differences with Richardson's extrapolation: error of order h^4."""
    v, columns = model.vector, []
    for e in np.eye(len(v)):

        def rate(h, e=e):
            ahead = residuals.residual(model.with_vector(v + h * e))
            return (ahead - residuals.residual(model.with_vector(v - h * e))) / (2 * h)

        columns.append((4 * rate(1e-4) - rate(2e-4)) / 3)
    return np.stack(columns, axis=1)


@pytest.mark.parametrize("robot", ["vs060", "ur10e", "panda"])
@pytest.mark.parametrize("kind", ["line-laser", "probe", "tracker"])
def test_jacobian_agrees_with_central_differences(robot, kind):
    """Every column, those of beta and of the target included, agrees to 1e-7 of its largest entry."""
    scene = make_scene(robot, kind, poses_per_plane=5, points_per_scan=(1, 30), seed=2)
    residuals, model = residuals_and_model(scene.dataset, np.random.default_rng(0))
    residual, jacobian = residuals.linearise(model)
    np.testing.assert_array_equal(residual, residuals.residual(model))
    expected = by_differences(residuals, model)
    scale = np.maximum(np.abs(expected).max(axis=0), 1e-6 * np.abs(expected).max())
    assert np.max(np.abs(jacobian - expected) / scale) < RELATIVE


@pytest.mark.parametrize("kind", ["line-laser", "tracker"])
def test_jacobian_with_sessions_and_fixed_transforms(kind):
    """The Jacobian agrees with differences for two sessions, and with transforms before the first joint and after the last."""
    scene = make_scene("panda", kind, poses_per_plane=6, points_per_scan=20, seed=3)
    rng = np.random.default_rng(1)
    poses = scene.dataset.poses.copy()
    poses["session"] = rng.permutation(["a", "b"] * 9)
    ends = [kinematics.random_transform(rng, 0.5, 1.0) for _ in range(2)]
    robot = replace(scene.dataset.robot, T_base_0=ends[0], T_n_flange=ends[1])
    residuals, model = residuals_and_model(replace(scene.dataset, poses=poses, robot=robot), rng)
    expected = by_differences(residuals, model)
    scale = np.maximum(np.abs(expected).max(axis=0), 1e-6 * np.abs(expected).max())
    assert np.max(np.abs(residuals.linearise(model)[1] - expected) / scale) < RELATIVE


def test_jacobian_of_known_planes():
    """The Jacobian agrees with differences for reference planes, one with both standard deviations and one with the distance alone."""
    scene = make_scene(poses_per_plane=4, points_per_scan=10)
    floor, wall_x, wall_y = scene.dataset.planes
    planes = (replace(floor, distance_std=1e-3, normal_std=1e-2), wall_x, replace(wall_y, distance_std=1e-2))
    residuals, model = residuals_and_model(
        replace(scene.dataset, planes=planes), np.random.default_rng(0), reweight=False
    )
    residual, jacobian = residuals.linearise(model)
    assert len(residual) == 3 * 12 + 2 * 4
    assert residual[36 + 6] == pytest.approx((model.target.distances[0] - floor.distance) / 1e-3)
    expected = by_differences(residuals, model)
    scale = np.maximum(np.abs(expected).max(axis=0), 1e-6 * np.abs(expected).max())
    assert np.max(np.abs(jacobian - expected) / scale) < RELATIVE


def test_compressed_rows_have_the_length_of_all_points():
    """``|r|^2`` equals the sum over all points of ``(n . p - d)^2 / (sigma n . u)^2``, computed point by
    point.
    """
    scene = make_scene("ur10e", poses_per_plane=8, points_per_scan=(1, 60), seed=7)
    data = scene.dataset
    residuals, model = residuals_and_model(data, np.random.default_rng(0), reweight=False)
    at = model  # the incidence is frozen at the estimate that reweights
    residuals = residuals.reweighted(at)
    moved = model.with_vector(model.vector + 1e-3)
    owner = np.repeat(np.arange(data.n_poses), np.diff(data.starts))
    k, x, z = data.plane_index[owner], data.points[:, 0], data.points[:, 1]

    def sensor_frames(m):
        frames = kinematics.chain(m.robot.geometry, data.q, m.robot.T_base_0)
        return (frames @ m.robot.T_n_flange @ m.T_flange_sensor)[owner]

    T = sensor_frames(at)
    u = T[:, :3, 0] * x[:, None] + T[:, :3, 2] * z[:, None]
    incidence = np.abs(np.sum(u * at.target.normals[k], axis=1)) / np.hypot(x, z)
    T = sensor_frames(moved)
    p = T[:, :3, 0] * x[:, None] + T[:, :3, 2] * z[:, None] + T[:, :3, 3]
    f = np.sum(p * moved.target.normals[k], axis=1) - moved.target.distances[k]
    expected = np.sum((f / (data.sensor.noise * np.maximum(incidence, 0.05))) ** 2)
    assert np.sum(residuals.residual(moved) ** 2) == pytest.approx(expected, rel=1e-12)
    assert residuals.rms(moved) == pytest.approx(np.sqrt(np.mean(f**2)), rel=1e-12)


def test_a_jacobian_is_kept_for_its_model_and_cannot_be_changed():
    """The Jacobian at one model is computed once; another model, or other references, have their own."""
    scene = make_scene("vs060", "line-laser", poses_per_plane=5, seed=4)
    residuals, model = residuals_and_model(scene.dataset, np.random.default_rng(1))
    kept = residuals.linearise_measured(model)[1]
    assert residuals.linearise_measured(model)[1] is kept
    with pytest.raises(ValueError, match="read-only"):
        kept[0, 0] = 1.0
    for other in (model.with_vector(model.vector + 1e-3), model.rebased()):
        fresh = Residuals(residuals.measurement, residuals.poses, residuals.bases, residuals.known)
        np.testing.assert_array_equal(residuals.linearise(other)[1], fresh.linearise(other)[1])
        np.testing.assert_array_equal(residuals.residual(other), fresh.residual(other))


@pytest.mark.parametrize("kind", ["line-laser", "tracker"])
def test_models_that_differ_in_priors_alone_share_their_rows(kind):
    """The Jacobian of the measured rows is the same object then, the rows of priors are the model's own, and another model shares nothing."""
    scene = make_scene(kind=kind, seed=3, poses_per_plane=5)
    residuals, model = residuals_and_model(scene.dataset, np.random.default_rng(0))
    prior = ParameterPrior("a_2", 0.1, 0.01, "")
    with_prior = replace(model, priors=(prior,), misfit_ratio=2.0)
    rows, jacobian = residuals.linearise_measured(model)
    assert residuals.linearise_measured(with_prior)[1] is jacobian
    np.testing.assert_array_equal(residuals.residual(with_prior)[: len(rows)], rows)
    expected = (model.vector[model.names.index("a_2")] - 0.1) * 2.0 / 0.01
    assert residuals.residual(with_prior)[len(rows) :] == pytest.approx([expected])
    for other in (model.with_vector(model.vector), replace(model, target=model.target.rebased())):
        assert residuals.linearise_measured(other)[1] is not jacobian
