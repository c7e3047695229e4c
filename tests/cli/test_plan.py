"""``scalar plan``: what it writes can be measured, what it promises is kept by a calibration, and what it refuses."""

import json
import re
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from scalar import calibrate, read_dataset
from scalar.cli.plan_source import line_on_assumed_noise
from scalar.data.io.plain_yaml import load_yaml
from tests import kinematics
from tests.cli.running import INPUT_AT_FAULT, refused, run
from tests.random_scene import make_scene


@pytest.fixture(scope="module")
def laser(tmp_path_factory):
    """Return the folder of a dataset with a line laser and three planes."""
    scene = make_scene(seed=4, poses_per_plane=12, points_per_scan=10)
    return scene, scene.write(tmp_path_factory.mktemp("laser") / "cell")


@pytest.fixture(scope="module")
def planned(laser, tmp_path_factory):
    """Return a plan for it, made with the physics engine."""
    out = tmp_path_factory.mktemp("plan") / "plan"
    result = run("plan", laser[1], "--poses", 30, "--candidates", 150, "-o", out)
    assert result.exit_code == 0, result.output
    return out, result.output


def test_the_poses_can_be_measured(laser, planned):
    """By the tests' own geometry, every ray of the fan meets its own plane first, within range and incidence, and joints are within limits."""
    scene, _ = laser
    table = pd.read_csv(planned[0] / "poses.csv")
    assert len(table) == 30 and "poses.csv are not counted" in planned[1]
    assert list(table["order"]) == list(range(1, 31))
    q = table[[f"q{i}" for i in range(1, 7)]].to_numpy()
    robot, sensor = scene.dataset.robot, scene.dataset.sensor
    assert np.all((q >= robot.limits[:, 0]) & (q <= robot.limits[:, 1]))
    T = kinematics.chain(robot.geometry, q, robot.T_base_0) @ robot.T_n_flange @ sensor.T_flange_sensor
    names = [plane.name for plane in scene.dataset.planes]
    normals = np.array([plane.normal for plane in scene.dataset.planes])
    distances = np.array([plane.distance for plane in scene.dataset.planes])
    assert set(table["plane"]) == set(names)
    for angle in np.deg2rad([-15.0, 0.0, 15.0]):
        ray = T[:, :3, 0] * np.sin(angle) + T[:, :3, 2] * np.cos(angle)
        reach = (distances - T[:, :3, 3] @ normals.T) / (ray @ normals.T)
        ahead = np.where(reach > 0, reach, np.inf)
        own = np.array([names.index(name) for name in table["plane"]])
        assert np.array_equal(np.argmin(ahead, axis=1), own)
        here = reach[np.arange(30), own]
        assert np.all((here > 0.0999) & (here < 0.4501))
        assert np.all(np.abs(np.sum(ray * normals[own], axis=1)) > np.cos(np.deg2rad(50.01)))


def test_more_poses_for_a_calibrated_arm_go_on_from_those_measured(laser, tmp_path):
    """With --near, numbers go on from the folder's own poses, the noise is that which the calibration estimated, the error does not grow
    with the number of poses, and the poses stand in degrees too."""
    scene, _ = laser
    sensor = replace(scene.dataset.sensor, noise=None)
    folder = replace(scene, dataset=replace(scene.dataset, sensor=sensor)).write(tmp_path / "cell")
    assert run("calibrate", folder, "-o", tmp_path / "out").exit_code == 0
    near = tmp_path / "out/calibration.json"
    given = ("--poses", 30, "--candidates", 150, "--no-collisions", "-o", tmp_path / "plan")
    result = run("plan", folder, "--near", near, *given)
    assert result.exit_code == 0, result.output
    table = pd.read_csv(tmp_path / "plan/poses.csv")
    assert table["pose"].min() == scene.dataset.pose_ids.max() + 1
    assert set(table) <= set(
        scene.dataset.poses
    )  # the rows can be appended: no order where the folder states none
    content = json.loads((tmp_path / "plan/plan.json").read_text(encoding="utf-8"))
    summary = json.loads(near.read_text(encoding="utf-8"))["summary"]
    assert content["noise_mm"] == pytest.approx(1e3 * summary["sigma_m"])
    curve = content["by_number_of_poses"]
    errors = [entry["expected_error_mm"] for entry in curve if entry["poses"] >= 30]
    assert errors == sorted(errors, reverse=True)
    degrees = pd.read_csv(tmp_path / "plan/poses_deg.csv")
    np.testing.assert_allclose(degrees["q3_deg"], np.degrees(table["q3"]), atol=1e-4)


