"""Orientations in foreign tables and descriptions: Euler angles, quaternions and rotation vectors become the rotations that they state."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from scalar.data.io.plain_yaml import dump_yaml, load_yaml
from tests.ingest.foreign_tables import N, cells, header, imported, refused, run, tracker_mapping, write_table
from tests.small_datasets import description


def test_a_description_in_other_units_and_euler_angles_is_converted(tmp_path):
    """A description gives the same dataset whether it is inline or in a file, in mm and degrees or in SI."""
    mapping = tracker_mapping()
    si = imported(tmp_path, mapping, write_table(tmp_path / "a.csv", cells()))
    robot = mapping["dataset"]["robot"]
    for joint in robot["joints"]:
        for key, factor in {"a": 1e3, "d": 1e3, "alpha": 180 / np.pi, "theta": 180 / np.pi}.items():
            joint[key] *= factor
    sensor = mapping["dataset"]["sensor"]
    sensor["noise"] *= 1e3
    angles = Rotation.from_rotvec([0.1, 0.0, 0.0]).as_euler("XYZ", degrees=True).tolist()
    sensor["nominal_pose"] = {
        "translation": [50.0, 20.0, 100.0],
        "rotation_euler": {"axes": "XYZ", "angles": angles},
    }
    mapping["dataset_units"] = {"length": "mm", "angle": "deg"}
    other = imported(tmp_path, mapping, tmp_path / "a.csv")
    np.testing.assert_allclose(other.robot.flange(si.q), si.robot.flange(si.q), atol=1e-13)
    assert other.sensor.T_flange_sensor is not None and si.sensor.T_flange_sensor is not None
    np.testing.assert_allclose(other.sensor.T_flange_sensor, si.sensor.T_flange_sensor, atol=1e-14)
    assert other.sensor.noise == pytest.approx(si.sensor.noise)
    dump_yaml(description("tracker"), tmp_path / "cell.yaml")
    mapping = tracker_mapping() | {"dataset": "cell.yaml"}
    mapping["poses"] = mapping["poses"] | {"rows_in_order": True}
    imported(tmp_path, mapping, tmp_path / "a.csv")
    assert load_yaml(tmp_path / "out/dataset.yaml") == description("tracker")


def test_intrinsic_and_extrinsic_angles_are_distinguished(tmp_path):
    """Capitals are angles about moving axes, R = Rx Ry Rz, and small letters are angles about fixed ones, R = Rz Ry Rx."""
    write_table(tmp_path / "a.csv", cells())
    found = []
    for axes in ("XYZ", "xyz"):
        mapping = tracker_mapping()
        euler = {"axes": axes, "angles": [0.3, -0.4, 0.5]}
        mapping["dataset"]["sensor"]["nominal_pose"] = {"translation": [0, 0, 0.1], "rotation_euler": euler}
        T = imported(tmp_path, mapping, tmp_path / "a.csv").sensor.T_flange_sensor
        assert T is not None
        found.append(T[:3, :3])
    c, s = np.cos([0.3, -0.4, 0.5]), np.sin([0.3, -0.4, 0.5])
    Rx = np.array([[1, 0, 0], [0, c[0], -s[0]], [0, s[0], c[0]]])
    Ry = np.array([[c[1], 0, s[1]], [0, 1, 0], [-s[1], 0, c[1]]])
    Rz = np.array([[c[2], -s[2], 0], [s[2], c[2], 0], [0, 0, 1]])
    np.testing.assert_allclose(found[0], Rx @ Ry @ Rz, atol=1e-14)
    np.testing.assert_allclose(found[1], Rz @ Ry @ Rx, atol=1e-14)


def whole_poses(folder: Path, kind: str) -> tuple[dict[str, Any], np.ndarray]:
    """Write a table with orientations of a kind, and return its mapping and their rotation vectors ``(N, 3)`` [rad]."""
    turns = Rotation.random(N, np.random.default_rng(4))
    mapping = tracker_mapping()
    columns = mapping["poses"]["columns"]
    if kind == "qwxyz":
        values = turns.as_quat()[:, [3, 0, 1, 2]] * np.where(np.arange(N) % 2, -1, 1)[:, None]
        names = ["qw", "qx", "qy", "qz"]
        columns |= {name: {"column": name} for name in names}
    elif kind == "vector":
        values, names = np.degrees(turns.as_rotvec()), ["rx", "ry", "rz"]
        columns |= {name: {"column": name, "unit": "deg"} for name in names}
    else:
        values, names = turns.as_euler(kind, degrees=True), ["A", "B", "C"]
        columns |= {f"e{k + 1}": {"column": name, "unit": "deg"} for k, name in enumerate(names)}
        mapping["poses"]["euler_axes"] = kind
    rows = [
        [*row, *(f"{x:.12f}".replace(".", ",") for x in more)]
        for row, more in zip(cells(), values, strict=True)
    ]
    write_table(folder / "a.csv", rows, [*header(), *names])
    return mapping, turns.as_rotvec()


@pytest.mark.parametrize("kind", ["ZYX", "xyz", "ZXZ", "qwxyz", "vector"])
def test_orientations_become_rotation_vectors(tmp_path, kind):
    """Euler angles about moving and fixed axes, quaternions of either sign and vectors in degrees become the same rotations in the dataset."""
    mapping, wanted = whole_poses(tmp_path, kind)
    data = imported(tmp_path, mapping, tmp_path / "a.csv")
    found = np.column_stack([data.point_columns[name] for name in ("rx", "ry", "rz")])
    np.testing.assert_allclose(
        Rotation.from_rotvec(found).as_matrix(), Rotation.from_rotvec(wanted).as_matrix(), atol=1e-11
    )
    assert not {"e1", "qw"} & set(data.poses.columns)


@pytest.mark.parametrize(
    "change, words",
    [
        (lambda p: p.pop("euler_axes"), "poses.euler_axes: missing; add it: ZYX"),
        (lambda p: p.update(euler_axes="ZZX"), "axes 'ZZX' are not three such as XYZ"),
        (lambda p: p["columns"].pop("e2"), "missing; add it: e1,e2,e3 come together"),
        (
            lambda p: p["columns"].update(rx={"column": "A", "unit": "deg"}),
            "state the same orientation twice",
        ),
        (lambda p: p["columns"]["e1"].pop("unit"), "poses.columns.e1.unit: missing; add it"),
    ],
)
def test_an_orientation_that_is_not_clear_is_refused(tmp_path, change, words):
    """A convention that is missing, contradictory or incomplete is refused, not guessed."""
    mapping, _ = whole_poses(tmp_path, "ZYX")
    change(mapping["poses"])
    refused(tmp_path, run(tmp_path, mapping, tmp_path / "a.csv"), words)


def test_euler_angles_of_more_than_a_turn_are_called_degrees(tmp_path):
    """A mapping that states radians for a table in degrees is refused, with the unit to write."""
    mapping, _ = whole_poses(tmp_path, "ZYX")
    for name in ("e1", "e2", "e3"):
        mapping["poses"]["columns"][name]["unit"] = "rad"
    refused(
        tmp_path, run(tmp_path, mapping, tmp_path / "a.csv"), "more than a turn", "unit: deg for e1, e2, e3"
    )


def test_a_quaternion_of_another_norm_is_refused_by_its_row(tmp_path):
    """Four numbers whose squares do not sum to one are no rotation."""
    mapping, _ = whole_poses(tmp_path, "qwxyz")
    lines = (tmp_path / "a.csv").read_text().splitlines()
    lines[3] = ";".join([*lines[3].split(";")[:-4], "0,5", "0", "0", "0"])
    (tmp_path / "a.csv").write_text("\n".join(lines))
    refused(
        tmp_path, run(tmp_path, mapping, tmp_path / "a.csv"), "a.csv, row 4, column qw", "has the norm 0.5"
    )
