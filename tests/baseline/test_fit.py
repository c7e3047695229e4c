"""The baseline: its 43 parameters, the three readings of its root, which fails at upright walls, and the optimum that it shares
with the proposed method elsewhere; and that compressed rows give both methods the optimum of all points.
"""

import functools

import numpy as np
import pytest
from scipy.optimize import least_squares

from scalar.baseline.fit import calibrate_baseline
from scalar.baseline.parameterisation import READINGS, Parameterisation
from scalar.estimation.least_squares import fit
from scalar.estimation.prepare import prepare
from scalar.estimation.residuals import Residuals
from scalar.geometry.planes import Planes
from tests import kinematics
from tests.baseline.scenes import scene_with_guesses
from tests.random_scene import make_scene
from tests.robot_configs import FIXED_WITH_PLANES, PUBLISHED_FIXED


@functools.cache
def scene(upright=False, robot="vs060"):
    """Return a scene with initial guesses of the planes half a degree and 1 cm off."""
    return scene_with_guesses(robot, upright, poses_per_plane=25)


@functools.cache
def published(reading="clip", points="all", upright=False, max_nfev=5000):
    """Return the published calibration of the scene."""
    return calibrate_baseline(
        scene(upright).dataset,
        reading=reading,
        points=points,
        max_nfev=max_nfev,
        fixed=PUBLISHED_FIXED,
    )


@functools.cache
def unweighted_fit():
    """Return the proposed method's fit with one weight for all points, which is what the baseline minimises."""
    dataset = scene().dataset
    prepared = prepare(dataset)
    residuals = Residuals.of(dataset, prepared.initial.model)
    return fit(residuals, prepared.initial.model, prepared.free)


def lean(normals):
    """Return the vertical components of the walls' normals."""
    return normals[1:, 2]


@pytest.mark.parametrize(("robot", "count"), [("vs060", 43), ("panda", 47)])
def test_a_unit_vector_is_three_parameters_one_of_them_constrained(robot, count):
    """The model has 4 n DH parameters, 7 of the scanner and 4 of each plane, and one constraint for each unit vector."""
    dataset = scene(robot=robot).dataset
    planes = prepare(dataset).residuals.measurement.initial_target(dataset)
    how = Parameterisation(dataset.robot, planes)
    held = FIXED_WITH_PLANES[robot]
    parameters = how.lmfit_parameters(how.values(np.eye(4)), held, "clip")
    assert len(parameters) == count
    assert sum(parameter.expr is not None for parameter in parameters.values()) == 4
    assert sum(parameter.vary for parameter in parameters.values()) == count - 4 - len(held)


def test_the_fixed_parameters_are_derived_and_are_the_papers():
    """If none are given, the parameters that are fixed on the VS060 are those that the paper fixes."""
    found = calibrate_baseline(scene().dataset, max_nfev=40)
    assert {entry["held"] for entry in found.gauge} == set(PUBLISHED_FIXED)
    assert found.summary["varying"] == 32


@pytest.mark.parametrize("seed", range(10))
def test_published_parameters_hold_every_pose_and_plane(seed):
    """Converting a model to the published parameters and back is the identity, and no third component of a unit vector is negative."""
    rng = np.random.default_rng(seed)
    robot = scene().dataset.robot
    T = np.eye(4)
    T[:3, :3] = kinematics.rotate_about(rng.standard_normal(3), rng.uniform(0.0, np.pi))
    T[:3, 3] = rng.standard_normal(3)
    planes = Planes.at(("a", "b", "c"), rng.standard_normal((3, 3)), rng.standard_normal(3))
    how = Parameterisation(robot, planes)
    values = how.values(T)
    third = [values[how.names.index(name)] for name in ("r_z", "normal_a_z", "normal_b_z", "normal_c_z")]
    model = how.model(values)
    assert min(third) >= 0
    np.testing.assert_allclose(model.T_flange_sensor, T, atol=1e-12)
    np.testing.assert_allclose(model.target.normals, planes.normals, atol=1e-12)
    np.testing.assert_allclose(model.target.distances, planes.distances, atol=1e-12)


