"""`scalar init` with a robot of one's own: from a URDF, or from a table of joints."""

import re

import numpy as np
import pytest

from scalar.data.io.plain_yaml import load_yaml
from scalar.geometry.robot import Robot
from scalar.ingest.urdf import robot_from_urdf
from scalar.robots import read_arm
from tests.cli.running import begun, run
from tests.robot_descriptions import shipped


def test_a_robot_from_a_urdf(tmp_path):
    """The robot in dataset.yaml has its flange where the reader of URDF has it."""
    pytest.importorskip("pybullet_data")
    path, base, tip = shipped("xarm6"), "link_base", "link6"
    folder = begun(tmp_path / "cell", "--urdf", path, "--base", base, "--tip", tip)
    written = Robot.from_mapping(load_yaml(folder / "dataset.yaml")["robot"])
    q = np.random.default_rng(1).uniform(-2, 2, (20, written.n_joints))
    assert np.allclose(written.flange(q), robot_from_urdf(path, base, tip)[0].flange(q), atol=1e-11)
    # Rounding errors of the conversion are not written.
    assert not re.search(r"\de-1\d", (folder / "dataset.yaml").read_text())
    joints = load_yaml(folder / "dataset.yaml")["robot"]["joints"]
    assert [joint["name"] for joint in joints] == [f"joint{i}" for i in range(1, 7)]


def test_a_robot_from_a_urdf_says_between_which_links(tmp_path):
    """Without --base and --tip the links are chosen, and the flange may be another one than the last."""
    links = "".join(f'<link name="{name}"/>' for name in ("world", "arm", "gripper"))
    turning = '<joint name="j" type="continuous"><parent link="world"/><child link="arm"/><axis xyz="0 0 1"/></joint>'
    fixed = '<joint name="g" type="fixed"><parent link="arm"/><child link="gripper"/></joint>'
    path = tmp_path / "r.urdf"
    path.write_text(f'<robot name="r">{links}{turning}{fixed}</robot>')
    result = run("init", tmp_path / "cell", "--urdf", path, "--sensor", "tracker")
    assert "From r.urdf, world to gripper." in result.output and "name the flange by --tip" in result.output
    result = run("init", tmp_path / "other", "--urdf", path, "--tip", "arm", "--sensor", "tracker")
    assert "From r.urdf, world to arm." in result.output and "--tip" not in result.output


def test_limits_that_a_urdf_does_not_state_are_called_assumed(tmp_path):
    """The terminal and dataset.yaml name the joints without limits, and those alone; with limits in all joints nothing is said."""
    joint = '<joint name="{0}" type="{1}"><parent link="l{2}"/><child link="l{3}"/><axis xyz="0 {4} 1"/>{5}</joint><link name="l{3}"/>'
    limit = '<limit lower="-1" upper="2" effort="1" velocity="1"/>'

    def described(name, *kinds):
        joints = [joint.format(f"j{i}", *kinds[i][:1], i, i + 1, i % 2, kinds[i][1]) for i in range(3)]
        (tmp_path / name).write_text(f'<robot name="arm"><link name="l0"/>{"".join(joints)}</robot>')
        result = run("init", tmp_path / f"{name}-cell", "--urdf", tmp_path / name, "--sensor", "tracker")
        assert result.exit_code == 0, result.output
        return result.stdout, (tmp_path / f"{name}-cell" / "dataset.yaml").read_text()

    for text in described("some", ("revolute", limit), ("continuous", limit), ("revolute", "")):
        assert "No limits stated: j1 and j2." in text
    for text in described("all", *[("revolute", limit)] * 3):
        assert "No limits stated" not in text