def test_a_plan_of_too_few_poses_for_a_diagnosis_says_how_many_it_needs(laser, planned, tmp_path):
    """With as many poses more as the plan says are missing, it says nothing of the kind, and with one fewer it misses one."""
    missing = int(re.search(r"plan (\d+) poses more", planned[1]).group(1))
    for fewer in (0, 1):
        given = (
            "--poses",
            30 + missing - fewer,
            "--candidates",
            150,
            "--no-collisions",
            "-o",
            tmp_path / str(fewer),
        )
        said = run("plan", laser[1], *given).output
        assert ("for a diagnosis" in said) == (fewer == 1)
        assert fewer == 0 or "plan 1 poses more" in said


def test_planned_poses_promise_more_than_random_ones(planned):
    """The plan expects a smaller error than as many random poses, in numbers and words that agree, and has a picture."""
    content = json.loads((planned[0] / "plan.json").read_text(encoding="utf-8"))
    assert content["poses"] == 30
    assert content["expected_error_mm"] < content["expected_error_of_random_poses_mm"]
    errors = [entry["expected_error_mm"] for entry in content["by_number_of_poses"]]
    assert errors == sorted(errors, reverse=True)
    assert f"{content['expected_error_mm']:.4f} mm RMS" in planned[1]
    assert (planned[0] / "plan.png").read_bytes().startswith(b"\x89PNG")


def test_the_expected_error_is_that_of_calibrations(tmp_path):
    """For an arm of the library, the error that is stated before measuring agrees with that of eight simulated campaigns.

    Campaigns are simulated by the tests' own kinematics; the scatter of their predictions is compared with the plan's figure.
    """
    out = tmp_path / "plan"
    arguments = ("--poses", 40, "--noise", 0.1, "--repeatability", 0, "--candidates", 200, "--no-collisions")
    result = run("plan", "denso_vs060", *arguments, "-o", out)
    assert result.exit_code == 0, result.output
    expected = json.loads((out / "plan.json").read_text(encoding="utf-8"))["expected_error_mm"]
    q = pd.read_csv(out / "poses.csv")[[f"q{i}" for i in range(1, 7)]].to_numpy()
    from scalar.data.dataset import Dataset
    from scalar.data.declared import Sensor
    from scalar.estimation.calibrate import calibrate
    from scalar.evaluate.pose_errors import aligned_to
    from scalar.geometry.robot import Robot
    from scalar.robots import read_arm

    robot = Robot.from_mapping(read_arm("denso_vs060").mapping)
    T_sensor = np.eye(4)
    T_sensor[0, 3] = T_sensor[2, 3] = 0.1
    chain = kinematics.chain(robot.geometry, q, robot.T_base_0) @ robot.T_n_flange @ T_sensor
    anywhere = np.random.default_rng(1).uniform(*robot.limits.T, (300, 6))
    truth = kinematics.chain(robot.geometry, anywhere, robot.T_base_0) @ robot.T_n_flange @ T_sensor
    squares = []
    for seed in range(8):
        points = chain[:, :3, 3] + 1e-4 * np.random.default_rng(seed).standard_normal((len(q), 3))
        dataset = Dataset.from_arrays(
            robot=robot, sensor=Sensor("tracker", T_sensor, 1e-4), q=q, points=points
        )
        found = aligned_to(truth, calibrate(dataset).predict(anywhere))
        squares.append(np.mean(np.sum((found - truth)[:, :3, 3] ** 2, axis=1)))
    assert 0.75 * expected < 1e3 * np.sqrt(np.mean(squares)) < 1.25 * expected


