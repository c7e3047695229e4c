"""A calibration as a URDF: pybullet puts the sensor where the calibration predicts it, and the rest of the file is as it was."""

import re
import xml.etree.ElementTree as ElementTree
from dataclasses import replace

import numpy as np
import pytest

from scalar.data.io.plain_yaml import load_yaml
from scalar.effects.axis_nonparallel import AxisNonparallel
from scalar.effects.joint_compliance import JointCompliance
from scalar.effects.joint_harmonic import JointHarmonic
from scalar.effects.sensor_slip import SensorSlip
from scalar.effects.thermal_drift import ThermalDrift
from scalar.estimation.fixed_parameter import BASE_NOT_SHOWN
from scalar.export.urdf import _in_digits
from scalar.geometry.robot import Robot
from scalar.ingest.urdf import chain_between, read_urdf, robot_from_urdf
from tests.calibrated_arms import calibrated, rigid
from tests.cli.correcting import run
from tests.robot_configs import ROBOT_CONFIGS
from tests.robot_descriptions import (
    ARMS,
    kinematics_alone,
    poses_by_pybullet,
    random_description,
    shipped,
)

HARMONIC = JointHarmonic(2, (1, 3), coefficients=np.array([3e-4, 1e-4, 0.0, 2e-4]))
COMPLIANCE = JointCompliance(((2, 3), (3, 3)), coefficients=np.array([1e-3, 2e-4, 5e-4, 0.0]))


def exported(calibration, urdf, folder, *options):
    """Return the path of the description that ``scalar export`` makes, and what it said."""
    path, output = folder / "calibration.json", folder / "calibrated.urdf"
    calibration.save(path)
    status, said = run("export", path, "--urdf", urdf, *options, "-o", output)
    assert status == 0, said
    return output, said


def sensor_by_pybullet(path, base, q, folder):
    """Return where pybullet puts the sensor's link."""
    copy = kinematics_alone(path, folder / f"alone-{path.name}")
    chain = chain_between(read_urdf(path), base, "scalar_sensor")
    return poses_by_pybullet(copy, chain.base, "scalar_sensor", q, [joint.name for joint in chain.moving])


@pytest.mark.parametrize("name", ["iiwa", "panda", "xarm6"])
def test_pybullet_puts_the_sensor_where_the_calibration_predicts_it(name, tmp_path):
    """The file agrees with `predict`, effects left out, to 1e-9 m over 1000 poses."""
    pytest.importorskip("pybullet_data")
    _, base, tip = ARMS[name]
    rng = np.random.default_rng(1)
    robot, _ = robot_from_urdf(shipped(name), base, tip)
    calibration = calibrated(robot, rng, (HARMONIC, COMPLIANCE))
    path, _ = exported(calibration, shipped(name), tmp_path, "--base", base, "--tip", tip)
    low, high = robot.limits.T
    q = rng.uniform(low, high, (1000, robot.n_joints))
    T = sensor_by_pybullet(path, base, q, tmp_path)
    np.testing.assert_allclose(T, rigid(calibration).predict(q), atol=1e-9, rtol=0)


@pytest.mark.parametrize("seed", range(10))
def test_any_description_holds_its_calibration(seed, tmp_path):
    """The exported file agrees for axes in any direction, fixed joints between, a tip that turns or not, and a base in the chain or outside it."""
    pytest.importorskip("pybullet")
    rng = np.random.default_rng(seed)
    urdf = tmp_path / f"random{seed}.urdf"
    urdf.write_text(random_description(rng, int(rng.integers(2, 8))), encoding="utf-8")
    base = "aside" if seed % 2 else "l0"
    robot, _ = robot_from_urdf(urdf, base, "tip")
    calibration = calibrated(robot, rng)
    path, said = exported(calibration, urdf, tmp_path, "--base", base, "--tip", "tip")
    assert "holds the whole calibration" in said
    q = rng.uniform(-3, 3, (50, robot.n_joints))
    T = sensor_by_pybullet(path, base, q, tmp_path)
    np.testing.assert_allclose(T, calibration.predict(q), atol=1e-9, rtol=0)


def test_frames_that_the_data_do_not_determine_are_said(tmp_path):
    """Who checks the file by kinematics of his own finds tool0 off by a constant, and is told why; a calibration that fixed nothing says nothing."""
    robot, _ = robot_from_urdf(description(tmp_path), "l0", "tip")
    calibration = calibrated(robot, np.random.default_rng(3))
    options = (description(tmp_path), tmp_path, "--base", "l0", "--tip", "tip")
    _, said = exported(replace(calibration, gauge=()), *options)
    assert "not known" not in said and "not determined" not in said
    last = f"d_{robot.n_joints}"
    gauge = tuple(
        {"held": name, "reason": reason, "moves_with": [], "cause": "structural"}
        for name, reason in (("theta_1", BASE_NOT_SHOWN), (last, "only its combination with sensor_z"))
    )
    _, said = exported(replace(calibration, gauge=gauge), *options)
    assert f"of the flange itself {last} is not known" in said and "off by a constant" in said
    assert "where the base stands is not determined" in said


