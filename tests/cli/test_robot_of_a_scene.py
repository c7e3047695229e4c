"""The robot that a scene of ``scalar simulate`` names: an arm of the library, a file, and what is neither."""

from pathlib import Path

import pytest

from scalar.data.io.plain_yaml import dump_yaml, load_yaml
from scalar.robots import read_arm
from tests.cli.running import INPUT_AT_FAULT, refused, run

SCENE = Path(__file__).parents[2] / "configs/scenes/paper.yaml"
SMALL = {"poses_per_plane": 3, "truth_poses": 10, "seed": 2}
SENSOR = {"translation": [0.0, 0.0, 0.1], "rotation_vector": [0.0, 0.0, 0.0]}


def scene(folder: Path, robot: object) -> Path:
    """Write a small scene with an arm that is as its table, and return its path."""
    content = load_yaml(SCENE) | SMALL | {"robot": robot}
    content["sensor"] = content["sensor"] | {"pose": SENSOR}
    del content["initial_model"]
    folder.mkdir()
    dump_yaml(content, folder / "scene.yaml")
    return folder / "scene.yaml"


@pytest.mark.parametrize("name", ["kuka_kr6_r900_sixx", "KUKA KR 6 R900 sixx"])
def test_a_scene_may_name_an_arm_of_the_library(tmp_path, name):
    """The dataset has the table of joints of that arm, under its name in the library or the maker's."""
    result = run("simulate", scene(tmp_path / "cell", name), "-o", tmp_path / "sim")
    assert result.exit_code == 0, result.output
    written = load_yaml(tmp_path / "sim/dataset/dataset.yaml")["robot"]
    wanted = read_arm("kuka_kr6_r900_sixx").mapping
    assert written["name"] == "kuka_kr6_r900_sixx"
    for found, expected in zip(written["joints"], wanted["joints"], strict=True):
        for key in expected:
            assert found[key] == pytest.approx(expected[key])


def test_a_file_goes_before_an_arm_of_the_same_name(tmp_path):
    """A robot file that lies in the folder of the scene is read, whatever it is called."""
    path = scene(tmp_path / "cell", "ur10e")
    dump_yaml(dict(read_arm("denso_vs060").mapping), path.parent / "ur10e")
    assert run("simulate", path, "-o", tmp_path / "sim").exit_code == 0
    assert load_yaml(tmp_path / "sim/dataset/dataset.yaml")["robot"]["name"] == "denso_vs060"


@pytest.mark.parametrize(
    ("robot", "words"),
    [
        ("kuka_kr6_r900", ("scene.yaml, robot", "kuka_kr6_r900_sixx", "scalar init --list")),
        ("robots/arm.yaml", ("scene.yaml, robot", "neither a robot file", "relative to this file")),
        ("my-cell", ("scene.yaml, robot", "is a dataset", "what stands under robot")),
        ("my-cell/dataset.yaml", ("scene.yaml, robot", "is a dataset")),
    ],
)
def test_what_names_no_robot_is_refused_with_what_does(tmp_path, robot, words):
    """A misspelt name gets the names like it, and a dataset the way to its table of joints."""
    path = scene(tmp_path / "cell", robot)
    run("init", path.parent / "my-cell", "--robot", "ur10e", "--sensor", "tracker")
    refused(run("simulate", path, "-o", tmp_path / "sim"), INPUT_AT_FAULT, *words)
