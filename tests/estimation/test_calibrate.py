"""From a dataset to a calibration: known answers without noise, the headline's accuracy over seeds, and
what is fixed.
"""

from dataclasses import replace

import numpy as np
import pytest

from scalar.errors import InvalidInput
from scalar.estimation.calibrate import calibrate
from scalar.evaluate import evaluate
from scalar.units import DEG, MM
from tests import kinematics
from tests.measuring_poses import scan
from tests.random_scene import make_scene
from tests.robot_configs import PUBLISHED_FIXED
from tests.workcell import Scene

TO_DIGITS = 1e-9  # m and rad; issue 2
RANDOM_STARTS = 20
HEADLINE_SEEDS = 30


def random_start(seed: int, robot: str = "vs060", **settings):
    """Return a noise-free workcell whose nominal arm is off by up to 2 mm and 1 degree, its target planes by 30
    degrees and 100 mm.
    """
    return make_scene(
        robot,
        seed=seed,
        noise=0.0,
        uniform_error=True,
        length_error=2 * MM,
        angle_error=1 * DEG,
        plane_tilt=30 * DEG,
        plane_offset=100 * MM,
        **{"stated_noise": 1e-4, **settings},
    )


def worst_errors(scene: Scene, calibration) -> tuple[float, float]:
    """Return the largest error of any length [m] and of any angle [rad]: arm, scanner and planes."""
    truth, model = scene.truth, calibration.model
    geometry = model.robot.geometry - truth.geometry
    angles = (geometry[[1, 3, 4]] + np.pi) % (2 * np.pi) - np.pi
    T = np.linalg.inv(truth.T_flange_sensor) @ model.T_flange_sensor
    lengths = [np.abs(geometry[[0, 2]]).max(), np.abs(T[:3, 3]).max()]
    turns = [np.abs(angles).max()]
    if scene.dataset.sensor.kind == "line-laser":
        turns.append(np.linalg.norm(kinematics.rotation_vector(T[:3, :3])))
    if len(truth.normals):
        lengths.append(np.abs(model.target.distances - truth.distances).max())
        turns.append(np.linalg.norm(np.cross(model.target.normals, truth.normals), axis=1).max())
    return max(lengths), max(turns)


@pytest.mark.parametrize("nominal_pose", [True, False])
def test_noise_free_scans_give_the_truth_back(nominal_pose):
    """From 20 random starts, with and without a rough pose of the scanner, every parameter is right to 1e-9 m and rad."""
    for seed in range(RANDOM_STARTS):
        scene = random_start(seed, nominal_pose=nominal_pose)
        errors = worst_errors(scene, calibrate(scene.dataset))
        assert max(errors) < TO_DIGITS, (seed, errors)


@pytest.mark.parametrize("robot", ["ur10e", "panda", "puma560"])
def test_arms_of_other_makes_give_the_truth_back(robot):
    """Four arms with six and seven joints are calibrated by the same code with other configs."""
    for seed in range(3):
        scene = random_start(seed, robot, nominal_pose=seed % 2 == 0)
        assert max(worst_errors(scene, calibrate(scene.dataset))) < TO_DIGITS


@pytest.mark.parametrize("settings", [
    {"stated_noise": None},
    {"stated_noise": 1e-15},
    {"error_axis": "z"},
    {"points_per_scan": (2, 30)},
    {"points_per_scan": 1000, "poses_per_plane": 15},
    {"upright": True},
])  # fmt: skip
def test_noise_free_scans_of_every_form(settings):
    """The truth is found with noise not stated or absurdly small, errors along z, scans of two points and of a thousand, and upright walls."""
    scene = random_start(1, **settings)
    assert max(worst_errors(scene, calibrate(scene.dataset))) < TO_DIGITS


@pytest.mark.parametrize("kind", ["probe", "tracker"])
@pytest.mark.parametrize("robot", ["vs060", "panda"])
def test_other_sensors_give_the_truth_back(robot, kind):
    """Noise-free contacts and tracked points give the truth, except for the sensor's rotation, which they do not observe."""
    scene = make_scene(robot, kind, noise=0.0, stated_noise=1e-4, poses_per_plane=60, seed=5)
    assert max(worst_errors(scene, calibrate(scene.dataset))) < TO_DIGITS