@pytest.mark.slow
def test_an_accuracy_is_planned_for(tmp_path):
    """With --accuracy alone, the plan has as many poses as the accuracy takes, and states an error within it."""
    counts = []
    for accuracy in (0.1, 0.06):
        out = tmp_path / str(accuracy)
        options = ("--accuracy", accuracy, "--candidates", 150, "--no-collisions")
        result = run("plan", "ur10e", *options, "-o", out)
        assert result.exit_code == 0, result.output
        content = json.loads((out / "plan.json").read_text(encoding="utf-8"))
        assert content["expected_error_mm"] <= accuracy
        counts.append(content["poses"])
    assert counts[0] < counts[1]


@pytest.mark.slow
def test_what_cannot_be_planned_is_refused(laser, tmp_path):
    """Too few poses, an unknown arm and an empty or wrong range of the scanner give one line each, and nothing is written."""
    out = tmp_path / "out"
    some = ("--candidates", 100, "--no-collisions", "-o", out)
    refused(run("plan", "no-such-arm", *some), INPUT_AT_FAULT, "scalar init --list", lines=1)
    refused(run("plan", "ur10e", "--poses", 3, *some), INPUT_AT_FAULT, "plan at least", lines=1)
    refused(run("plan", laser[1], "--range", "3,1", *some), INPUT_AT_FAULT, "--range", lines=1)
    refused(run("plan", laser[1], "--range", "100,450", *some), INPUT_AT_FAULT, "millimetres", lines=1)
    refused(run("plan", laser[1], "--noise", 1e-4, *some), INPUT_AT_FAULT, "are these metres?", lines=1)
    refused(run("plan", laser[1], "--range", "9,9.1", *some), INPUT_AT_FAULT, "sees the plane", lines=1)
    refused(
        run("plan", laser[1], "--after", tmp_path / "none.json", *some),
        INPUT_AT_FAULT,
        "no such file",
        lines=1,
    )
    assert not out.exists()


def test_the_measured_poses_that_a_plan_reads_are_not_replaced(laser, tmp_path):
    """With --near, poses.csv of the dataset is an input, which not even --force replaces by the planned poses."""
    folder, calibration = laser[1], tmp_path / "calibration.json"
    calibrate(read_dataset(folder)).save(calibration)
    measured = (folder / "poses.csv").read_bytes()
    refused(
        run("plan", folder, "--near", calibration, "-o", folder, "--force"),
        INPUT_AT_FAULT,
        "poses.csv",
        "is read by this command",
        lines=1,
    )
    assert (folder / "poses.csv").read_bytes() == measured and not (folder / "plan.json").exists()


def test_an_empty_dataset_of_init_says_what_is_missing(tmp_path):
    """A folder that nobody has filled in is refused with what is missing in it; with planes and a sensor's pose it can be planned."""
    assert run("init", tmp_path / "cell", "--robot", "ur10e", "--sensor", "tracker").exit_code == 0
    result = run("plan", tmp_path / "cell", "--candidates", 100, "--no-collisions", "-o", tmp_path / "plan")
    assert result.exit_code == 2
    assert "nominal_pose" in result.stderr and "{translation: [" in result.stderr
    assert load_yaml(tmp_path / "cell" / "dataset.yaml")["sensor"]["kind"] == "tracker"
    result = run("plan", tmp_path / "cell", "--after", tmp_path / "diagnosis.json", "-o", tmp_path / "plan")
    assert result.exit_code == 2
    assert "--after needs the folder of the dataset that was diagnosed" in result.stderr.splitlines()[-1]


@pytest.mark.parametrize(("stated", "option"), [(None, None), (2e-5, None), (None, 0.02)])
def test_a_noise_that_nobody_stated_is_said_to_be_assumed(stated, option):
    """The expected error is in proportion to it, so the line says what such sensors have, and where to state it."""
    sensor = replace(make_scene(kind="tracker", seed=3).dataset.sensor, noise=stated)
    lines = line_on_assumed_noise(sensor, option, None)
    assert bool(lines) is (stated is None and option is None)
    assert not lines or (
        "is assumed" in lines[0] and "laser tracker scatters" in lines[0] and "--noise" in lines[0]
    )
