"""A tracker with several targets on one flange, with whole poses and with a noise for each measurement, in an independent simulation."""

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner

from scalar.cli import cli
from scalar.data.dataset import read_dataset, validate_dataset
from scalar.diagnosis import diagnose
from scalar.estimation.calibrate import calibrate
from scalar.estimation.result import load_calibration
from scalar.sensors import measure
from tests.tracked_targets import drawn_arm, relative

NAMES = ("A", "B", "C")


def cell(seed, names=NAMES, **settings):
    rng = np.random.default_rng(seed)
    arm = drawn_arm(rng, names, **settings)
    return arm, arm.poses(40, rng), rng


def assert_predicts(calibration, arm, rng, tolerance, names, *, turned):
    """Check predictions of every target at poses that were not measured, after aligning by the rigid motion that the base leaves free."""
    q = arm.poses(100, rng)
    true = np.concatenate([arm.at(q, name) for name in names])
    found = np.concatenate(
        [calibration.predict(q, target=name if len(names) > 1 else None) for name in names]
    )
    moved = relative(found, true)
    np.testing.assert_allclose(moved[:, :3, 3], true[:, :3, 3], atol=tolerance)
    if turned:
        np.testing.assert_allclose(moved[:, :3, :3], true[:, :3, :3], atol=10 * tolerance)


@pytest.mark.parametrize("turn_noise", [None, 0.0])
@pytest.mark.parametrize("names", [("A",), NAMES])
def test_noise_free_data_give_every_target(names, turn_noise, tmp_path):
    """After writing, reading, calibrating and loading, all targets are predicted to a tenth of a micrometre, with whole poses in rotation too."""
    arm, q, rng = cell(1, names)
    dataset = arm.dataset(q, rng, turn_noise=turn_noise, stated={"noise": 1e-5})
    dataset.write(tmp_path / "d")
    assert validate_dataset(tmp_path / "d") == []
    calibrate(read_dataset(tmp_path / "d")).save(tmp_path / "calibration.json")
    found = load_calibration(tmp_path / "calibration.json")
    assert_predicts(found, arm, rng, 1e-7, names, turned=turn_noise is not None)


def test_each_pose_may_show_some_of_the_targets():
    """Targets that some poses do not show, in two sessions with different places of the tracker, are found as exactly."""
    arm, q, rng = cell(2, sessions=2)
    seen = rng.random((len(q), 3)) < 0.5
    seen[np.arange(len(q)), rng.integers(0, 3, len(q))] = True
    session = (np.arange(len(q)) >= 22).astype(int)
    dataset = arm.dataset(q, rng, seen=seen, session=session, stated={"noise": 1e-5})
    assert np.array_equal(measure(dataset).equations, 3 * seen.sum(axis=1))
    assert_predicts(calibrate(dataset), arm, rng, 1e-7, NAMES, turned=False)


@pytest.mark.parametrize("oriented", [False, True])
def test_derivatives_are_those_of_the_rows(oriented):
    """Analytic derivatives agree with central differences in every coordinate of the model, far from the optimum too."""
    from scalar.estimation.model import Model
    from scalar.estimation.residuals import Residuals

    arm, q, rng = cell(3, sessions=2)
    seen = rng.random((len(q), 3)) < 0.7
    seen[:, 0] = True
    session = (np.arange(len(q)) >= 22).astype(int)
    dataset = arm.dataset(q, rng, seen=seen, session=session, turn_noise=0.01 if oriented else None)
    target = measure(dataset).initial_target(dataset)
    model = Model.at(dataset.robot, dataset.sensor.T_flange_sensor, target)
    model = model.with_vector(model.vector + 0.3 * rng.normal(size=len(model.vector)))
    residuals = Residuals.of(dataset, model)
    analytic = residuals.linearise(model)[1]
    for i, step in enumerate(1e-6 * np.eye(len(model.vector))):
        difference = (
            residuals.residual(model.with_vector(model.vector + step))
            - residuals.residual(model.with_vector(model.vector - step))
        ) / 2e-6
        scale = np.abs(analytic[:, i]).max() + 1.0
        np.testing.assert_allclose(analytic[:, i] / scale, difference / scale, atol=2e-6)


def test_standard_errors_of_targets_are_calibrated():
    """Over twenty seeds, errors of the distances between targets are standard normal in units of their standard errors."""

    def make(seed):
        arm, q, rng = cell(100 + seed)
        calibration = calibrate(arm.dataset(q, rng, noise=5e-5, stated={"noise": 5e-5}))
        z = []
        for name in NAMES[1:]:
            found, std = distance_between(calibration, name)
            true = np.linalg.norm(arm.targets[name][:3, 3] - arm.targets["A"][:3, 3])
            z.append((found - true) / std)
        return z

    z = np.array([make(seed) for seed in range(20)]).ravel()
    assert abs(z.mean()) < 3 / np.sqrt(len(z))
    assert 0.75 < np.sqrt(np.mean(z**2)) < 1.25


