"""Files as jobs name them, and the files that a scene consists of: rules list both of these as input, so that an edit of either runs jobs again."""

from __future__ import annotations

from pathlib import Path

from scalar.data.io.plain_yaml import load_yaml


def local(path: Path) -> str:
    """Return a file's path as jobs name it: relative to the working directory if the file lies below that."""
    here = Path.cwd()
    return str(path.relative_to(here) if path.is_relative_to(here) else path)


def robot_of_scene(scene: Path) -> list[str]:
    """Return the robot's file that a scene names, as jobs name it; an empty list if the scene's own file describes the robot.

    Raises:
        InvalidInput: The scene cannot be read, or is not YAML.
    """
    robot = load_yaml(scene).get("robot")
    return [local((scene.parent / robot).resolve())] if isinstance(robot, str) else []


def files_of_scene(scene: Path) -> list[str]:
    """Return a scene's file and its robot's, as jobs name them; errors as for `robot_of_scene`."""
    return [local(scene.resolve()), *robot_of_scene(scene)]
