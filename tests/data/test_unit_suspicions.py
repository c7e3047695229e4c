"""Degrees for radians and millimetres for metres are suspected; large real workcells are not."""

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from scalar.data.dataset import validate_dataset
from scalar.data.dataset_writer import write_dataset
from scalar.errors import Fault
from scalar.units import DEG, MM
from tests.small_datasets import N_POSES, PLANES, description, tables


def faults_of(tmp_path: Path, mapping: dict[str, Any], content: dict[str, pd.DataFrame]) -> list[Fault]:
    """Return the faults of a dataset."""
    write_dataset(tmp_path / "d", mapping=mapping, **content)
    return validate_dataset(tmp_path / "d")


def columns_of(faults: list[Fault]) -> set[str | None]:
    """Return the columns of the faults, after checking that all of them are suspicions."""
    assert all(fault.message.startswith("suspect") for fault in faults), [str(fault) for fault in faults]
    return {fault.column for fault in faults}


def puma_like(scale_length: float = 1.0, scale_angle: float = 1.0) -> list[dict[str, Any]]:
    """Return joints of the size of a small arm, lengths and angles multiplied."""
    half = np.pi / 2 * scale_angle
    a = np.array([0.0, 0.0, 0.305, -0.01, 0.0, 0.0]) * scale_length
    d = np.array([0.345, 0.0, 0.0, 0.3, 0.0, 0.07]) * scale_length
    return [
        {"a": float(a[i]), "alpha": half * (i % 2), "d": float(d[i]), "theta": half * (i % 3 - 1)}
        for i in range(6)
    ]


LINKS = {(0, "d"), (2, "a"), (3, "a"), (3, "d"), (5, "d")}
ANGLES = {(0, "theta"), (1, "alpha"), (2, "theta"), (3, "alpha"), (3, "theta"), (5, "alpha"), (5, "theta")}


@pytest.mark.parametrize(
    ("key", "columns"),
    [
        ("a_d", {f"robot.joints[{i}].{name}" for i, name in LINKS}),
        ("angles", {f"robot.joints[{i}].{name}" for i, name in ANGLES}),
        ("base", {"robot.base.translation"}),
        ("flange", {"robot.flange.translation"}),
        ("sensor", {"sensor.nominal_pose.translation"}),
        ("rotation", {"sensor.nominal_pose.rotation_vector"}),
        ("noise", {"sensor.noise"}),
        ("planes", {f"planes[{i}].distance" for i in range(3)}),
        ("gravity", {"robot.gravity"}),
        ("limits", {f"robot.joints[{i}].limits" for i in range(6)}),
        ("one limit", {"robot.joints[5].limits"}),
    ],
)
def test_a_description_in_other_units_is_suspected(tmp_path: Path, key: str, columns: set[str]) -> None:
    """In a workcell with one group of numbers in mm, mm/s^2 or degrees, exactly these numbers are named."""
    mapping = description()
    robot, sensor = mapping["robot"], mapping["sensor"]
    robot["joints"] = puma_like(1 / MM if key == "a_d" else 1.0, 1 / DEG if key == "angles" else 1.0)
    zero = [0.0, 0.0, 0.0]
    if key in ("base", "flange"):
        robot[key] = {"translation": [0.0, 0.0, 0.4 / MM], "rotation_vector": zero}
    elif key == "sensor":
        sensor["nominal_pose"]["translation"] = [0.05 / MM, 0.02 / MM, 0.1 / MM]
    elif key == "rotation":
        sensor["nominal_pose"]["rotation_vector"] = [0.2 / DEG, 0.0, 0.35 / DEG]
    elif key == "noise":
        sensor["noise"] = 1e-4 / MM
    elif key == "planes":
        for plane in mapping["planes"]:
            plane["distance"] /= MM
    elif key == "gravity":
        robot["gravity"] = [0.0, 0.0, -9.81 / MM]
    elif key == "limits":
        for joint in robot["joints"]:
            joint["limits"] = [-170, 170]
    elif key == "one limit":
        robot["joints"][5]["limits"] = [-360, 360]
    assert columns_of(faults_of(tmp_path, mapping, tables())) == columns


@pytest.mark.parametrize("slides", [False, True])
def test_an_arm_of_millimetres_is_suspected(tmp_path: Path, slides: bool) -> None:
    """Metres that were taken for millimetres make an arm of 1 mm; one with a prismatic joint reaches by its travel and is not suspected."""
    mapping = description()
    mapping["robot"]["joints"] = puma_like(MM)
    if slides:
        mapping["robot"]["joints"][0] |= {"type": "prismatic", "limits": [-4.0, 4.0]}
    faults = faults_of(tmp_path, mapping, tables())
    assert columns_of(faults) == (set() if slides else {"robot.joints"})
    assert slides or "In metres the arm would have 1.03 m" in faults[0].message