def distance_between(calibration, name):
    """Return the distance of a target from the first [m] and its standard error, which depend on no frame."""
    targets = calibration.model.target.targets
    place = targets.coordinates[targets.names.index(name), :3]
    index = [calibration.free.index(f"target_{name}_{axis}") for axis in "xyz"]
    u = place / np.linalg.norm(place)
    return np.linalg.norm(place), np.sqrt(u @ calibration.covariance[np.ix_(index, index)] @ u)


@pytest.mark.parametrize("errs", [True, False])
def test_a_gear_is_named_from_several_targets_and_nothing_without_it(errs):
    """With targets that some poses do not show and an unknown noise of orientations, joint 4's error is named, and nothing else."""
    rng = np.random.default_rng(5)
    arm = drawn_arm(rng, NAMES[:2])
    q = arm.poses(60, rng)
    true = q.copy()
    if errs:
        true[:, 3] += 4e-4 * np.sin(q[:, 3]) + 3e-4 * np.cos(q[:, 3])
    seen = rng.random((len(q), 2)) < 0.8
    seen[:, 0] |= ~seen.any(axis=1)
    dataset = arm.dataset(q, rng, noise=3e-5, turn_noise=1e-4, seen=seen, stated={"noise": 3e-5}, q_true=true)
    diagnosis = diagnose(dataset).to_mapping()
    named = [(effect["name"], effect["target"].get("joint")) for effect in diagnosis["effects"]]
    assert named == ([("joint_harmonic", 4)] if errs else [])
    (component,) = diagnosis["noise"]["components"]
    assert component["name"] == "rotation_noise" and 0.8e-4 < component["value"] < 1.25e-4


def test_poses_are_weighed_by_their_own_noise():
    """If every second point states ten times the noise, the misfit is about one, and predictions err at most half as much as with equal weights."""
    ratio = []
    for seed in range(8):
        rng = np.random.default_rng(200 + seed)
        arm = drawn_arm(rng, ("A",))
        q, elsewhere = arm.poses(60, rng), arm.poses(30, rng)
        noise = np.where(np.arange(60) % 2, 2e-5, 2e-4)[:, None]
        off = []
        for stated in ({"point_columns": {"noise": noise}}, {}):
            dataset = arm.dataset(q, np.random.default_rng(seed), noise=noise, stated=stated)
            calibration = calibrate(dataset)
            true = arm.at(elsewhere, "A")
            found = relative(calibration.predict(elsewhere), true)
            off.append(np.sqrt(np.mean((found - true)[:, :3, 3] ** 2)))
            assert not stated or 0.8 < calibration.summary["misfit"] < 1.2
        ratio.append(off[0] / off[1])
    assert np.median(ratio) < 0.5


def test_an_unstated_noise_of_orientations_is_estimated():
    """Over six seeds the mean estimate of the noise of orientations is within 8 % of the truth, whether or not that of positions is stated."""
    for stated in ({"noise": 5e-5}, {}):
        found = []
        for seed in range(6):
            rng = np.random.default_rng(300 + seed)
            arm = drawn_arm(rng, ("A",))
            q = arm.poses(60, rng)
            calibration = calibrate(arm.dataset(q, rng, noise=5e-5, turn_noise=2e-4, stated=stated))
            sigma = 1.0 if stated else calibration.summary["misfit"]
            found += [
                entry["value"] * sigma for entry in calibration.noise if entry["name"] == "rotation_noise"
            ]
        assert len(found) == 6
        assert abs(np.mean(found) / 2e-4 - 1) < 0.08


def test_predict_writes_the_frame_of_the_target_that_is_named(tmp_path):
    """The command predicts another target than the sensor with its standard deviations, and refuses a name that the calibration does not have."""
    arm, q, rng = cell(6, NAMES[:2])
    calibration = calibrate(arm.dataset(q, rng, noise=1e-5, stated={"noise": 1e-5}))
    calibration.save(tmp_path / "calibration.json")
    joints = pd.DataFrame(q[:5], columns=[f"q{i + 1}" for i in range(q.shape[1])])
    joints.insert(0, "pose", np.arange(5))
    joints.to_csv(tmp_path / "joints.csv", index=False)
    command = ["predict", str(tmp_path / "calibration.json"), str(tmp_path / "joints.csv")]
    command += ["-o", str(tmp_path / "out.csv"), "--std"]
    done = CliRunner().invoke(cli, [*command, "--target", "B"])
    assert done.exit_code == 0, done.output
    out = pd.read_csv(tmp_path / "out.csv")
    np.testing.assert_allclose(
        out[["x", "y", "z"]], calibration.predict(q[:5], target="B")[:, :3, 3], atol=1e-11
    )
    covariance = calibration.predict_covariance(q[:5], target="B")
    np.testing.assert_allclose(out["z_std"], np.sqrt(covariance[:, 2, 2]), rtol=1e-6)
    refused = CliRunner().invoke(cli, [*command, "--target", "D"])
    assert refused.exit_code == 2
    assert "no target 'D'; it has A, B" in refused.output
