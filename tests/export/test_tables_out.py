"""A calibration as kinematics.yaml of Universal Robots and as DH tables: independent readers find the calibrated arm in them."""

import csv
import io
from dataclasses import replace

import numpy as np
import pytest
import yaml
from click.testing import CliRunner

from scalar.cli import cli
from scalar.data.io.plain_yaml import load_yaml
from scalar.effects.axis_nonparallel import AxisNonparallel
from scalar.export.dh_table import _signed
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import transform_from_rotation_vector
from scalar.ingest.urdf import robot_from_urdf
from tests.calibrated_arms import calibrated
from tests.kinematics import rotation, translation
from tests.robot_configs import ROBOT_CONFIGS
from tests.robot_descriptions import poses_by_pybullet

JOINTS = ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3")
LINKS = ("shoulder", "upper_arm", "forearm", "wrist_1", "wrist_2", "wrist_3")

UR10E_DEFAULT = {  # config/ur10e/default_kinematics.yaml of ur_description: x, y, z, roll, pitch, yaw
    "shoulder": (0, 0, 0.1807, 0, 0, 0),
    "upper_arm": (0, 0, 0, np.pi / 2, 0, 0),
    "forearm": (-0.6127, 0, 0, 0, 0, 0),
    "wrist_1": (-0.57155, 0, 0.17415, 0, 0, 0),
    "wrist_2": (0, -0.11985, 0, np.pi / 2, 0, 0),
    "wrist_3": (0, 0.11655, 0, np.pi / 2, np.pi, np.pi),
}


def robot_of(name):
    """Return the arm of a file of configs/robots."""
    return Robot.from_mapping(load_yaml(ROBOT_CONFIGS / f"{name}.yaml"))


def exported(calibration, folder, name, *options):
    """Return the text that ``scalar export`` writes."""
    path = folder / "calibration.json"
    calibration.save(path)
    result = CliRunner().invoke(cli, ["export", str(path), "-o", str(folder / name), *options])
    assert result.exit_code == 0, result.output
    return (folder / name).read_text(encoding="utf-8")


def description(kinematics):
    """Return the joints that ur_description's macro makes of a kinematics.yaml, as a URDF."""
    body = '<link name="base"/>'
    parent = "base"
    for joint, link in zip(JOINTS, LINKS, strict=True):
        k = kinematics[link]
        body += (
            f'<link name="{link}_link"/><joint name="{joint}" type="continuous"><parent link="{parent}"/>'
            f'<child link="{link}_link"/><origin xyz="{k["x"]!r} {k["y"]!r} {k["z"]!r}" '
            f'rpy="{k["roll"]!r} {k["pitch"]!r} {k["yaw"]!r}"/><axis xyz="0 0 1"/></joint>'
        )
        parent = f"{link}_link"
    return f'<robot name="ur">{body}</robot>'


def tool_by_macro(kinematics, q, folder):
    """Return where pybullet puts wrist_3 ``(N, 4, 4)``, which is where ur_description has tool0."""
    path = folder / "ur.urdf"
    path.write_text(description(kinematics), encoding="utf-8")
    return poses_by_pybullet(path, "base", "wrist_3_link", q, list(JOINTS))


def test_the_table_of_ur_description_is_our_ur10e(tmp_path):
    """The default that Universal Robots publish, through their macro, is our nominal arm, so both mean the same frames."""
    pytest.importorskip("pybullet")
    keys = ("x", "y", "z", "roll", "pitch", "yaw")
    default = {link: dict(zip(keys, map(float, v), strict=True)) for link, v in UR10E_DEFAULT.items()}
    q = np.random.default_rng(1).uniform(-3, 3, (20, 6))
    np.testing.assert_allclose(tool_by_macro(default, q, tmp_path), robot_of("ur10e").flange(q), atol=1e-9)


