"""Robot descriptions: the robot that is read has the poses that pybullet computes, and faults are refused with their line."""

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from scalar.cli import cli
from scalar.data.dataset import read_dataset
from scalar.data.description import Description, check_description
from scalar.data.unit_suspicions import suspect_description
from scalar.errors import InvalidInput
from scalar.geometry.robot import GEOMETRY, Robot
from scalar.ingest.urdf import chain_between, read_urdf, robot_from_urdf
from tests.robot_descriptions import (
    ARMS,
    kinematics_alone,
    poses_by_pybullet,
    random_description,
    shipped,
)

POSES = 100


@pytest.mark.parametrize("name", ARMS)
def test_arms_that_pybullet_ships_have_its_poses(name, tmp_path):
    """The chain between two links, fixed joints included, agrees with pybullet's getLinkState to 1e-9 m."""
    pytest.importorskip("pybullet_data")
    path = shipped(name)
    if not path.exists():
        pytest.skip(f"this pybullet ships no {path.name}")
    _, base, tip = ARMS[name]
    document = read_urdf(path)
    chain = chain_between(document, base, tip)
    robot, _ = robot_from_urdf(path, base, tip)
    q = np.random.default_rng(1).uniform(-3, 3, (POSES, robot.n_joints))
    copy = kinematics_alone(path, tmp_path / f"{path.stem}.urdf")
    T = poses_by_pybullet(copy, chain.base, chain.tip, q, [joint.name for joint in chain.moving])
    np.testing.assert_allclose(robot.flange(q), T, atol=1e-9, rtol=0)


def test_a_gantry_has_the_poses_of_pybullet(tmp_path):
    """A gantry of three slides and a turn that pybullet ships; its limits, lower above upper, are refused until they are exchanged."""
    pybullet_data = pytest.importorskip("pybullet_data")
    text = (Path(pybullet_data.getDataPath()) / "cube_no_rotation.urdf").read_text(encoding="utf-8")
    path = tmp_path / "gantry.urdf"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InvalidInput, match="limits of joint 'x_to_world' are 1 and -1 m"):
        robot_from_urdf(path)
    path.write_text(text.replace('lower="1" upper="-1"', 'lower="-1" upper="1"'), encoding="utf-8")
    robot, _ = robot_from_urdf(path)
    assert robot.prismatic == (0, 1, 2)
    q = np.random.default_rng(1).uniform(-3, 3, (POSES, 4))
    copy = kinematics_alone(path, tmp_path / "alone.urdf")
    joints = ["x_to_world", "y_to_x", "z_to_y", "cube_to_z"]
    T = poses_by_pybullet(copy, "world", "baseLink", q, joints)
    np.testing.assert_allclose(robot.flange(q), T, atol=1e-9, rtol=0)


@pytest.mark.parametrize("seed", range(12))
def test_any_chain_has_the_poses_of_pybullet(seed, tmp_path):
    """Poses agree for axes in any direction, nearly parallel or intersecting, of any length, and for a base in or beside the chain."""
    pytest.importorskip("pybullet")
    rng = np.random.default_rng(seed)
    path = tmp_path / f"random{seed}.urdf"
    path.write_text(random_description(rng, int(rng.integers(1, 9))), encoding="utf-8")
    base = "aside" if seed % 2 else None
    robot, T_joint_link = robot_from_urdf(path, base, "tip")
    chain = chain_between(read_urdf(path), base, "tip")
    q = rng.uniform(-3, 3, (30, robot.n_joints))
    joints = [joint.name for joint in chain.moving]
    np.testing.assert_allclose(
        robot.flange(q), poses_by_pybullet(path, chain.base, "tip", q, joints), atol=1e-9, rtol=0
    )
    last = poses_by_pybullet(path, chain.base, chain.moving[-1].child, q, joints)
    np.testing.assert_allclose(robot.frames(q)[:, -1] @ T_joint_link[-1], last, atol=1e-9, rtol=0)


@pytest.mark.parametrize("seed", range(6))
def test_a_robot_that_was_read_is_valid_in_a_dataset(seed, tmp_path):
    """Its mapping passes the checks of dataset.yaml, and describes the same robot."""
    rng = np.random.default_rng(100 + seed)
    path = tmp_path / "random.urdf"
    path.write_text(random_description(rng, 6), encoding="utf-8")
    robot, _ = robot_from_urdf(path, None, "tip")
    plane = [
        {"name": n, "normal": v, "distance": 0.0} for n, v in zip("xyz", np.eye(3).tolist(), strict=True)
    ]
    mapping = {
        "format": "scalar-dataset/1",
        "name": "cell",
        "robot": robot.to_mapping(),
        "sensor": {"kind": "line-laser"},
        "planes": plane,
    }
    description = Description(mapping, {})
    check_description(description)
    suspect_description(description)
    assert not description.faults
    q = rng.uniform(-3, 3, (20, 6))
    np.testing.assert_allclose(Robot.from_mapping(robot.to_mapping()).flange(q), robot.flange(q), atol=1e-12)