@pytest.mark.parametrize("reading", READINGS)
def test_leaning_walls_give_our_optimum_in_every_reading(reading):
    """Where no root comes near zero, all readings give the proposed method's optimum, for downward normals too."""
    true_lean = lean(scene().truth.normals)
    assert np.abs(true_lean).min() > np.sin(np.deg2rad(1.0)), "choose a seed with leaning walls"
    assert true_lean.min() < 0, "choose a seed with a wall that leans the other way"
    ours, theirs = unweighted_fit(), published(reading)
    assert theirs.summary["status"] == "converged"
    robot = np.flatnonzero(ours.free[:30])
    sigma = np.sqrt(np.diag(ours.covariance))[: len(robot)]
    off = (theirs.model.vector - ours.model.vector)[robot] / sigma
    assert np.abs(off).max() < 0.02
    np.testing.assert_allclose(theirs.model.T_flange_sensor, ours.model.T_flange_sensor, atol=1e-6)
    np.testing.assert_allclose(theirs.model.target.normals, ours.model.target.normals, atol=1e-6)
    np.testing.assert_allclose(theirs.model.target.distances, ours.model.target.distances, atol=1e-6)


def test_its_standard_errors_are_those_of_unweighted_points():
    """lmfit's covariance, transformed to the reported coordinates, is ``(J' J)^-1`` times the residual's
    variance.
    """
    ours, theirs = unweighted_fit(), published("clip")
    count = len(scene().dataset.points)
    variance = ours.chi_squared / (count - int(ours.free.sum()))
    robot = int(ours.free[:30].sum())
    expected = np.sqrt(variance * np.diag(ours.covariance))
    std = np.sqrt(np.diag(theirs.covariance))
    np.testing.assert_allclose(std[: robot + 3], expected[: robot + 3], rtol=0.02)


def test_compressed_rows_give_the_baseline_its_own_optimum():
    """Compressed rows give the end of all points, to the solver's tolerance, and standard errors whose median agrees.

    Those of single parameters may differ: lmfit's come from forward differences whose step, for a parameter near zero, leaves few digits,
    and the processor decides which (alpha_3 by a factor of three with OpenBLAS's kernels for Zen, within 2 % with those for SkylakeX).
    """
    everything, compressed = published("clip", "all"), published("clip", "compressed")
    assert compressed.summary["status"] == everything.summary["status"] == "converged"
    std = np.sqrt(np.diag(everything.covariance))
    free = [everything.model.names.index(name) for name in everything.free]
    off = (compressed.model.vector - everything.model.vector)[free] / std
    assert np.abs(off).max() < 0.02
    ratio = np.sqrt(np.diag(compressed.covariance)) / std
    assert abs(np.median(ratio) - 1.0) < 0.02 and np.mean(np.abs(ratio - 1.0) < 0.1) > 0.8


def test_left_alone_lmfit_stops_at_an_upright_wall_and_that_is_reported():
    """With ``raise`` a NaN ends the fit at once: the status says so, the robot stays nominal, and no standard errors are given."""
    before = np.geterr()
    found = published("raise", upright=True)
    assert found.summary["status"] == "raised"
    assert "NaN" in found.summary["message"]
    np.testing.assert_array_equal(found.model.robot.geometry, scene(True).dataset.robot.geometry)
    assert np.isnan(list(found.std.values())).all()
    assert np.geterr() == before


@pytest.mark.parametrize("reading", ["clip", "abs"])
def test_the_other_readings_get_past_an_upright_wall(reading):
    """``clip`` and ``abs`` converge, at finite parameters that fit better than the start."""
    found, start = published(reading, upright=True), published("raise", upright=True)
    assert found.summary["status"] == "converged"
    assert np.isfinite(found.model.vector).all()
    assert found.residual_rms < start.residual_rms


