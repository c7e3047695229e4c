"""The result: what is saved predicts the same when loaded, damaged files are refused, and predictions
agree with other code.
"""

import json
from dataclasses import replace

import numpy as np
import pytest

from scalar.errors import InvalidInput
from scalar.estimation.calibrate import calibrate
from scalar.estimation.calibration_reader import FORMAT
from scalar.estimation.result import Calibration, load_calibration
from tests import kinematics
from tests.kinematics import PARAMETER_KINDS, joint_names
from tests.random_scene import make_scene
from tests.workcell import Scene

SETTINGS = {"poses_per_plane": 30, "points_per_scan": 20, "seed": 12}


@pytest.fixture(scope="module", params=["line-laser", "probe", "tracker"])
def scene(request) -> Scene:
    """Return a workcell for each kind of sensor."""
    return make_scene("panda", request.param, **SETTINGS)


@pytest.fixture(scope="module")
def calibration(scene) -> Calibration:
    """Return the calibration of the scene."""
    return calibrate(scene.dataset)


def test_what_is_saved_predicts_the_same(scene, calibration, tmp_path):
    """Poses, their standard errors, parameters, covariance and summary come back as they were."""
    calibration.save(tmp_path / "calibration.json")
    loaded = load_calibration(tmp_path / "calibration.json")
    poses = scene.truth.poses(50, np.random.default_rng(0))
    np.testing.assert_allclose(loaded.predict(poses), calibration.predict(poses), atol=1e-15)
    for one, two in zip(loaded.predict_std(poses), calibration.predict_std(poses), strict=True):
        np.testing.assert_allclose(one, two, rtol=1e-9)
    assert loaded.parameters() == calibration.parameters()
    np.testing.assert_array_equal(loaded.covariance, calibration.covariance)
    assert loaded.fixed == {name: p["reason"] for name, p in calibration.parameters().items() if p["held"]}
    assert dict(loaded.summary) == json.loads(json.dumps(dict(calibration.summary)))
    loaded.save(tmp_path / "again.json")
    again, first = (json.loads((tmp_path / name).read_text()) for name in ("again.json", "calibration.json"))
    assert again["parameters"] == first["parameters"]


def test_degrees_in_place_of_radians_are_refused(scene, calibration):
    """Angles that are a turn beyond the limits of their joints, in an array or a table, are refused, and each joint is named."""
    poses = scene.truth.poses(50, np.random.default_rng(0))
    joints = [f"q{i + 1}" for i in range(scene.truth.limits.shape[0])]
    degrees = poses.assign(**np.degrees(poses[joints]))
    for given in (degrees, degrees[joints].to_numpy()):
        for asked in (calibration.predict, calibration.correct, calibration.predict_std):
            with pytest.raises(InvalidInput, match="are these degrees") as refused:
                asked(given)
            assert len(refused.value.faults) >= 5
    limits = scene.truth.limits
    assert calibration.predict(limits.T + 0.1).shape == (2, 4, 4)


def test_the_file_has_what_interfaces_promise(calibration, tmp_path):
    """The file has the keys of the format scalar-calibration/2, and its numbers are finite or null."""
    calibration.save(tmp_path / "c.json")
    text = (tmp_path / "c.json").read_text()
    content = json.loads(text, parse_constant=lambda name: pytest.fail(f"{name} in the file"))
    assert content["format"] == FORMAT
    assert {"robot", "sensor", "parameters", "gauge", "effects", "residual_rms_m", "planes"} <= set(content)
    for entry in content["parameters"].values():
        assert set(entry) == {"value", "std", "unit", "held", "reason", "prior"}
        assert entry["unit"] in ("m", "rad")
        assert (entry["std"] is None) == entry["held"]
    for entry in content["gauge"]:
        assert content["parameters"][entry["held"]]["held"]


def test_predictions_agree_with_other_kinematics(scene, calibration):
    """``predict`` is the product of elementary matrices at the calibrated parameters."""
    poses = scene.truth.poses(30, np.random.default_rng(1))
    q = poses[joint_names(7)].to_numpy()
    values = {name: entry["value"] for name, entry in calibration.parameters().items()}
    geometry = np.array([[values[f"{kind}_{i + 1}"] for i in range(7)] for kind in PARAMETER_KINDS])
    T_fs = np.eye(4)
    T_fs[:3, 3] = [values[f"sensor_{axis}"] for axis in "xyz"]
    turn = np.array([values[f"sensor_r{axis}"] for axis in "xyz"])
    T_fs[:3, :3] = kinematics.rotate_about(turn, float(np.linalg.norm(turn)))
    expected = kinematics.chain(geometry, q) @ scene.truth.T_n_flange @ T_fs
    np.testing.assert_allclose(calibration.predict(poses), expected, atol=1e-13)


