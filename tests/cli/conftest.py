"""What tests of several commands share: a small workcell that calibrates well, a program to correct, and a fleet of campaigns."""

import os
import shutil
import signal
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from scalar.data.io.plain_yaml import load_yaml
from scalar.diagnosis import Diagnosis, diagnose
from scalar.effects.joint_backlash import JointBacklash
from scalar.effects.joint_harmonic import JointHarmonic
from scalar.effects.thermal_drift import ThermalDrift
from scalar.geometry.robot import Robot
from tests.calibrated_arms import calibrated
from tests.cli.running import JOINTS, run
from tests.random_scene import make_scene
from tests.robot_configs import ROBOT_CONFIGS
from tests.workcell import Scene


@pytest.fixture(scope="session")
def scene() -> Scene:
    """Return a workcell that calibrates well."""
    return make_scene(seed=21, poses_per_plane=30, points_per_scan=20)


@pytest.fixture(scope="session")
def sound(scene, tmp_path_factory) -> Path:
    """Return a folder with dataset, truth, calibration and joints.csv, all without faults."""
    folder = tmp_path_factory.mktemp("sound")
    scene.write(folder / "dataset")
    scene.write_truth(folder / "truth", np.random.default_rng(0))
    scene.truth.poses(5, np.random.default_rng(1)).iloc[:, :7].to_csv(folder / "joints.csv", index=False)
    result = run("calibrate", folder / "dataset", "-o", folder / "out")
    assert result.exit_code == 0, result.output
    (folder / "summary.txt").write_text(result.stdout, encoding="utf-8")
    return folder


@pytest.fixture
def dataset(sound, tmp_path) -> Path:
    """Return a copy of the dataset, for a test to damage."""
    return Path(shutil.copytree(sound / "dataset", tmp_path / "dataset"))


@pytest.fixture(scope="module")
def arm_calibration():
    """Return the calibration of an arm with a harmonic, backlash and thermal growth; three parameters have standard deviations."""
    effects = (
        JointHarmonic(4, (2,), coefficients=np.array([3e-4, 1e-4])),
        JointBacklash(2, "approach", coefficients=np.array([2e-4])),
        ThermalDrift("temperature", 20.0, coefficients=np.array([2e-5])),
    )
    robot = Robot.from_mapping(load_yaml(ROBOT_CONFIGS / "vs060.yaml"))
    made = calibrated(robot, np.random.default_rng(1), effects)
    free = ("a_2", "theta_3", "sensor_x")
    return replace(made, free=free, covariance=np.diag([1e-5, 2e-5, 3e-5]) ** 2, fixed={})


@pytest.fixture
def program(tmp_path, arm_calibration):
    """Return a folder with the calibration and a table of 30 poses, with the columns that the effects need."""
    rng = np.random.default_rng(2)
    q = rng.uniform(-1, 1, (30, 6))
    q[:, 2] = rng.uniform(0.8, 1.8, 30)
    q[:, 4] = rng.uniform(0.4, 1.2, 30)
    table = pd.DataFrame(q, columns=JOINTS)
    table.insert(0, "pose", np.arange(30) + 100)
    for i in range(6):
        table[f"approach{i + 1}"] = rng.choice([-1, 1], 30)
    table["temperature"] = rng.uniform(15, 35, 30)
    table.to_csv(tmp_path / "targets.csv", index=False, float_format="%.17g")
    arm_calibration.save(tmp_path / "calibration.json")
    return tmp_path


@pytest.fixture(scope="module")
def fleet(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with three sound datasets and two that are not: a number that is none, and no joint angles."""
    folder = tmp_path_factory.mktemp("fleet")
    for k in (1, 2, 3):
        scene = make_scene(kind="tracker", seed=k, poses_per_plane=9)
        scene.write(folder / f"robot-{k}" / "campaign")
    make_scene(kind="tracker", seed=4, poses_per_plane=9).write(folder / "robot-0" / "campaign")
    bad = folder / "robot-0" / "campaign" / "poses.csv"
    bad.write_text(bad.read_text().replace("\n1,", "\none,", 1), encoding="utf-8")
    (folder / "robot-4" / "campaign").mkdir(parents=True)
    (folder / "robot-4" / "campaign" / "dataset.yaml").write_text("format: scalar-dataset/1\n")
    return folder


@pytest.fixture(scope="module")
def diagnosed(fleet: Path) -> Diagnosis:
    """Return the diagnosis of one of the datasets."""
    return diagnose(make_scene(kind="tracker", seed=1, poses_per_plane=9).dataset)


@pytest.fixture
def instantly(monkeypatch: pytest.MonkeyPatch, diagnosed: Diagnosis) -> list[str]:
    """Let every diagnosis be the same one, at once; names of robots in the list are refused by ending the process, or by an error."""
    fates: list[str] = []

    def answer(dataset: object, **options: object) -> Diagnosis:
        if "killed" in fates:
            os.kill(os.getpid(), signal.SIGKILL)
        if "broken" in fates:
            raise RuntimeError("a fault of ours")
        return diagnosed

    monkeypatch.setattr("scalar.diagnosis.diagnose", answer)
    return fates
