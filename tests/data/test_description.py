"""Every fault of dataset.yaml is found and named with its row and key."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from scalar.data.dataset import validate_dataset
from scalar.data.dataset_writer import write_dataset
from scalar.errors import Fault
from tests.small_datasets import description, tables


def faults_of(tmp_path: Path, mapping: Any, kind: str = "line-laser") -> list[Fault]:
    """Return the faults of a dataset with this description."""
    write_dataset(tmp_path / "d", mapping=mapping, **tables(kind))
    return validate_dataset(tmp_path / "d")


def put(*path: Any) -> Callable[[dict[str, Any]], None]:
    """Return the edit that sets the value at the path of all arguments but the last to the last."""

    def edit(mapping: dict[str, Any]) -> None:
        value: Any = mapping
        for key in path[:-2]:
            value = value[key]
        value[path[-2]] = path[-1]

    return edit


J = ("robot", "joints", 2)
POSE, KNOWN = "sensor.nominal_pose", "planes[1].known"
EDITS = [
    (put("format", "scalar-dataset/3"), "format", "write one of scalar-dataset/1, scalar-dataset/2"),
    (put("nmae", "x"), "nmae", "unknown key"),
    (put("name", ""), "name", "empty"),
    (put("name", ["a"]), "name", "not text"),
    (put("source", ["a"]), "source", "not text"),
    (put("robot", None), "robot", "empty; write the robot"),
    (put("robot", "convention", "craig"), "robot.convention", "write one of modified-dh, standard-dh"),
    (put("robot", "convention", "modified_dh"), "robot.convention", "did you mean 'modified-dh'?"),
    (put("robot", "joints", []), "robot.joints", "0 entries where 1 are needed"),
    (put("robot", "joints", {}), "robot.joints", "not a list"),
    (put("robot", "gravity", [0, -9.81]), "robot.gravity", "2 entries where 3 are needed"),
    (put("robot", "gravity", [0, 0, 0]), "robot.gravity", "suspect"),
    (put("robot", "gravty", [0, 0, -9.81]), "robot.gravty", "did you mean 'gravity'?"),
    (put("robot", "base", {"translation": [0, 0]}), "robot.base.translation", "2 entries"),
    (put("robot", "base", {}), "robot.base", "empty"),
    (put(*J, "alpha", "x"), "robot.joints[2].alpha", "not a number ('x'); write a number (link twist [rad])"),
    (put(*J, "alpha", "1.5"), "robot.joints[2].alpha", "not a number ('1.5')"),
    (put(*J, "alpha", True), "robot.joints[2].alpha", "not a number (True)"),
    (put(*J, "alpha", float("nan")), "robot.joints[2].alpha", "not a finite number"),
    (put(*J, "alpha", 10**350), "robot.joints[2].alpha", "too large"),
    (put(*J, "alpha", 1e301), "robot.joints[2].alpha", "too large"),
    (put(*J, 3), "robot.joints[2]", "not a mapping (3)"),
    (put(*J, "type", "linear"), "robot.joints[2].type", "write one of revolute, prismatic"),
    (put(*J, "limits", [1.0, 1.0]), "robot.joints[2].limits", "not below the highest"),
    (put(*J, "limits", [1.0]), "robot.joints[2].limits", "1 entries where 2 are needed"),
    (put("sensor", "kind", "line-lazer"), "sensor.kind", "did you mean 'line-laser'?"),
    (put("sensor", "noise", 0.0), "sensor.noise", "not greater than 0"),
    (put("sensor", "noise", -1e-4), "sensor.noise", "not greater than 0"),
    (put("sensor", "error_axis", "x"), "sensor.error_axis", "write one of ray, z"),
    (put("sensor", "nominal_pose", {"translation": [0, 0, 0]}), f"{POSE}.rotation_vector", "missing"),
    (put("planes", 1, "normal", [0, 0, 0]), "planes[1].normal", "a normal of no length"),
    (put("planes", 1, "normal", [0, 0, 1, 0]), "planes[1].normal", "4 entries where 3 are needed"),
    (put("planes", 1, "distance", None), "planes[1].distance", "empty"),
    (put("planes", 1, "known", {"distance_std": 1, "normal_std": 0}), f"{KNOWN}.normal_std", "less than 1e-09"),
    (put("planes", 1, "known", {"distance_std": 1}), f"{KNOWN}.normal_std", "missing"),
    (put("planes", {}), "planes", "not a list"),
]  # fmt: skip


@pytest.mark.parametrize(("edit", "column", "message"), EDITS)
def test_a_wrong_value_is_named(
    tmp_path: Path, edit: Callable[[dict[str, Any]], None], column: str, message: str
) -> None:
    """The first fault names the key and says what is wrong; the row is that of the key in the file."""
    mapping = description()
    edit(mapping)
    fault = faults_of(tmp_path, mapping)[0]
    text = (tmp_path / "d" / "dataset.yaml").read_text(encoding="utf-8").splitlines()
    assert (fault.file, fault.column) == ("dataset.yaml", column)
    assert message in fault.message
    last_key = column.split(".")[-1].split("[")[0]
    assert fault.row is not None
    assert fault.message.startswith("missing") or last_key in text[fault.row - 1] or "[" in column


@pytest.mark.parametrize(
    "path", [("format",), ("name",), ("robot",), ("sensor",), ("planes",), ("robot", "name")]
)
def test_a_missing_key_is_named(tmp_path: Path, path: tuple[str, ...]) -> None:
    """Every required key that is missing is named in full."""
    mapping = description()
    (mapping if len(path) == 1 else mapping[path[0]]).pop(path[-1])
    assert faults_of(tmp_path, mapping)[0].column == ".".join(path)


@pytest.mark.parametrize("key", ["a", "alpha", "d", "theta"])
def test_a_misspelt_joint_key_is_both_unknown_and_missing(tmp_path: Path, key: str) -> None:
    """`alfa` for `alpha` gives two faults: an unknown key, and a missing one."""
    mapping = description()
    joint = mapping["robot"]["joints"][1]
    joint[key + "_x"] = joint.pop(key)
    columns = {fault.column for fault in faults_of(tmp_path, mapping)}
    assert columns == {f"robot.joints[1].{key}", f"robot.joints[1].{key}_x"}


@pytest.mark.parametrize("mapping", [[1, 2], "text", 3, None])
def test_a_description_that_is_no_mapping_is_refused(tmp_path: Path, mapping: Any) -> None:
    """A description that is a list, a text or nothing is one fault."""
    assert "not a mapping" in faults_of(tmp_path, mapping)[0].message


def test_planes_need_three_different_names(tmp_path: Path) -> None:
    """Two planes are too few, and no two may share a name."""
    mapping = description()
    mapping["planes"][2]["name"] = "floor"
    assert any("rename" in fault.message for fault in faults_of(tmp_path, mapping))
    mapping["planes"].pop()
    assert any("at least three" in fault.message for fault in faults_of(tmp_path, mapping))


@pytest.mark.parametrize("kind", ["probe", "tracker"])
def test_the_nominal_pose_is_optional_for_a_line_laser_only(tmp_path: Path, kind: str) -> None:
    """A probe and a tracker need a rough pose of the sensor."""
    mapping = description(kind)
    mapping["sensor"].pop("nominal_pose")
    assert [fault.column for fault in faults_of(tmp_path, mapping, kind)] == ["sensor.nominal_pose"]
    mapping = description()
    mapping["sensor"].pop("nominal_pose")
    assert faults_of(tmp_path, mapping) == []


def test_beta_belongs_to_modified_dh(tmp_path: Path) -> None:
    """A row of standard DH cannot have Hayati's angle."""
    mapping = description()
    mapping["robot"]["joints"][1]["beta"] = 0.01
    assert faults_of(tmp_path, mapping) == []
    mapping["robot"]["convention"] = "standard-dh"
    assert [fault.column for fault in faults_of(tmp_path, mapping)] == ["robot.joints[1].beta"]