@pytest.mark.parametrize(
    ("units", "factor", "names"),
    [
        (("mm", "deg"), (1e3, 180 / np.pi), ["1", "2", "3", "4", "5", "6"]),
        (("m", "rad"), (1.0, 1.0), ["J1", "J2", "J3", "J4", "J5", "J6"]),
        (("m", "deg"), (1.0, 180 / np.pi), ["pan", "lift", "elbow", "wrist_1", "wrist_2", "wrist_3"]),
        (("m", "rad"), (1.0, 1.0), ["J0", "J1", "J2", "J3", "J4", "J5"]),
        (("m", "rad"), (1.0, 1.0), ["E1", "A1", "A2", "A3", "A4", "A5"]),
    ],
)
def test_a_robot_from_a_table(units, factor, names, tmp_path):
    """Lengths and angles in either unit give the same robot, and the number or the name of each joint may stand in a column."""
    joints = read_arm("ur5e").mapping["joints"]
    keys = ("a", "alpha", "d", "theta")
    header = ["joint", *(f"{key}_{units[0] if key in 'ad' else units[1]}" for key in keys)]
    rows = [
        ",".join([names[i], *(repr(j[k] * factor[k not in "ad"]) for k in keys)])
        for i, j in enumerate(joints)
    ]
    table = tmp_path / "arm.csv"
    table.write_text("\n".join([",".join(header), *rows]) + "\n")
    folder = begun(tmp_path / "cell", "--dh", table, "--convention", "modified-dh")
    written = load_yaml(folder / "dataset.yaml")["robot"]
    assert written["name"] == "arm"
    for joint, wanted in zip(written["joints"], joints, strict=True):
        assert all(abs(joint[key] - wanted[key]) < 1e-12 for key in joint)


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("a_mm,alpha_deg,d_mm\n0,0,0\n", "theta_rad or theta_deg"),
        ("a_mm,a_m,alpha_deg,d_mm,theta_deg\n0,0,0,0,0\n", "twice"),
        ("a_mm,alpha_deg,d_mm,theta_deg\n", "no rows"),
        ("a_mm,alpha_deg,d_mm,theta_deg,lower_deg\n0,0,0,0,0\n", "lowest angle without a highest"),
        ("a_mm,alpha_deg,d_mm,theta_deg,lower_deg,upper_deg\n0,0,0,0,10,-10\n", "row 2"),
        (
            "a_mm,alpha_deg,d_mm,theta_deg,type,lower_deg,upper_deg\n400,0,0,0,revolute,-90,90\n0,0,0,0,prismatic,20,300\n",
            "row 3, column lower_deg: this joint slides",
        ),
        (
            "a_mm,alpha_deg,d_mm,theta_deg,lower_deg,upper_deg\n400,0,0,0,-90,\n",
            "row 2: one limit of the joint is empty",
        ),
        (
            "a_mm,alpha_deg,d_mm,theta_deg,lower_deg,upper_deg\n400,,0,0,-90,90\n",
            "row 2, column alpha_deg: an empty cell",
        ),
        (
            "a_mm,alpha_deg,d_mm,theta_deg,lower_deg,upper_deg\n400,0,0,0,-90,inf\n",
            "column upper_deg: not a finite number",
        ),
        ("a,alpha,d,theta\n0,0,0,0\n", "unknown column"),
        ("a_mm,alpha_deg,d_mm,theta_deg\n0,x,0,0\n", "row 2"),
        (
            "a_mm,alpha_deg,d_mm,theta_deg\n0.4,90,0.3,0\n1,0,0.3,0\n",
            "call the columns a_m, d_m in place of a_mm, d_mm",
        ),
        (
            "a_m,alpha_deg,d_mm,theta_deg\n400,90,300,0\n1000,0,300,0\n",
            "call the column a_mm in place of a_m",
        ),
        ("joint,a_mm,alpha_deg,d_mm,theta_deg\n2,0,0,0,0\n1,0,0,0,0\n", "base to flange"),
        ("joint,a_mm,alpha_deg,d_mm,theta_deg\nJ2,0,0,0,0\nJ1,0,0,0,0\n", "base to flange"),
        (
            "joint,a_mm,alpha_deg,d_mm,theta_deg\nJ1,0,0,9,0\nJ3,0,0,9,0\n",
            "but J1, J3; write them base to flange",
        ),
        ("joint,a_mm,alpha_deg,d_mm,theta_deg\n2.0,0,0,0,0\n1.0,0,0,0,0\n", "base to flange"),
        ("joint,a_mm,alpha_deg,d_mm,theta_deg\n1,0,0,0,0\n,0,0,0,0\n", "an empty cell"),
        ("a_mm,alpha_deg,d_mm,theta_deg,Min_deg,max_deg\n400,90,300,0,-90,90\n", "did you mean 'lower_deg'?"),
        ("a_mm,alpha_deg,d_mm,theta_deg,min_deg,max_deg\n400,90,300,0,-90,90\n", "did you mean 'upper_deg'?"),
    ],
)
def test_a_table_at_fault_is_refused(text, word, tmp_path):
    """A column or unit that is missing, ambiguous or unknown is named, and no folder is left."""
    table = tmp_path / "arm.csv"
    table.write_text(text)
    result = run("init", tmp_path / "cell", "--dh", table, "--convention", "modified-dh", "--sensor", "probe")
    assert result.exit_code == 2 and word in result.stderr and "Traceback" not in result.output
    assert not (tmp_path / "cell").exists()


@pytest.mark.parametrize(
    ("column", "twists", "suspect"),
    [
        ("alpha_deg", ("-1.5708", "0", "1.57"), True),
        ("alpha_deg", ("3.1416", "1.5707963", "0"), True),
        ("alpha_deg", ("-90", "0", "90"), False),
        ("alpha_deg", ("1.5708", "0", "90"), False),
        ("alpha_deg", ("0.3", "0", "1.2"), False),
        ("alpha_deg", ("0", "0", "0"), False),
        ("alpha_rad", ("-1.5708", "0", "1.5708"), False),
    ],
)
def test_right_angles_in_radians_under_degrees_are_suspected(column, twists, suspect, tmp_path):
    """If every twist in degrees is a number such as 1.5708, a line asks for the units; the folder is made all the same."""
    rows = [f"{0.1 + 0.2 * i},{alpha},0.1,0" for i, alpha in enumerate(twists)]
    table = tmp_path / "arm.csv"
    table.write_text("\n".join([f"a_m,{column},d_m,theta_rad", *rows]), encoding="utf-8")
    command = ["init", tmp_path / "cell", "--dh", table, "--convention", "standard-dh", "--sensor", "tracker"]
    result = run(*command)
    assert result.exit_code == 0, result.output
    assert ("Check the units" in result.output and "alpha_rad" in result.output) == suspect
    assert (tmp_path / "cell" / "dataset.yaml").exists()
