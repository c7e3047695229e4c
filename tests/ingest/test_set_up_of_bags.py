"""A recording that does not fit its set-up as described: the message names the order, sign or axis that makes it fit, and nothing is written."""

import numpy as np
import pytest

from scalar.data.io.plain_yaml import dump_yaml, load_yaml
from scalar.geometry.se3 import log_so3, transform_from_rotation_vector
from tests.ingest.bags import ORDER, run


def test_a_wrong_order_of_joints_is_refused_with_the_right_one(workcell, bag, tmp_path):
    """With two joints exchanged the exit status is 3, and the message has the most frequent reason and the order that puts scans on planes."""
    wrong = ORDER.split(",")
    wrong[1], wrong[2] = wrong[2], wrong[1]
    status, said = run("import-bag", workcell, bag, "--joint-names", ",".join(wrong), "-o", tmp_path / "d")
    assert status == 3 and not (tmp_path / "d").exists()
    lines = said.splitlines()
    assert "stops became poses" in lines[0] and "on no plane" in lines[0] and "--joint-names" in lines[0]
    assert f"--joint-names {ORDER}" in lines[1]


@pytest.mark.parametrize("joint", [2, 3])
def test_a_joint_that_counts_the_other_way_is_told_with_its_remedy(joint, workcell, bag, tmp_path):
    """A table whose joint counts the other way: it is said, and with what it says to change the whole campaign comes back."""
    mapping = load_yaml(workcell)
    joints = mapping["robot"]["joints"]
    assert mapping["robot"]["convention"] == "modified-dh"

    def count_otherwise():
        joints[joint - 1]["d"] *= -1.0
        joints[joint - 1]["theta"] *= -1.0
        joints[joint - 1]["alpha"] += np.pi
        joints[joint]["alpha"] -= np.pi

    count_otherwise()
    dump_yaml(mapping, tmp_path / "dataset.yaml")
    status, said = run("import-bag", tmp_path / "dataset.yaml", bag, "-o", tmp_path / "d")
    assert status == 3 and "do not fit the set-up as described" in said
    told = said.splitlines()[1]
    assert f"12 of 12 scans would lie on a plane with joint {joint} (joint_{joint}) counted" in told
    assert f"signs of d and theta of joint {joint}, add 3.141593 to alpha of joint {joint}" in told
    assert f"subtract it from alpha of joint {joint + 1}" in told
    count_otherwise()
    dump_yaml(mapping, tmp_path / "dataset.yaml")
    status, said = run("import-bag", tmp_path / "dataset.yaml", bag, "-o", tmp_path / "d")
    assert status == 0, said


def test_wrong_axes_of_the_scanner_are_refused_with_the_right_ones(workcell, bag, tmp_path):
    """If the nominal pose is turned by half a turn about x, the message says that z of the scan is reversed, and nothing is written."""
    mapping = load_yaml(workcell)
    pose = mapping["sensor"]["nominal_pose"]
    T = transform_from_rotation_vector(pose["translation"], pose["rotation_vector"])
    turned = T @ np.diag([1.0, -1.0, -1.0, 1.0])
    pose["rotation_vector"] = log_so3(turned[None, :3, :3])[0].tolist()
    dump_yaml(mapping, tmp_path / "dataset.yaml")
    status, said = run("import-bag", tmp_path / "dataset.yaml", bag, "-o", tmp_path / "d")
    assert status == 3 and not (tmp_path / "d").exists(), said
    assert "z of the scan" in said and "sensor.nominal_pose" in said


def test_a_reversed_x_axis_is_refused_though_every_scan_is_near_a_plane(workcell, bag, tmp_path):
    """If the nominal pose is turned by half a turn about z, scans are as near to the planes as before, with other slopes; x is named as reversed."""
    mapping = load_yaml(workcell)
    pose = mapping["sensor"]["nominal_pose"]
    T = transform_from_rotation_vector(pose["translation"], pose["rotation_vector"])
    turned = T @ np.diag([-1.0, -1.0, 1.0, 1.0])
    pose["rotation_vector"] = log_so3(turned[None, :3, :3])[0].tolist()
    dump_yaml(mapping, tmp_path / "dataset.yaml")
    status, said = run("import-bag", tmp_path / "dataset.yaml", bag, "-o", tmp_path / "d")
    assert status == 3 and not (tmp_path / "d").exists(), said
    assert "12 of 12 scans would lie on a plane with x of the scan reversed" in said
    status, said = run("import-bag", tmp_path / "dataset.yaml", bag, "--accept-losses", "-o", tmp_path / "d")
    assert status == 0 and (tmp_path / "d").exists(), said