def test_the_table_of_the_panda_is_that_of_its_maker():
    """The URDF of the Panda gives Franka's modified-DH table: https://frankaemika.github.io/docs/control_parameters.html."""
    pytest.importorskip("pybullet_data")
    robot, _ = robot_from_urdf(shipped("panda"), "panda_link0", "panda_link8")
    right = np.pi / 2
    table = {
        "a": [0, 0, 0, 0.0825, -0.0825, 0, 0.088],
        "alpha": [0, -right, right, right, -right, right, right],
        "d": [0.333, 0, 0.316, 0, 0.384, 0, 0.107],
        "theta": [0] * 7,
        "beta": [0] * 7,
    }
    np.testing.assert_allclose(robot.geometry, [table[kind] for kind in GEOMETRY], atol=1e-9)
    np.testing.assert_array_equal(robot.T_n_flange, np.eye(4))


def urdf(joints, links="abcd"):
    """Return a description of links and joints ``(name, type, parent, child, content)``."""
    body = "".join(f'<link name="{name}"/>\n' for name in links)
    for name, kind, parent, child, content in joints:
        body += f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>{content}</joint>\n'
    return f'<?xml version="1.0"?>\n<robot name="r">\n{body}</robot>\n'


LIMIT = '<limit lower="-1" upper="1" effort="1" velocity="1"/>'
GOOD = [("j1", "revolute", "a", "b", LIMIT), ("j2", "continuous", "b", "c", ""), ("f", "fixed", "c", "d", "")]


def with_second(kind="revolute", content=LIMIT, parent="b", child="c"):
    """Return the good joints with the second one replaced; it is in line 8."""
    return urdf([GOOD[0], ("j2", kind, parent, child, content), GOOD[2]])


BOMB = '<?xml version="1.0"?>\n<!DOCTYPE robot [<!ENTITY a "ha"><!ENTITY b "&a;&a;">]>\n<robot name="&b;"><link name="a"/></robot>'
REFUSED = {
    "bomb": (BOMB, "line 2: declares a document type or an entity"),
    "dtd": ('<!DOCTYPE robot SYSTEM "http://127.0.0.1/x.dtd">\n<robot name="r"/>', "line 1: declares a document type"),
    "no xml": ("hello", "not XML"),
    "cut": (urdf(GOOD)[:-20], "not XML"),
    "empty": ("", "not XML"),
    "other root": ('<sdf version="1"/>', "its root is 'sdf'"),
    "xacro": ('<robot xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:include filename="x"/></robot>', "xacro robot"),
    "nan": (with_second(content='<origin xyz="0 nan 0"/>' + LIMIT), "line 8: xyz of <origin> in joint 'j2'"),
    "infinite": (with_second(content='<origin xyz="0 1e999 0"/>' + LIMIT), "write three numbers"),
    "two numbers": (with_second(content='<origin rpy="0 0"/>' + LIMIT), "rpy of <origin> in joint 'j2' is '0 0'"),
    "millimetres": (with_second(content='<origin xyz="0 0 400"/>' + LIMIT), "are these millimetres?"),
    "no axis": (with_second(content='<axis xyz="0 0 0"/>' + LIMIT), "the axis of joint 'j2' has no direction"),
    "limits": (with_second(content='<limit lower="1" upper="-1"/>'), "the limits of joint 'j2' are 1 and -1"),
    "planar": (with_second("planar"), "line 8: joint 'j2' is planar"),
    "floating": (with_second("floating"), "joint 'j2' is floating"),
    "unknown type": (with_second("hinge"), "the unknown type 'hinge'"),
    "mimic": (with_second(content=LIMIT + '<mimic joint="j1"/>'), "joint 'j2' mimics 'j1'"),
    "missing link": (with_second(child="cc"), "the child of joint 'j2' is 'cc', and there is no such link; did you mean 'c'?"),
    "two parents": (urdf([*GOOD, ("j9", "revolute", "a", "c", LIMIT)]), "line 10: the link 'c' is the child of joint 'j2' and of 'j9'"),
    "circle": (urdf([*GOOD, ("j9", "revolute", "d", "a", LIMIT)]), "is above itself: a closed loop"),
    "two names": (urdf([*GOOD, ("j2", "fixed", "d", "e", "")], "abcde"), "the joint 'j2' is already defined in line 9"),
    "no parent": (urdf(GOOD).replace('<parent link="b"/>', ""), "joint 'j2' has no parent"),
    "two roots": (urdf(GOOD, "abcde"), "2 links have no parent ('a', 'e'); choose one with --base"),
    "branches": (urdf([*GOOD, ("j9", "fixed", "b", "e", "")], "abcde"), "ends in 2 links ('d', 'e'); choose one with --tip"),
    "nothing turns": (urdf([("f", "fixed", "a", "b", "")], "ab"), "0 joints move"),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_a_faulty_description_is_refused_with_its_line(case, tmp_path):
    """One line says what is wrong and where; no file that the description refers to is opened."""
    text, message = REFUSED[case]
    path = tmp_path / "in.urdf"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InvalidInput) as refusal:
        robot_from_urdf(path)
    assert message in str(refusal.value)
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize(
    "base, tip, message",
    [
        ("c", "b", "exchange --base and --tip"),
        ("b", "x", "no link is called 'x'"),
        ("bb", "d", "did you mean 'b'?"),
        ("b", "e", "choose a --tip that the --base carries"),
    ],
)
def test_links_that_end_no_chain_are_refused(base, tip, message, tmp_path):
    """Links that do not exist, or are in the wrong order, are refused with advice."""
    path = tmp_path / "in.urdf"
    path.write_text(urdf([*GOOD, ("j9", "fixed", "a", "e", "")], "abcde"), encoding="utf-8")
    with pytest.raises(InvalidInput, match=f".*{message.replace('?', '.')}"):
        robot_from_urdf(path, base, tip)


