"""``--urdf FILE --base LINK --tip LINK`` of ``scalar plan`` and ``scalar simulate``: the arm of the description, and refusals."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from scalar import read_dataset, read_robot
from scalar.data.io.plain_yaml import dump_yaml, load_yaml
from tests.cli.running import INPUT_AT_FAULT, refused, run

SCENE = Path(__file__).parents[2] / "configs/scenes/panda.yaml"
PLAN = ("--poses", 15, "--candidates", 120, "--no-collisions", "--seed", 3)


@pytest.fixture(scope="module")
def panda() -> Path:
    """Return the description of an arm of seven joints that pybullet ships."""
    data = pytest.importorskip("pybullet_data")
    return Path(data.getDataPath()) / "franka_panda/panda.urdf"


def links(panda: Path) -> tuple[object, ...]:
    """Return the options that name the arm."""
    return ("--urdf", panda, "--base", "panda_link0", "--tip", "panda_link8")


def test_a_plan_for_a_urdf_is_that_for_a_folder_with_the_same_arm(panda, tmp_path):
    """Poses for the description are those for a dataset.yaml that holds the same arm, with a tracker's target at the same place."""
    result = run("plan", *links(panda), *PLAN, "-o", tmp_path / "urdf")
    assert result.exit_code == 0, result.output
    folder = tmp_path / "cell"
    folder.mkdir()
    pose = {"translation": [0.1, 0.0, 0.1], "rotation_vector": [0.0, 0.0, 0.0]}
    robot = read_robot(panda, "panda_link0", "panda_link8")
    description = {
        "format": "scalar-dataset/2",
        "name": "cell",
        "robot": robot.to_mapping(),
        "sensor": {"kind": "tracker", "nominal_pose": pose},
    }
    dump_yaml(description, folder / "dataset.yaml")
    assert run("plan", folder, *PLAN, "-o", tmp_path / "folder").exit_code == 0
    one, other = (pd.read_csv(tmp_path / name / "poses.csv") for name in ("urdf", "folder"))
    pd.testing.assert_frame_equal(one, other)
    q = one[[f"q{i}" for i in range(1, 8)]].to_numpy()
    assert len(q) == 15 and np.all((q >= robot.limits[:, 0]) & (q <= robot.limits[:, 1]))


def test_a_plan_says_which_limits_are_assumed(tmp_path):
    """A joint of which the description states no limits is named, because the plan uses its whole turn."""
    urdf = tmp_path / "arm.urdf"
    names = [f"l{i}" for i in range(7)]
    text = "".join(f'<link name="{name}"/>' for name in names)
    for i in range(1, 7):
        kind = "continuous" if i == 4 else "revolute"
        limit = '<limit lower="-2" upper="2" effort="1" velocity="1"/>' if i != 4 else ""
        axis = "0 0 1" if i in (1, 4, 6) else "0 1 0"
        text += (
            f'<joint name="j{i}" type="{kind}"><parent link="l{i - 1}"/><child link="l{i}"/><origin xyz="0.1 0 0.3"/>'
            f'<axis xyz="{axis}"/>{limit}</joint>'
        )
    urdf.write_text(f'<robot name="arm">{text}</robot>', encoding="utf-8")
    result = run("plan", "--urdf", urdf, *PLAN, "-o", tmp_path / "plan")
    assert result.exit_code == 0, result.output
    assert "no limits stated: j4;" in result.output


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((), ("ROBOT: missing", "--urdf FILE")),
        (("ur10e", "--urdf", "arm.urdf"), ("two robots",)),
        (("ur10e", "--base", "l0"), ("--base, --tip", "give --urdf FILE too")),
        (("--urdf", "absent.urdf"), ("absent.urdf",)),
        (("--urdf", "arm.urdf", "--after", "out"), ("--after needs the folder of the dataset",)),
    ],
)
def test_what_names_no_robot_or_two_is_refused(tmp_path, arguments, words):
    """One robot has to be named, and links only with a description; nothing is written."""
    refused(
        run("plan", *arguments, "-o", tmp_path / "plan"), INPUT_AT_FAULT, *words, output=tmp_path / "plan"
    )