def description(folder):
    """Return the path of a description with the links ``l0`` to ``tip``."""
    path = folder / "arm.urdf"
    path.write_text(random_description(np.random.default_rng(5), 6), encoding="utf-8")
    return path


def test_a_description_whose_right_angles_are_rounded_holds_it_too(tmp_path):
    """If the arm was calibrated from its maker's table, it is exported into a description that writes right angles as 1.5708."""
    pytest.importorskip("pybullet_data")
    robot, _ = robot_from_urdf(shipped("panda"), "panda_link0", "panda_link8")
    text = shipped("panda").read_text(encoding="utf-8")
    rounded, n = re.subn(r"1\.57079632679", "1.5708", text)
    assert n
    urdf = tmp_path / "rounded.urdf"
    urdf.write_text(rounded, encoding="utf-8")
    calibration = calibrated(robot, np.random.default_rng(3))
    path, _ = exported(calibration, urdf, tmp_path, "--base", "panda_link0", "--tip", "panda_link8")
    q = np.random.default_rng(4).uniform(-2, 2, (50, 7))
    T = sensor_by_pybullet(path, "panda_link0", q, tmp_path)
    np.testing.assert_allclose(T, calibration.predict(q), atol=1e-9, rtol=0)


def test_only_origins_of_the_chain_change(tmp_path):
    """Comments, meshes, limits, axes and everything beside the chain stay as they were, and a second export changes nothing."""
    pytest.importorskip("pybullet_data")
    _, base, tip = ARMS["panda"]
    robot, _ = robot_from_urdf(shipped("panda"), base, tip)
    calibration = calibrated(robot, np.random.default_rng(1))
    text = shipped("panda").read_text(encoding="utf-8")
    urdf = tmp_path / "in.urdf"
    urdf.write_text(text.replace("</robot>", "<!-- kept --><gazebo x='1'/></robot>"), encoding="utf-8")
    path, said = exported(calibration, urdf, tmp_path, "--base", base, "--tip", tip)
    assert f"a link 'scalar_sensor' was added, fixed to '{tip}'" in said
    before, after = (ElementTree.parse(p).getroot() for p in (urdf, path))
    assert "<!-- kept -->" in path.read_text(encoding="utf-8")
    moved = {joint.name for joint in chain_between(read_urdf(urdf), base, tip).joints}
    added = {"scalar_sensor", "scalar_sensor_joint"}
    rest = [e for e in after if e.get("name") not in added]
    assert len(rest) == len(list(before))
    for old, new in zip(before, rest, strict=True):
        if old.get("name") in moved:
            for root in (old, new):
                for origin in root.findall("origin"):
                    root.remove(origin)
        assert ElementTree.tostring(old).strip() == ElementTree.tostring(new).strip()
    (tmp_path / "again").mkdir()
    same = replace(calibration, model=replace(calibration.model, nominal=calibration.model.robot))
    again, said = exported(same, path, tmp_path / "again", "--base", base, "--tip", tip)
    assert "was added" not in said and "'scalar_sensor' stands where" in said
    q = np.random.default_rng(2).uniform(-2, 2, (20, 7))
    np.testing.assert_allclose(
        sensor_by_pybullet(again, base, q, tmp_path), calibration.predict(q), atol=1e-9, rtol=0
    )


def test_what_a_description_cannot_hold_is_listed_with_its_size(tmp_path):
    """The size of an effect is the distance between predictions with and without it at random poses."""
    robot = Robot.from_mapping(load_yaml(ROBOT_CONFIGS / "vs060.yaml"))
    tilt = AxisNonparallel(3, coefficients=np.array([2e-3]))
    slip = SensorSlip(10.0, coefficients=np.array([1e-3, 0, 0, 0, 2e-3, 0]))
    heat = ThermalDrift("temperature", 20.0, coefficients=np.array([2e-5]))
    calibration = calibrated(robot, np.random.default_rng(1), (tilt, slip, HARMONIC, heat))
    path, table = tmp_path / "calibration.json", tmp_path / "dh.md"
    calibration.save(path)
    status, said = run("export", path, "-o", table)
    assert status == 0, said
    included = [line for line in said.splitlines() if "included in the geometry" in line]
    assert len(included) == 2 and "tilt" in included[0] and "slip" in included[1]
    assert "give --at temperature=NUMBER" in said
    with_heat = run("export", path, "-o", table, "--at", "temperature=30")[1]
    assert "included in the geometry: thermal drift" in with_heat
    line = next(line for line in said.splitlines() if "harmonic" in line)
    size = float(re.search(r"([0-9.]+) mm RMS", line).group(1))
    low, high = robot.limits.T
    q = np.random.default_rng(5).uniform(low, high, (20_000, 6))
    without = replace(calibration, model=replace(calibration.model, effects=(tilt, slip)))
    with_it = replace(calibration, model=replace(calibration.model, effects=(tilt, slip, HARMONIC)))
    moved = np.linalg.norm((with_it.predict(q) - without.predict(q))[:, :3, 3], axis=1)
    assert size == pytest.approx(1e3 * np.sqrt(np.mean(moved**2)), rel=0.1)