def test_a_fixed_joint_keeps_no_limits(tmp_path):
    """Exporters write limits of 0 and 0, a mimic or an axis of a joint that is fixed; nothing reads them."""
    useless = '<axis xyz="0 0 0"/><limit lower="0" upper="0"/><mimic joint="j1"/>'
    robots = []
    for content in ("", useless):
        path = tmp_path / "in.urdf"
        path.write_text(urdf([*GOOD[:2], ("f", "fixed", "c", "d", content)]), encoding="utf-8")
        robots.append(robot_from_urdf(path)[0])
    np.testing.assert_array_equal(robots[0].geometry, robots[1].geometry)
    np.testing.assert_array_equal(robots[0].limits, robots[1].limits)


def test_a_document_type_in_another_encoding_is_refused(tmp_path):
    """A declaration that a search of the bytes does not find is found by the parser."""
    path = tmp_path / "in.urdf"
    path.write_bytes(BOMB.replace('version="1.0"', 'version="1.0" encoding="utf-16"').encode("utf-16"))
    with pytest.raises(InvalidInput, match="declares a document type"):
        robot_from_urdf(path)


def test_long_files_are_refused_unread_and_deep_ones_without_a_crash(tmp_path):
    """Five megabytes, and elements nested by the thousand, give one line each."""
    path = tmp_path / "in.urdf"
    path.write_text(urdf(GOOD) + "<!--" + "x" * 5_000_000 + "-->", encoding="utf-8")
    with pytest.raises(InvalidInput, match="longer than 4 MB"):
        robot_from_urdf(path)
    path.write_text("<robot>" + "<a>" * 100_000, encoding="utf-8")
    with pytest.raises(InvalidInput, match="not XML"):
        robot_from_urdf(path)


def test_joints_beside_the_chain_are_ignored(tmp_path):
    """A mimicking prismatic finger outside the chain changes nothing."""
    path = tmp_path / "in.urdf"
    path.write_text(urdf(GOOD), encoding="utf-8")
    alone, _ = robot_from_urdf(path, "a", "d")
    finger = ("g", "prismatic", "d", "e", LIMIT + '<mimic joint="j1"/>')
    path.write_text(urdf([*GOOD, finger], "abcde"), encoding="utf-8")
    robot, _ = robot_from_urdf(path, "a", "d")
    np.testing.assert_array_equal(robot.geometry, alone.geometry)


MAPPING = """
format: scalar-mapping/1
poses:
  columns:
    q1: {column: a, unit: deg}
    q2: {column: b, unit: deg}
    x: {column: x, unit: mm}
    y: {column: y, unit: mm}
    z: {column: z, unit: mm}
dataset_units: {length: mm, angle: deg}
dataset:
  name: cell
  sensor: {kind: tracker, nominal_pose: {translation: [0, 0, 10], rotation_vector: [0, 0, 0]}}
"""


def test_a_measurement_is_imported_with_the_robot_of_a_description(tmp_path):
    """A mapping without a robot takes that of --urdf; with two robots, with none, or with --tip but no --urdf, it is refused."""
    path, table, mapping = tmp_path / "in.urdf", tmp_path / "t.csv", tmp_path / "m.yaml"
    path.write_text(urdf(GOOD), encoding="utf-8")
    mapping.write_text(MAPPING, encoding="utf-8")
    rows = [f"{i},{10 * i},{100 + i},{i},{-i}" for i in range(9)]
    table.write_text("\n".join(["a,b,x,y,z", *rows]), encoding="utf-8")

    def run(*options):
        result = CliRunner().invoke(
            cli, ["import", str(mapping), str(table), "-o", str(tmp_path / "cell"), *options]
        )
        return result.exit_code, result.output

    status, said = run("--urdf", str(path), "--tip", "d")
    assert status == 0, said
    robot = read_dataset(tmp_path / "cell").robot
    np.testing.assert_array_equal(robot.geometry, robot_from_urdf(path, None, "d")[0].geometry)
    assert run()[0] == 2
    assert "--urdf" in run("--tip", "d")[1]
    mapping.write_text(MAPPING + "  robot: {name: x, joints: []}\n", encoding="utf-8")
    status, said = run("--urdf", str(path))
    assert status == 2 and "leave out --urdf" in said