@pytest.mark.slow
def test_a_scene_takes_the_arm_of_a_urdf(panda, tmp_path):
    """The simulated dataset holds the arm of the description in the place of the scene's own, with its flange at all joint angles."""
    scene = load_yaml(SCENE) | {"poses_per_plane": 3, "truth_poses": 10, "robot": "absent.yaml"}
    dump_yaml(scene, tmp_path / "scene.yaml")
    result = run("simulate", tmp_path / "scene.yaml", *links(panda), "-o", tmp_path / "sim")
    assert result.exit_code == 0, result.output
    found = read_dataset(tmp_path / "sim/dataset").robot
    wanted = read_robot(panda, "panda_link0", "panda_link8")
    q = np.random.default_rng(1).uniform(-1, 1, (20, 7))
    np.testing.assert_allclose(found.flange(q), wanted.flange(q), atol=1e-9)


def test_a_scene_may_name_the_description_of_its_arm(panda, tmp_path):
    """A scene whose robot is a URDF, with a path relative to the scene, is that of --urdf, number by number."""
    (tmp_path / "arm.urdf").write_bytes(panda.read_bytes())
    scene = load_yaml(SCENE) | {"poses_per_plane": 3, "truth_poses": 10}
    named = {"urdf": "arm.urdf", "base": "panda_link0", "tip": "panda_link8"}
    dump_yaml(scene | {"robot": named}, tmp_path / "scene.yaml")
    dump_yaml(scene | {"robot": "absent.yaml"}, tmp_path / "absent.yaml")
    assert run("simulate", tmp_path / "scene.yaml", "-o", tmp_path / "named").exit_code == 0
    assert run("simulate", tmp_path / "absent.yaml", *links(panda), "-o", tmp_path / "given").exit_code == 0
    one, other = (pd.read_csv(tmp_path / name / "dataset/scans.csv") for name in ("named", "given"))
    pd.testing.assert_frame_equal(one, other)


@pytest.mark.parametrize(
    ("robot", "words"),
    [
        ({"urdf": "absent.urdf"}, ("absent.urdf", "no such file")),
        ({"urdf": "arm.urdf", "tip": 3}, ("scene.yaml, robot.tip", "name of a link")),
        (
            {"urdf": "arm.urdf", "joints": []},
            ("scene.yaml, robot.joints", "base and tip are the only other ones"),
        ),
    ],
)
def test_a_description_that_a_scene_names_wrongly_is_refused(tmp_path, robot, words):
    """The message names the file or the key."""
    dump_yaml(load_yaml(SCENE) | {"robot": robot}, tmp_path / "scene.yaml")
    refused(run("simulate", tmp_path / "scene.yaml", "-o", tmp_path / "sim"), INPUT_AT_FAULT, *words)


def test_a_scene_refuses_links_without_a_description_and_a_slide(tmp_path):
    """Links need --urdf, and an arm with a slide is refused by name, since the simulator has none."""
    refused(
        run("simulate", SCENE, "--tip", "l1", "-o", tmp_path / "sim"), INPUT_AT_FAULT, "give --urdf FILE too"
    )
    urdf = tmp_path / "slide.urdf"
    urdf.write_text(
        '<robot name="slide"><link name="a"/><link name="b"/><joint name="j" type="prismatic"><parent link="a"/><child link="b"/>'
        '<axis xyz="0 0 1"/><limit lower="0" upper="1" effort="1" velocity="1"/></joint></robot>',
        encoding="utf-8",
    )
    result = run("simulate", SCENE, "--urdf", urdf, "-o", tmp_path / "sim")
    refused(result, INPUT_AT_FAULT, "slide.urdf", "type")
