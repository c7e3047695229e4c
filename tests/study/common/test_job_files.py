"""The inputs of a job contain a scene and the robot that it names, as relative paths if the repository is the working directory."""

from pathlib import Path

import pytest
from study.common.job_files import files_of_scene, local, robot_of_scene

from scalar.errors import InvalidInput


@pytest.fixture
def scene(tmp_path, monkeypatch):
    """Return a scene that names a robot in a folder beside its own, below the working directory."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "scenes").mkdir()
    scene = tmp_path / "scenes/cell.yaml"
    scene.write_text("robot: ../robots/arm.yaml\n")
    return scene


def test_a_scene_comes_with_the_robot_that_it_names(scene):
    """The robot's path is relative to the folder of the scene, not to the working directory."""
    assert files_of_scene(scene) == ["scenes/cell.yaml", "robots/arm.yaml"]


def test_a_scene_that_holds_its_robot_stands_alone(scene):
    """A scene that describes its robot itself has no further file."""
    scene.write_text("robot:\n  joints: []\n")
    assert robot_of_scene(scene) == []
    assert files_of_scene(scene) == ["scenes/cell.yaml"]


def test_files_are_found_from_another_folder(scene, monkeypatch):
    """A workflow that is run from another folder still finds every file."""
    (scene.parent / "elsewhere").mkdir()
    monkeypatch.chdir(scene.parent / "elsewhere")
    assert [Path(name) for name in files_of_scene(scene)] == [scene, scene.parents[1] / "robots/arm.yaml"]
    assert Path(local(scene)) == scene


def test_a_scene_that_is_not_there_is_named(tmp_path):
    """The message names the missing file and is no traceback of Snakemake."""
    with pytest.raises(InvalidInput, match=r"nothing\.yaml"):
        robot_of_scene(tmp_path / "nothing.yaml")
