"""A damaged calibration is refused by its key: it never predicts, and nothing else is raised."""

import copy
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from scalar.effects.joint_compliance import JointCompliance
from scalar.effects.joint_harmonic import JointHarmonic
from scalar.errors import InvalidInput
from scalar.estimation.calibrate import calibrate
from scalar.estimation.result import load_calibration
from tests.random_scene import make_scene


@pytest.fixture(scope="module")
def sound(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """Return the content of a calibration with two effects."""
    path = tmp_path_factory.mktemp("sound") / "calibration.json"
    dataset = make_scene(poses_per_plane=20, points_per_scan=10, seed=3).dataset
    effects = [JointCompliance(((2, 2), (2, 3), (3, 3))), JointHarmonic(4, (1, 2))]
    calibrate(dataset, effects=effects).save(path)
    return json.loads(path.read_text(encoding="utf-8"))


def saved(content: Any, folder: Path) -> Path:
    """Return a file with this content; numbers that are not finite stand as JSON has them not."""
    path = folder / "c.json"
    path.write_text(json.dumps(content), encoding="utf-8")
    return path


def replaced(content: dict[str, Any], path: tuple[str | int, ...], value: Any) -> dict[str, Any]:
    """Return the content with another value at a path."""
    content = copy.deepcopy(content)
    place: Any = content
    for key in path[:-1]:
        place = place[key]
    place[path[-1]] = value
    return content


NOMINAL = ("robot", "nominal")
DAMAGE = [
    ((*NOMINAL, "gravity"), [1], "robot.nominal.gravity"),
    ((*NOMINAL, "gravity"), [0, 0, float("nan")], "robot.nominal.gravity[2]"),
    ((*NOMINAL, "joints", 1, "a"), "long", "robot.nominal.joints[1].a"),
    ((*NOMINAL, "joints", 1, "a"), 10**400, "robot.nominal.joints[1].a"),
    ((*NOMINAL, "joints", 1, "a"), True, "robot.nominal.joints[1].a"),
    ((*NOMINAL, "base"), {"translation": [0, 0]}, "robot.nominal.base.translation"),
    ((*NOMINAL, "joints"), [], "robot.nominal.joints"),
    (("sensor", "pose", "rotation_vector"), None, "sensor.pose.rotation_vector"),
    (("sensor", "noise"), -1e-4, "sensor.noise"),
    (("parameters", "a_2", "value"), None, "parameters.a_2.value"),
    (("parameters", "a_2", "value"), 1e301, "parameters.a_2.value"),
    (("parameters", "a_2", "held"), 0, "parameters.a_2.held"),
    (("parameters", "a_2"), 1.0, "parameters.a_2"),
    (("planes", 0, "normal"), [0, 0, 1, 0], "planes[0].normal"),
    (("effects", 0, "target"), {"joints": [2, 99]}, "effects[0].target.joints[1]"),
    (("effects", 0, "target"), {"joints": [2]}, "effects[0].target"),
    (("effects", 1, "target", "joint"), 5, "effects[1].target"),
    (("effects", 1, "target", "joint"), 0, "effects[1].target.joint"),
    (("effects", 1, "settings", "joint"), 99, "effects[1].settings.joint"),
    (("effects", 1, "settings", "joint"), 4.0, "effects[1].settings.joint"),
    (("effects", 1, "coefficients", "sin9_rad"), {"value": 1.0, "std": None}, "effects[1].coefficients.sin9_rad"),
    (("effects", 1, "coefficients"), [], "effects[1].coefficients"),
    (("effects",), {}, "effects"),
    (("names", 0), "a_99", "names[0]"),
    (("gauge", 0), {"held": "a_1", "moves_with": []}, "gauge[0].reason"),
    (("gauge", 0, "moves_with"), "a_1", "gauge[0].moves_with"),
    (("covariance",), [[1.0, 2.0]], "covariance"),
    (("summary",), None, "summary"),
    (("summary", "misfit"), "yyyy", "summary.misfit"),
    (("summary", "misfit_p_value"), 2.0, "summary.misfit_p_value"),
    (("summary", "misfit_shift_m"), None, "summary.misfit_shift_m"),
    (("summary", "sigma_m"), [1e-4], "summary.sigma_m"),
    (("summary", "setup"), "[2J", "summary.setup"),
    (("summary", "setup"), [{"what": "zero"}], "summary.setup[0].sentence"),
]  # fmt: skip


def damaged_covariance(content: dict[str, Any], how: str) -> dict[str, Any]:
    """Return the content with a covariance, or a standard error, that one number has made impossible."""
    content = copy.deepcopy(content)
    rows = content["covariance"]
    if how == "one entry":
        rows[0][1] *= -1e6
    elif how == "two entries":
        rows[0][1] = rows[1][0] = 2.0 * (rows[0][0] * rows[1][1]) ** 0.5
    elif how == "variance":
        rows[1][1] *= 4.0
    elif how == "negative":
        rows[1][1] *= -1.0
    else:
        content["parameters"][content["names"][1]]["std"] *= 2.0
    return content


@pytest.mark.parametrize(
    ("how", "words"),
    [
        ("one entry", "covariance: not symmetric"),
        ("two entries", "covariance: no parameters vary together"),
        ("variance", ".std: contradicts the covariance"),
        ("negative", "covariance: the variance of"),
        ("std", ".std: contradicts the covariance"),
    ],
)
def test_what_is_no_covariance_is_refused(
    sound: dict[str, Any], how: str, words: str, tmp_path: Path
) -> None:
    """A negative variance is refused; it once made the comparison of two calibrations fail, and standard errors of predictions silently wrong."""
    with pytest.raises(InvalidInput, match=words):
        load_calibration(saved(damaged_covariance(sound, how), tmp_path))
    empty = [[None] * len(row) for row in sound["covariance"]]
    assert load_calibration(saved(sound | {"covariance": empty}, tmp_path)).free == tuple(sound["names"])


@pytest.mark.parametrize("path, value, column", DAMAGE, ids=[f"{d[2]}={str(d[1])[:20]}" for d in DAMAGE])
def test_a_damaged_value_is_refused_by_its_key(
    sound: dict[str, Any], path: tuple[str | int, ...], value: Any, column: str, tmp_path: Path
) -> None:
    """A value of another type or length, not finite, too large, or contradicting the rest gives a fault at its key."""
    with pytest.raises(InvalidInput) as caught:
        load_calibration(saved(replaced(sound, path, value), tmp_path))
    assert column in [fault.column for fault in caught.value.faults]
    assert all(fault.file.endswith("c.json") for fault in caught.value.faults)


@pytest.mark.parametrize(
    "path", [("robot",), ("sensor",), ("parameters",), ("effects",), ("names",), ("covariance",), (*NOMINAL, "joints", 0, "d")]
)  # fmt: skip
def test_a_missing_key_is_named(sound: dict[str, Any], path: tuple[str | int, ...], tmp_path: Path) -> None:
    """Any key that a calibration needs is named if it is missing."""
    content = copy.deepcopy(sound)
    place: Any = content
    for key in path[:-1]:
        place = place[key]
    del place[path[-1]]
    with pytest.raises(InvalidInput, match=f"{path[-1]}: missing"):
        load_calibration(saved(content, tmp_path))


def test_the_undamaged_file_is_read(sound: dict[str, Any], tmp_path: Path) -> None:
    """The file that the other tests damage reads back whole if it is not damaged."""
    found = load_calibration(saved(sound, tmp_path))
    assert [effect.name for effect in found.model.effects] == ["joint_compliance", "joint_harmonic"]
    assert json.loads(json.dumps(found.to_mapping()["effects"])) == sound["effects"]
    np.testing.assert_array_equal(found.covariance, sound["covariance"])


def test_version_1_of_the_format_is_checked_alike(sound: dict[str, Any], tmp_path: Path) -> None:
    """A calibration of version 1 is read, and a damaged one is refused by its key."""
    first = {**sound, "format": "scalar-calibration/1"}
    first["covariance"] = {"names": first.pop("names"), "matrix": first["covariance"]}
    assert load_calibration(saved(first, tmp_path)).free == tuple(sound["names"])
    with pytest.raises(InvalidInput, match="gravity"):
        load_calibration(saved(replaced(first, (*NOMINAL, "gravity"), [1]), tmp_path))
    with pytest.raises(InvalidInput, match="names: missing"):
        load_calibration(saved({**first, "covariance": []}, tmp_path))


@pytest.mark.parametrize(("name", "command"), [("after.json", "diagnose"), ("calibration.json", "calibrate")])
def test_a_missing_file_names_the_command_that_writes_it(tmp_path, name, command):
    """after.json and before.json come from a diagnosis, other calibrations from `scalar calibrate`."""
    with pytest.raises(InvalidInput, match=f"scalar {command} DATASET"):
        load_calibration(tmp_path / name)