def test_a_fit_that_hits_the_cap_says_so_and_is_still_reported(tmp_path):
    """A fit with the status ``capped`` made no more evaluations than allowed, and has finite parameters and a calibration that can be saved."""
    found = published("clip", max_nfev=60)
    assert found.summary["status"] == "capped"
    assert found.summary["evaluations"] <= 60
    assert np.isfinite(found.model.vector).all()
    found.save(tmp_path / "calibration.json")


def test_what_it_cannot_do_is_refused():
    """Another sensor, an unknown reading or an unknown choice of points is refused."""
    dataset = scene().dataset
    with pytest.raises(ValueError, match="scans of planes"):
        calibrate_baseline(make_scene(kind="tracker", poses_per_plane=5).dataset)
    with pytest.raises(ValueError, match="reading"):
        calibrate_baseline(dataset, reading="round")
    with pytest.raises(ValueError, match="points"):
        calibrate_baseline(dataset, points="some")


def test_our_fit_of_compressed_rows_is_scipys_of_all_points():
    """The optimum of the compressed rows is that of all weighted points, to 1e-9 in every length and angle.

    SciPy finds the latter with other kinematics, other coordinates and differences.
    """
    data = scene().dataset
    prepared = prepare(data)
    start = prepared.initial.model
    ours = fit(prepared.residuals, start, prepared.free).model

    free = np.flatnonzero(prepared.free[:30])
    n_0, d_0 = start.target.normals, start.target.distances
    tangents = np.linalg.svd(n_0[:, None, :])[2][:, 1:]
    pose = np.repeat(np.arange(data.n_poses), np.diff(data.starts))
    plane = data.plane_index[pose]
    x, z = data.points.T
    T_0 = start.T_flange_sensor

    def model(v):
        geometry = data.robot.geometry.copy()
        geometry.ravel()[free] = v[: len(free)]
        sensor, target = v[len(free) : len(free) + 6], v[len(free) + 6 :].reshape(-1, 3)
        T = T_0.copy()
        T[:3, 3] = sensor[:3]
        angle = np.linalg.norm(sensor[3:])
        if angle > 0:
            T[:3, :3] = T_0[:3, :3] @ kinematics.rotate_about(sensor[3:], angle)
        normals = n_0 + np.einsum("kt,ktx->kx", target[:, :2], tangents)
        return geometry, T, normals / np.linalg.norm(normals, axis=1, keepdims=True), target[:, 2]

    def distance_and_ray(v):
        geometry, T_flange_sensor, normals, distances = model(v)
        T = kinematics.chain(geometry, data.q, data.robot.T_base_0) @ data.robot.T_n_flange @ T_flange_sensor
        point = T[pose, :3, 0] * x[:, None] + T[pose, :3, 2] * z[:, None]
        along = np.sum(normals[plane] * point, axis=1)
        return along + np.sum(normals[plane] * T[pose, :3, 3], axis=1) - distances[plane], along

    v_0 = np.concatenate(
        [
            data.robot.geometry.ravel()[free],
            T_0[:3, 3],
            np.zeros(3),
            np.column_stack([np.zeros((3, 2)), d_0]).ravel(),
        ]
    )
    weight = 1.0 / (data.sensor.noise * np.abs(distance_and_ray(v_0)[1]) / np.hypot(x, z))
    found = least_squares(
        lambda v: distance_and_ray(v)[0] * weight,
        v_0,
        jac="3-point",
        x_scale="jac",
        ftol=1e-15,
        xtol=1e-15,
        gtol=1e-15,
    )
    geometry, T, normals, distances = model(found.x)
    np.testing.assert_allclose(ours.robot.geometry, geometry, rtol=0, atol=1e-9)
    np.testing.assert_allclose(ours.T_flange_sensor, T, rtol=0, atol=1e-9)
    np.testing.assert_allclose(ours.target.normals, normals, rtol=0, atol=1e-9)
    np.testing.assert_allclose(ours.target.distances, distances, rtol=0, atol=1e-9)