def test_a_kinematics_file_is_the_calibrated_arm(tmp_path):
    """Through the macro of ur_description, the file puts tool0 where the calibration has the flange."""
    pytest.importorskip("pybullet")
    calibration = calibrated(robot_of("ur10e"), np.random.default_rng(1))
    text = exported(calibration, tmp_path, "kinematics.yaml", "--ur-hash", "calib_123")
    kinematics = yaml.safe_load(text)["kinematics"]
    assert kinematics.pop("hash") == "calib_123"
    assert list(kinematics) == list(LINKS)
    q = np.random.default_rng(2).uniform(-3, 3, (100, 6))
    np.testing.assert_allclose(
        tool_by_macro(kinematics, q, tmp_path), calibration.model.robot.flange(q), atol=1e-9
    )


@pytest.mark.parametrize("checksum", ["x: y", "calib_1\n  shoulder: {}", "calib_1 # a", "true", "", "calib_"])
def test_a_checksum_that_is_none_is_refused(checksum, tmp_path):
    """Text that would be other YAML than one value, or is no checksum, is refused, and nothing is written."""
    path, output = tmp_path / "calibration.json", tmp_path / "kinematics.yaml"
    calibrated(robot_of("ur10e"), np.random.default_rng(1)).save(path)
    result = CliRunner().invoke(cli, ["export", str(path), "-o", str(output), "--ur-hash", checksum])
    assert result.exit_code == 2 and "--ur-hash" in result.stderr
    assert len(result.stderr.splitlines()) == 1
    assert not output.exists()


def test_a_kinematics_file_without_a_checksum_is_said_to_have_none(tmp_path):
    """Where no checksum is given, the file has one that no controller has, and a line says so."""
    path, output = tmp_path / "calibration.json", tmp_path / "kinematics.yaml"
    calibrated(robot_of("ur10e"), np.random.default_rng(1)).save(path)
    for given, said in (((), 1), (("--ur-hash", "calib_123"), 0)):
        result = CliRunner().invoke(cli, ["export", str(path), "-o", str(output), "--force", *given])
        assert result.exit_code == 0, result.output
        stated = yaml.safe_load(output.read_text(encoding="utf-8"))["kinematics"]["hash"]
        lines = [line for line in result.output.splitlines() if "--ur-hash is not given" in line]
        assert len(lines) == said and all(stated in line for line in lines)


def test_an_arm_in_other_frames_makes_no_kinematics_file(tmp_path):
    """A base that is turned against the controller's is refused, because the file would turn the arm."""
    turned = replace(robot_of("ur10e"), T_base_0=rotation(2, np.pi))
    path = tmp_path / "calibration.json"
    calibrated(turned, np.random.default_rng(1)).save(path)
    result = CliRunner().invoke(cli, ["export", str(path), "-o", str(tmp_path / "kinematics.yaml")])
    assert result.exit_code == 2
    assert "base or flange" in result.output


def test_a_dh_table_is_the_calibrated_arm(tmp_path):
    """The table in the CSV, multiplied out by its formula, gives the flange of the calibration."""
    calibration = calibrated(robot_of("panda"), np.random.default_rng(1))
    rows = list(csv.DictReader(io.StringIO(exported(calibration, tmp_path, "dh.csv"))))
    q = np.random.default_rng(2).uniform(-2, 2, (20, 7))
    robot = calibration.model.robot
    T = np.broadcast_to(robot.T_base_0, (20, 4, 4))
    for i, row in enumerate(rows):
        a, alpha, d, theta, beta = (
            float(row[name]) for name in ("a_m", "alpha_rad", "d_m", "theta_rad", "beta_rad")
        )
        T = T @ rotation(0, alpha) @ translation(0, a) @ rotation(1, beta)
        T = T @ rotation(2, q[:, i] + theta) @ translation(2, d)
        assert float(row["a_nominal_m"]) == calibration.model.nominal.geometry[0, i]
        assert row["a_std_m"] == ""  # nothing was estimated
    np.testing.assert_allclose(T @ robot.T_n_flange, robot.flange(q), atol=1e-12)