def test_headline_accuracy_over_seeds():
    """With 120 poses, 100 points and 0.1 mm of noise, raw errors over 30 workcells are at most 0.03 mm and 0.005 degrees."""
    position, orientation = [], []
    for seed in range(HEADLINE_SEEDS):
        scene = make_scene(seed=1000 + seed, upright=seed % 2 == 0)
        errors = evaluate(calibrate(scene.dataset), scene.truth.poses(1000, np.random.default_rng(seed))).raw
        position.append(errors.position.mean())
        orientation.append(errors.orientation.mean())
    assert np.mean(position) < 0.03 * MM
    assert np.mean(orientation) < 0.005 * DEG


def test_compressed_and_full_data_have_the_same_optimum():
    """A Gauss-Newton step on all single points moves nothing by more than 1e-9 from the optimum of the compressed rows."""
    scene = make_scene(seed=8, poses_per_plane=20, points_per_scan=(20, 60))
    calibration = calibrate(scene.dataset)
    data, model = scene.dataset, calibration.model
    owner = np.repeat(np.arange(data.n_poses), np.diff(data.starts))
    k, (x, z) = data.plane_index[owner], data.points.T

    def distances_and_incidence(at):
        frames = (
            kinematics.chain(at.robot.geometry, data.q, at.robot.T_base_0)
            @ at.robot.T_n_flange
            @ at.T_flange_sensor
        )
        T, n = frames[owner], at.target.normals[k]
        along = T[:, :3, 0] * x[:, None] + T[:, :3, 2] * z[:, None]
        f = np.sum(n * (along + T[:, :3, 3]), axis=1) - at.target.distances[k]
        return f, np.abs(np.sum(n * along, axis=1)) / np.hypot(x, z)

    f, incidence = distances_and_incidence(model)
    weight = 1.0 / (data.sensor.noise * incidence)
    free = [model.names.index(name) for name in calibration.free]
    h, columns = 1e-6, []
    for i in free:
        step = h * np.eye(len(model.vector))[i]
        ahead = distances_and_incidence(model.with_vector(model.vector + step))[0]
        columns.append((ahead - distances_and_incidence(model.with_vector(model.vector - step))[0]) / (2 * h))
    J = np.stack(columns, axis=1) * weight[:, None]
    step = np.linalg.lstsq(J, -f * weight, rcond=None)[0]
    assert np.abs(step).max() < 1e-9
    covariance = np.linalg.inv(J.T @ J)
    np.testing.assert_allclose(np.sqrt(np.diag(covariance)), list(calibration.std.values()), rtol=1e-5)


def test_the_order_of_the_poses_does_not_matter():
    """Shuffled poses give the same parameters to rounding."""
    scene = make_scene(seed=2, poses_per_plane=15, points_per_scan=20)
    order = np.random.default_rng(0).permutation(scene.dataset.n_poses)
    pieces = [scene.dataset.points[scene.dataset.starts[i] : scene.dataset.starts[i + 1]] for i in order]
    shuffled = replace(
        scene.dataset,
        poses=scene.dataset.poses.iloc[order].reset_index(drop=True),
        points=np.concatenate(pieces),
        starts=np.r_[0, np.cumsum([len(piece) for piece in pieces])],
    )
    one, two = calibrate(scene.dataset), calibrate(shuffled)
    np.testing.assert_allclose(one.model.vector, two.model.vector, atol=1e-10)


def test_held_parameters_keep_their_nominal_values():
    """Parameters that are fixed, derived or by request, keep the dataset's values, and all others have a standard error."""
    scene = make_scene(exact=(*PUBLISHED_FIXED, "a_4"))
    calibration = calibrate(scene.dataset, fix=["a_4"])
    parameters = calibration.parameters()
    nominal = dict(
        zip(scene.dataset.robot.parameter_names, scene.dataset.robot.geometry.ravel(), strict=True)
    )
    held = {name for name, entry in parameters.items() if entry["held"]}
    assert held == {*PUBLISHED_FIXED, "a_4", *(f"beta_{i}" for i in range(1, 7))}
    for name in held:
        assert parameters[name]["value"] == nominal[name]
        assert parameters[name]["std"] is None
        assert parameters[name]["reason"]
    assert all(entry["std"] > 0 for name, entry in parameters.items() if name not in held)
    with pytest.raises(InvalidInput, match="no parameter 'a_9'"):
        calibrate(scene.dataset, fix=["a_9"])