def test_joint_angles_in_degrees_are_suspected(tmp_path: Path) -> None:
    """All angles in degrees, or those of one row or one column, give one fault for each joint, with its largest angle."""
    content = tables()
    names = [f"q{i + 1}" for i in range(6)]
    poses = content["poses"]
    faults = faults_of(tmp_path, description(), content | {"poses": poses.assign(**poses[names] / DEG)})
    assert columns_of(faults) == set(names)
    row = poses.copy()
    row.loc[4, names] = [30.0, -45.0, 90.0, 12.0, 60.0, -170.0]
    faults = faults_of(tmp_path, description(), content | {"poses": row})
    assert {fault.row for fault in faults} == {6}
    assert (
        sum("scalar import" in fault.message for fault in faults) == 1
    )  # a mapping reads degrees as they are
    faults = faults_of(tmp_path, description(), content | {"poses": poses.assign(q3=poses["q3"] / DEG)})
    assert columns_of(faults) == {"q3"}
    assert "are these degrees?" in faults[0].message
    assert "grads" in faults[0].message  # 400 a turn: no size tells them from degrees


@pytest.mark.parametrize(("kind", "table"), [("line-laser", "scans"), ("tracker", "points")])
def test_points_in_millimetres_are_suspected(tmp_path: Path, kind: str, table: str) -> None:
    """A file of points in millimetres gives one fault for each column, not for each point."""
    content = tables(kind)
    xyz = [name for name in content[table].columns if name != "pose"]
    content[table][xyz] /= MM
    faults = faults_of(tmp_path, description(kind), content)
    assert columns_of(faults) == set(xyz)
    assert all("are these millimetres?" in fault.message for fault in faults)


@pytest.mark.parametrize("kind", ["tracker", "probe"])
def test_a_noise_of_a_point_in_millimetres_is_suspected(tmp_path: Path, kind: str) -> None:
    """A noise of 0.03, meant in millimetres, would be 30 mm, which no tracker or probe has, though a lidar does."""
    mapping = description(kind)
    mapping["sensor"]["noise"] = 0.03
    (fault,) = faults_of(tmp_path, mapping, tables(kind))
    assert fault.column == "sensor.noise" and "is 30 mm" in fault.message


def test_large_real_workcells_are_not_suspected(tmp_path: Path) -> None:
    """4 m of reach, a lidar 18 m away, wrists of 450 degrees, an endless axis and hall coordinates give no fault."""
    mapping = description()
    for joint, a, d in zip(
        mapping["robot"]["joints"], [0, 0.6, 1.7, 0.3, 0, 0], [1.1, 0, 0, 1.9, 0, 0.5], strict=True
    ):
        joint |= {"a": float(a), "d": float(d), "limits": [-450 * DEG, 450 * DEG]}
    mapping["robot"]["joints"][0]["limits"] = [-100.5, 100.5]
    mapping["robot"]["base"] = {"translation": [80.0, 120.0, 0.0], "rotation_vector": [0.0, 0.0, 3.1]}
    mapping["planes"] = [{"name": name, "normal": [0, 0, 1], "distance": 130.0} for name in PLANES]
    mapping["sensor"]["noise"] = 0.03
    content = tables()
    for i in range(6):
        content["poses"][f"q{i + 1}"] = np.linspace(-450 * DEG, 450 * DEG, N_POSES)
    content["poses"]["q1"] = np.linspace(-99.0, 99.0, N_POSES)
    content["scans"]["z"] = 18.0
    assert faults_of(tmp_path, mapping, content) == []


def test_a_tracker_far_away_and_a_turning_wrist_are_not_suspected(tmp_path: Path) -> None:
    """A tracker may be 60 m away, and one joint without limits may have turned almost four times."""
    content = tables("tracker")
    content["points"]["x"] += 60.0
    content["poses"]["q6"] = np.linspace(-25.0, 25.0, N_POSES)
    assert faults_of(tmp_path, description("tracker"), content) == []


@pytest.mark.parametrize("mark", [-0.0999999, 0.0, 9.9, -32.768])
def test_a_mark_for_no_value_is_suspected(tmp_path: Path, mark: float) -> None:
    """Every twenty-fifth point of a scanner has the mark that it writes for points that it did not see: one fault names it."""
    content = tables("line-laser")
    pose = np.repeat(content["poses"]["pose"].to_numpy(), 50)
    z = np.random.default_rng(8).uniform(0.2, 0.4, len(pose))
    content["scans"] = pd.DataFrame(
        {"pose": pose, "x": np.tile(np.linspace(-0.05, 0.05, 50), len(pose) // 50), "z": z}
    )
    assert not faults_of(tmp_path / "seen", description(), content)
    content["scans"].loc[::25, "z"] = mark
    (fault,) = faults_of(tmp_path / "marked", description(), content)
    assert columns_of([fault]) == {"z"} and "'no value'" in fault.message


def test_numbers_that_repeat_are_no_marks(tmp_path: Path) -> None:
    """Four rays at the same x in every scan, and planes that are parallel to the scanner at two distances, are no marks."""
    content = tables("line-laser")
    scans = content["scans"]
    index = scans.groupby("pose").cumcount()
    scans["x"] = 0.02 * (index % 4)
    scans["z"] = np.where(scans["pose"] % 2, 0.2, 0.4) + 1e-4 * (index % 3)
    assert not [fault for fault in faults_of(tmp_path, description(), content) if "no value" in fault.message]