STANDARD = {
    "name": "arm",
    "convention": "standard-dh",
    "joints": [
        {"a": 0.15, "alpha": 1.57, "d": 0.4, "theta": 0.0},
        {"a": 0.6, "alpha": 0.01, "d": 0.02, "theta": -1.0},
        {"a": 0.05, "alpha": -1.4, "d": 0.3, "theta": 0.5},
        {"a": 0.03, "alpha": 0.7, "d": 0.1, "theta": 0.2},
    ],
    "base": {"translation": [0.1, 0.0, 0.3], "rotation_vector": [0.0, 0.2, 0.0]},
    "flange": {"translation": [0.01, 0.02, 0.03], "rotation_vector": [0.3, 0.1, -0.2]},
}


def by_standard_formula(text, table, q):
    """Return the sensor ``(N, 4, 4)`` that the rows of a CSV and the fixed transforms of a table for people make by the formula of standard DH."""
    transforms = {}
    for line in table.splitlines():
        cells = [cell.strip() for cell in line.strip("| ").split("|")]
        if len(cells) == 11 and cells[2][:1] in "+-" and cells[2] != "---":
            numbers = np.array([float(cell) for cell in cells[2:]])
            turn, (roll, pitch, yaw) = np.deg2rad(numbers[3:6]), np.deg2rad(numbers[6:])
            T = transform_from_rotation_vector(numbers[:3] / 1e3, turn)
            rpy = rotation(2, yaw) @ rotation(1, pitch) @ rotation(0, roll)
            np.testing.assert_allclose(rpy[:3, :3], T[:3, :3], atol=1e-9)
            transforms[cells[0]] = T
    T = np.broadcast_to(transforms["base"], (len(q), 4, 4))
    for i, row in enumerate(csv.DictReader(io.StringIO(text))):
        assert row["convention"] == "standard-dh"
        a, alpha, d, theta, beta = (float(row[f"{k}_{u}"]) for k, u in UNITS.items())
        T = (
            T
            @ rotation(2, q[:, i] + theta)
            @ translation(2, d)
            @ translation(0, a)
            @ rotation(0, alpha)
            @ rotation(1, beta)
        )
    return T @ transforms[f"frame {q.shape[1]}"] @ transforms["flange"]


UNITS = {"a": "m", "alpha": "rad", "d": "m", "theta": "rad", "beta": "rad"}


def test_an_arm_declared_in_standard_dh_is_written_in_standard_dh(tmp_path):
    """The rows are those of dataset.yaml, and by the formula of standard DH they are the calibrated arm to 1e-9 m, beta included; what plain
    standard DH cannot hold is said with its size."""
    robot = Robot.from_mapping(STANDARD)
    made = calibrated(robot, np.random.default_rng(1))
    text = exported(made, tmp_path, "dh.csv")
    for row, declared in zip(csv.DictReader(io.StringIO(text)), STANDARD["joints"], strict=True):
        for kind, value in declared.items():
            assert float(row[f"{kind}_nominal_{UNITS[kind]}"]) == pytest.approx(value, abs=1e-15)
    q = np.random.default_rng(2).uniform(-2, 2, (20, 4))
    wanted = made.predict(q)
    people = exported(made, tmp_path, "dh.md")
    assert "Standard DH alone has no beta" in people and "mm RMS" in people
    np.testing.assert_allclose(by_standard_formula(text, people, q), wanted, atol=1e-9)
    assert "modified-dh" in exported(made, tmp_path, "modified.csv", "--convention", "modified-dh")
    flat = replace(robot, geometry=robot.geometry.copy())
    assert "alone has no beta" not in exported(
        calibrated(flat, np.random.default_rng(1), size=0.0), tmp_path, "flat.md"
    )


@pytest.mark.parametrize(
    ("number", "said"), [(-5e-17, "+0.000000000"), (-90.0, "-90.000000000"), (1e-9, "+0.000000001")]
)
def test_a_transform_has_no_zero_with_a_minus(number, said):
    """Rounding of a URDF leaves numbers of 1e-17, which are zero."""
    assert _signed(number) == said


@pytest.mark.parametrize("options", [(), ("--convention", "standard-dh")])
def test_a_csv_says_which_tables_for_people_have_its_transforms(tmp_path, options):
    """The transforms of the other convention would put the arm elsewhere, so the advice repeats the convention that was asked for."""
    path = tmp_path / "calibration.json"
    calibrated(robot_of("vs060"), np.random.default_rng(1)).save(path)
    result = CliRunner().invoke(cli, ["export", str(path), "-o", str(tmp_path / "dh.csv"), *options])
    assert " ".join(("-o NAME.md", *options)) + "\n" in result.stdout