@pytest.mark.parametrize(
    ("joint", "turn", "words"),
    [
        ("flange", "0 0 3.141592653589793", "the frame of the flange alone is another one"),
        ("mount", "0 1.5707963267948966 0", "the frame of the base alone is another one"),
        ("j3", "0 0 0.1", "give the description of the same arm"),
    ],
)
def test_a_description_that_differs_in_one_frame_is_refused_with_that_frame(joint, turn, words, tmp_path):
    """A tip or a base that is turned is named as the one difference. If a joint's frame is turned, it is not the same arm."""

    def description(name, **turns):
        fixed = {"mount": "0 0 0", "j3": "0 0 0", "flange": "0 0 0", **turns}
        links = "".join(f'<link name="{link}"/>' for link in ("base", "foot", "l1", "l2", "l3", "tip"))
        joints = [
            ("mount", "fixed", "base", "foot"),
            ("j1", "continuous", "foot", "l1"),
            ("j2", "continuous", "l1", "l2"),
        ]
        joints += [("j3", "continuous", "l2", "l3"), ("flange", "fixed", "l3", "tip")]
        text = "".join(
            f'<joint name="{joint}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
            f'<origin xyz="0.1 0.05 0.3" rpy="{fixed.get(joint, "0 0 0")}"/><axis xyz="{k % 2} 0 {1 - k % 2}"/></joint>'
            for k, (joint, kind, parent, child) in enumerate(joints)
        )
        (tmp_path / name).write_text(f'<robot name="arm">{links}{text}</robot>', encoding="utf-8")
        return tmp_path / name

    robot, _ = robot_from_urdf(str(description("in.urdf")), "base", "tip")
    calibrated(robot, np.random.default_rng(1)).save(tmp_path / "calibration.json")
    other, output = description("other.urdf", **{joint: turn}), tmp_path / "out.urdf"
    status, said = run(
        "export",
        tmp_path / "calibration.json",
        "--urdf",
        other,
        "--base",
        "base",
        "--tip",
        "tip",
        "-o",
        output,
    )
    assert status == 2 and words in said, said
    assert not output.exists()


@pytest.mark.parametrize(("number", "said"), [(1358.2, "1358"), (180.0, "180"), (0.01234, "0.0123")])
def test_a_difference_is_said_without_powers_of_ten(number, said):
    """A metre and more in millimetres is no 1.36e+03."""
    assert _in_digits(number) == said


@pytest.mark.parametrize(
    "options, words",
    [
        (["-o", "out.urdf"], "give it as --urdf"),
        (["-o", "out.txt"], "says what to write"),
        (["--tip", "x", "-o", "out.md"], "are for a .urdf"),
        (["--urdf", "missing.urdf", "-o", "out.urdf"], "no such file"),
        (["--urdf", "in.urdf", "-o", "in.urdf"], "another name for the output"),
        (["--urdf", "in.urdf", "--tip", "l3", "-o", "out.urdf"], "were calibrated"),
        (["--urdf", "in.urdf", "-o", "out.urdf"], "choose one with --tip"),
        (["--urdf", "other.urdf", "--tip", "tip", "-o", "out.urdf"], "differs from the nominal arm"),
        (["--urdf", "slides.urdf", "--tip", "tip", "-o", "out.urdf"], "joint 'j1' slides, and joint 1"),
        (
            ["--urdf", "in.urdf", "--base", "aside", "--tip", "tip", "-o", "out.urdf"],
            "differs from the nominal arm",
        ),
        (["--at", "temperature", "-o", "out.md"], "write temperature=35"),
        (["--at", "temperature=nan", "-o", "out.md"], "write temperature=35"),
        (["--at", "temp=20", "-o", "out.md"], "follows 'temp'"),
        (["-o", "out.yaml"], "kinematics.yaml is for arms of Universal Robots"),
        (["--urdf", "in.urdf", "--sensor-link", "l1", "-o", "out.urdf"], "--sensor-link"),
        (["--urdf", "in.urdf", "--tip", "tip", "--sensor-link", "aside", "-o", "out.urdf"], "no chain leads"),
    ],
)
def test_what_cannot_be_exported_is_refused_in_one_line(options, words, tmp_path, monkeypatch):
    """The exit status is 2, one line says what to do, and no file is written."""
    monkeypatch.chdir(tmp_path)
    for name, seed in (("in", 1), ("other", 2)):
        text = random_description(np.random.default_rng(seed), 6).replace("prismatic", "revolute")
        (tmp_path / f"{name}.urdf").write_text(text, encoding="utf-8")
    text = (tmp_path / "in.urdf").read_text(encoding="utf-8")
    (tmp_path / "slides.urdf").write_text(re.sub("revolute|continuous", "prismatic", text, count=1), "utf-8")
    robot, _ = robot_from_urdf("in.urdf", None, "tip")
    calibrated(robot, np.random.default_rng(1)).save("calibration.json")
    before = sorted(tmp_path.iterdir())
    status, said = run("export", "calibration.json", *options)
    assert status == 2, said
    assert words in said
    assert len(said.splitlines()) == 1
    assert sorted(tmp_path.iterdir()) == before