def test_noise_that_is_not_stated_is_estimated():
    """Without a stated noise, parameters and standard errors are those with it."""
    scene = make_scene(seed=3, noise=3e-4)
    stated, not_stated = (
        calibrate(scene.dataset),
        calibrate(replace(scene.dataset, sensor=replace(scene.dataset.sensor, noise=None))),
    )
    assert not not_stated.summary["sigma_stated"]
    assert not_stated.summary["sigma_m"] == pytest.approx(3e-4, rel=0.04)
    np.testing.assert_allclose(not_stated.model.vector, stated.model.vector, atol=1e-6)
    np.testing.assert_allclose(list(not_stated.std.values()), list(stated.std.values()), rtol=0.04)


@pytest.mark.parametrize("kind", ["probe", "tracker"])
def test_a_single_point_a_pose_takes_its_noise_from_the_residual(kind):
    """If no noise is stated and a pose is a single point, the standard errors follow the residual of the fit."""
    scene = make_scene(kind=kind, seed=3, noise=3e-4, poses_per_plane=80)
    stated = calibrate(scene.dataset)
    not_stated = calibrate(replace(scene.dataset, sensor=replace(scene.dataset.sensor, noise=None)))
    freedom = 240 * (1 if kind == "probe" else 3) - len(stated.free)
    ratio = np.array(list(not_stated.std.values())) / np.array(list(stated.std.values()))
    np.testing.assert_allclose(ratio, 1.0, atol=4.5 / np.sqrt(2 * freedom))
    assert np.ptp(ratio) < 1e-4  # priors, where the data need them, are weighed by the noise as well


def test_more_noise_than_was_stated_widens_the_standard_errors():
    """An error common to each scan that nobody stated shows in the misfit, and the standard errors grow with it."""
    scene = make_scene(seed=4)
    rng = np.random.default_rng(0)
    bias = np.repeat(2e-4 * rng.standard_normal(scene.dataset.n_poses), np.diff(scene.dataset.starts))
    points = scene.dataset.points + np.column_stack([np.zeros_like(bias), bias])
    honest, biased = calibrate(scene.dataset), calibrate(replace(scene.dataset, points=points))
    assert honest.summary["misfit_p_value"] > 1e-4
    assert biased.summary["misfit_p_value"] < 1e-10
    ratio = np.array(list(biased.std.values())) / np.array(list(honest.std.values()))
    assert np.all(ratio > 3)


def test_known_planes_pull_the_estimate_to_what_is_known():
    """A reference target plane stays at its declared place within the declared uncertainty, and its standard errors shrink to that."""
    scene = make_scene(seed=6)
    floor, *walls = scene.dataset.planes
    known = replace(floor, normal=scene.truth.normals[0], distance=0.0, distance_std=1e-7, normal_std=1e-7)
    found = calibrate(replace(scene.dataset, planes=(known, *walls)))
    assert abs(found.model.target.distances[0]) < 5e-7
    assert found.std["distance_floor"] <= 1.01e-7
    assert found.std["normal_floor_u"] <= 1.01e-7


def test_sessions_have_planes_of_their_own():
    """If target planes were moved between two sessions, each has its own place, the arm is one, and the truth is found."""
    one = make_scene(seed=7, noise=0.0, stated_noise=1e-4, poses_per_plane=20)
    data, q = one.dataset, one.dataset.q
    second = np.arange(data.n_poses) >= 30
    moved = replace(one.truth, distances=one.truth.distances + np.array([0.01, -0.02, 0.03]))
    rng = np.random.default_rng(0)
    points, _ = scan(rng, moved, q, data.plane_index, np.diff(data.starts))
    owner = np.repeat(second, np.diff(data.starts))
    poses = data.poses.assign(session=np.where(second, "after", "before"))
    both = replace(data, poses=poses, points=np.where(owner[:, None], points, data.points))
    found = calibrate(both)
    np.testing.assert_allclose(found.model.robot.geometry, one.truth.geometry, atol=1e-9)
    np.testing.assert_allclose(found.model.target.distances[:3], one.truth.distances, atol=1e-9)
    np.testing.assert_allclose(found.model.target.distances[3:], moved.distances, atol=1e-9)