def test_the_table_for_people_has_the_same_numbers_in_millimetres_and_degrees(tmp_path):
    """Each cell is that of the CSV, rounded."""
    calibration = calibrated(robot_of("vs060"), np.random.default_rng(1))
    rows = list(csv.DictReader(io.StringIO(exported(calibration, tmp_path, "dh.csv"))))
    text = exported(calibration, tmp_path, "dh.md")
    table = [line for line in text.splitlines() if line.startswith("| 1 |") or line.startswith("| 6 |")]
    for line, row in zip(table[:2], (rows[0], rows[5]), strict=True):
        cells = [float(cell) for cell in line.strip("| ").split("|")[1:]]
        wanted = [float(row["a_m"]) * 1e3, np.rad2deg(float(row["alpha_rad"])), float(row["d_m"]) * 1e3]
        np.testing.assert_allclose(cells[:3], wanted, atol=1e-5)


def test_a_tilt_that_an_effect_holds_has_its_standard_error(tmp_path):
    """The table has beta as the sum of parameter and effect, with the standard error of the sum, and with none where it is fixed."""
    made = calibrated(robot_of("ur10e"), np.random.default_rng(1))
    tilt = AxisNonparallel(3, coefficients=np.array([1e-3]))
    made = replace(made, model=replace(made.model, effects=(tilt,)))
    free = ("a_3", *made.model.effect_names[0])
    covariance = np.array([[4e-10, 1e-10], [1e-10, 9e-10]])
    made = replace(made, free=free, covariance=covariance)
    for convention in ("modified-dh", "standard-dh"):
        rows = csv.DictReader(
            io.StringIO(exported(made, tmp_path, f"{convention}.csv", "--convention", convention))
        )
        errors = [row["beta_std_rad"] for row in rows]
        given = [i for i, error in enumerate(errors) if error]
        assert given == [2 if convention == "modified-dh" else 1]
        assert float(errors[given[0]]) == pytest.approx(3e-5, rel=1e-12)
    both = replace(made, free=("a_3", "beta_3", free[1]), covariance=np.diag([1e-10, 1.6e-9, 9e-10]))
    row = list(csv.DictReader(io.StringIO(exported(both, tmp_path, "both.csv"))))[2]
    assert float(row["beta_std_rad"]) == pytest.approx(5e-5, rel=1e-12)


def test_the_frames_of_ur_description_lead_to_the_table_of_the_controller(tmp_path):
    """From the link `base`, which stands beside the chain, to `tool0`, the description is the table that kinematics.yaml asks for."""
    keys = ("x", "y", "z", "roll", "pitch", "yaw")
    default = {link: dict(zip(keys, map(float, v), strict=True)) for link, v in UR10E_DEFAULT.items()}
    half_turn = f'<origin xyz="0 0 0" rpy="0 0 {np.pi!r}"/>'
    frames = '<link name="base_link"/><link name="base_beside"/><link name="tool0"/>' + "".join(
        f'<joint name="{child}_fixed" type="fixed"><parent link="{parent}"/><child link="{child}"/>{origin}</joint>'
        for parent, child, origin in (
            ("base_link", "base", half_turn),
            ("base_link", "base_beside", half_turn),
            ("wrist_3_link", "tool0", ""),
        )
    )
    path = tmp_path / "ur.urdf"
    path.write_text(description(default).replace("</robot>", f"{frames}</robot>"), encoding="utf-8")
    robot, _ = robot_from_urdf(path, "base_beside", "tool0")
    np.testing.assert_allclose(robot.geometry, robot_of("ur10e").geometry, atol=1e-9)
    calibration = calibrated(robot, np.random.default_rng(1))
    assert "kinematics:" in exported(calibration, tmp_path, "kinematics.yaml")
    options = ("--urdf", str(path), "--base", "base_beside", "--tip", "tool0")
    assert "scalar_sensor" in exported(calibration, tmp_path, "out.urdf", *options)
