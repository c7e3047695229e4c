"""The covariance of predicted poses: by propagation of draws, on the command line, and with a maker's tolerance in dataset.yaml."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
import yaml
from click.testing import CliRunner

from scalar import calibrate, read_dataset
from scalar.cli import cli
from scalar.errors import InvalidInput
from scalar.geometry.robot import Tolerance
from tests import kinematics
from tests.random_scene import make_scene

COORDINATES = ("x", "y", "z", "rx", "ry", "rz")


@pytest.fixture(scope="module")
def workcell():
    """Return a tracked arm and its calibration."""
    scene = make_scene(kind="tracker", seed=2, poses_per_plane=20)
    return scene, calibrate(scene.dataset)


def test_it_is_that_of_predictions_under_drawn_parameters(workcell):
    """Parameters drawn from their covariance move the predicted frames with the predicted covariance."""
    scene, calibration = workcell
    rng = np.random.default_rng(0)
    q = scene.dataset.q[:3]
    at = [calibration.model.names.index(name) for name in calibration.free]
    T = calibration.predict(q)
    moves = []
    for draw in rng.multivariate_normal(np.zeros(len(at)), calibration.covariance, 4000, method="eigh"):
        vector = calibration.model.vector.copy()
        vector[at] += draw
        drawn = replace(calibration, model=calibration.model.with_vector(vector)).predict(q)
        turn = kinematics.rotation_vector(drawn[:, :3, :3] @ np.swapaxes(T[:, :3, :3], 1, 2))
        moves.append(np.concatenate([drawn[:, :3, 3] - T[:, :3, 3], turn], axis=1))
    covariance = calibration.predict_covariance(q)
    for k in range(len(q)):
        scale = np.sqrt(np.diag(covariance[k]))
        sampled = np.cov(np.array(moves)[:, k].T) / np.outer(scale, scale)
        np.testing.assert_allclose(sampled, covariance[k] / np.outer(scale, scale), atol=0.08)


def test_its_traces_are_the_standard_errors(workcell):
    """Position and orientation of ``predict_std`` are the roots of the traces of its two blocks."""
    scene, calibration = workcell
    covariance = calibration.predict_covariance(scene.dataset.q)
    position, orientation = calibration.predict_std(scene.dataset.q)
    np.testing.assert_allclose(np.trace(covariance[:, :3, :3], axis1=1, axis2=2), position**2)
    np.testing.assert_allclose(np.trace(covariance[:, 3:, 3:], axis1=1, axis2=2), orientation**2)


@pytest.mark.parametrize("kind, known", [("tracker", 3), ("line-laser", 6)])
def test_the_command_writes_it_beside_the_frames(kind, known, workcell, tmp_path):
    """``predict --std`` adds columns that give the covariance back; without it the table is as it was.

    A tracker's target shows no orientation of its own: its part of the covariance is left out.
    """
    scene, calibration = workcell
    if kind != "tracker":
        scene = make_scene(kind=kind, seed=2, poses_per_plane=20)
        calibration = calibrate(scene.dataset)
    calibration.save(tmp_path / "calibration.json")
    joints = scene.dataset.poses.filter(regex="pose|q")
    joints.to_csv(tmp_path / "joints.csv", index=False)
    tables = {}
    for name, more in (("plain", ()), ("std", ("--std",))):
        command = ["predict", str(tmp_path / "calibration.json"), str(tmp_path / "joints.csv")]
        result = CliRunner().invoke(cli, [*command, "-o", str(tmp_path / f"{name}.csv"), *more])
        assert result.exit_code == 0, result.output
        tables[name] = pd.read_csv(tmp_path / f"{name}.csv")
    frames = ["pose", *COORDINATES]
    assert list(tables["plain"].columns) == frames
    pd.testing.assert_frame_equal(tables["std"][frames], tables["plain"])
    std = tables["std"][[f"{name}_std" for name in COORDINATES[:known]]].to_numpy()
    assert tables["std"].shape[1] == len(frames) + known + known * (known - 1) // 2
    correlation = np.tile(np.eye(known), (len(std), 1, 1))
    for i in range(known):
        for j in range(i + 1, known):
            column = tables["std"][f"{COORDINATES[i]}_{COORDINATES[j]}_correlation"].to_numpy()
            correlation[:, i, j] = correlation[:, j, i] = column
    rebuilt = std[:, :, None] * std[:, None, :] * correlation
    wanted = calibration.predict_covariance(joints)[:, :known, :known]
    np.testing.assert_allclose(rebuilt, wanted, rtol=1e-8, atol=1e-18)


def test_a_tolerance_is_read_and_a_wrong_one_refused(workcell, tmp_path):
    """``robot.tolerance`` of dataset.yaml reaches the calibration; millimetres in it, or half of it, are refused by name."""
    folder = workcell[0].write(tmp_path / "cell")
    description = folder / "dataset.yaml"
    content = yaml.safe_load(description.read_text(encoding="utf-8"))

    def stating(tolerance):
        description.write_text(
            yaml.safe_dump({**content, "robot": {**content["robot"], "tolerance": tolerance}}),
            encoding="utf-8",
        )
        return read_dataset(folder)

    dataset = stating({"length": 3e-4, "angle": 2e-4})
    assert dataset.robot.tolerance == Tolerance(3e-4, 2e-4)
    for wrong in ({"length": 0.3, "angle": 2e-4}, {"length": 3e-4}, {"length": -1.0, "angle": 1e-4}, 3e-4):
        with pytest.raises(InvalidInput, match="tolerance"):
            stating(wrong)