def test_predict_std_is_the_propagated_covariance():
    """Position and orientation errors are those of central differences of the prediction with the whole covariance."""
    scene = make_scene(seed=4, points_per_scan=20)
    calibration = calibrate(scene.dataset)
    poses = scene.truth.poses(5, np.random.default_rng(2))
    names, h = calibration.model.names, 1e-6
    moves, turns = [], []
    for name in calibration.free:
        step = h * np.eye(len(names))[names.index(name)]
        ahead, behind = (
            replace(
                calibration, model=calibration.model.with_vector(calibration.model.vector + s * step)
            ).predict(poses)
            for s in (1, -1)
        )
        moves.append((ahead - behind)[:, :3, 3] / (2 * h))
        turns.append(
            kinematics.rotation_vector(ahead[:, :3, :3] @ np.swapaxes(behind[:, :3, :3], 1, 2)) / (2 * h)
        )
    for found, columns in zip(calibration.predict_std(poses), (moves, turns), strict=True):
        J = np.stack(columns, axis=2)
        expected = np.sqrt(np.trace(J @ calibration.covariance @ np.swapaxes(J, 1, 2), axis1=1, axis2=2))
        np.testing.assert_allclose(found, expected, rtol=1e-5)


def test_the_nominal_model_is_what_the_dataset_says():
    """Every parameter of the nominal model is fixed at its nominal value, and without a sensor's pose there is no such model."""
    scene = make_scene(poses_per_plane=3, points_per_scan=5)
    nominal = Calibration.nominal(scene.dataset)
    assert nominal.free == ()
    assert all(entry["held"] for entry in nominal.parameters().values())
    np.testing.assert_array_equal(nominal.model.robot.geometry, scene.dataset.robot.geometry)
    none = replace(scene.dataset, sensor=replace(scene.dataset.sensor, T_flange_sensor=None))
    with pytest.raises(ValueError, match="pose of the sensor"):
        Calibration.nominal(none)


def damage(content, how):
    """Return the content of a calibration, damaged."""
    if how == "format":
        content["format"] = "scalar-calibration/9"
    elif how == "no parameters":
        del content["parameters"]
    elif how == "no robot":
        content["robot"] = None
    elif how == "text for a number":
        content["parameters"]["a_2"]["value"] = "long"
    elif how == "a missing parameter":
        del content["parameters"]["a_2"]
    elif how == "a null":
        content["parameters"]["a_2"]["value"] = None
    elif how == "a covariance of another size":
        content["covariance"] = [[1.0, 2.0]]
    elif how == "an unknown effect":
        content["effects"] = [{"name": "no_such_effect", "target": {}, "coefficients": {}}]
    elif how == "a robot of fewer joints":
        for robot in content["robot"].values():
            robot["joints"] = robot["joints"][:3]
    elif how == "a list":
        return [content]
    return content


@pytest.mark.parametrize("how", [
    "format", "no parameters", "no robot", "text for a number", "a missing parameter", "a null",
    "a covariance of another size", "an unknown effect", "a list",
])  # fmt: skip
def test_a_damaged_file_is_refused(how, tmp_path):
    """A file with any missing or wrong entry gives one fault that names the file, and no other exception."""
    calibration = Calibration.nominal(make_scene(poses_per_plane=2, points_per_scan=3).dataset)
    path = tmp_path / "c.json"
    path.write_text(json.dumps(damage(calibration.to_mapping(), how)), encoding="utf-8")
    with pytest.raises(InvalidInput, match=r"c\.json"):
        load_calibration(path)


@pytest.mark.parametrize(
    "content", ["", "{", "not json", "\xff\xfe", "[1, 2]", "null", '{"format": "scalar-dataset/1"}']
)
def test_what_is_no_calibration_is_refused(content, tmp_path):
    """Empty, truncated, foreign and missing files are refused."""
    path = tmp_path / "c.json"
    with pytest.raises(InvalidInput, match="no such file"):
        load_calibration(path)
    path.write_bytes(content.encode("latin-1"))
    with pytest.raises(InvalidInput, match=r"not a calibration|not JSON|not UTF-8"):
        load_calibration(path)
    with pytest.raises(InvalidInput, match="cannot be read"):
        load_calibration(tmp_path)
