"""``scalar simulate``: a dataset by the physics engine, and its truth."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import click

from scalar.cli.group import cli
from scalar.cli.options import BASE, OUTPUT, PATH, TIP, URDF, lock_output, refuse_links_without_urdf
from scalar.cli.outputs import FORCE
from scalar.cli.simulator import simulator
from scalar.cli.terminal import say
from scalar.errors import Fault, InvalidInput

_KEYS = ("urdf", "base", "tip")


@cli.command()
@click.argument("config", type=PATH)
@OUTPUT
@click.option("--seed", type=click.IntRange(min=0), help="Seed to use instead of that in CONFIG.")
@URDF
@BASE
@TIP
@FORCE
def simulate(
    config: Path,
    output: Path,
    seed: int | None,
    urdf: Path | None,
    base: str | None,
    tip: str | None,
    force: bool,
) -> None:
    """Simulate a dataset with pybullet.

    CONFIG describes the scene. Its arm is one of the library (robot: ur10e; `scalar init --list` shows the names), that of a robot file (robot:
    my_arm.yaml), or that of a URDF (robot: {urdf: arm.urdf, base: base_link, tip: tool0}); paths are relative to CONFIG. With --urdf, the arm of
    that description stands in the scene instead of its own. Writes the dataset to DIR/dataset and its truth to DIR/truth.

    \b
    Example:
      scalar simulate configs/scenes/paper.yaml -o sim
      scalar simulate configs/scenes/paper.yaml --urdf arm.urdf --base base_link --tip tool0 -o sim
      scalar calibrate sim/dataset -o out
      scalar evaluate out/calibration.json sim/truth -o out
    """
    from scalar.cli.progress import progress

    refuse_links_without_urdf(urdf, base, tip)
    simulation = simulator("simulate")
    lock_output(output)
    if urdf is None:
        robot, robot_file = _robot_of_scene(config)
    else:
        robot, robot_file = _robot_of_urdf(urdf, base, tip), urdf.name
    content = simulation.load_config(config, robot=robot, robot_file=robot_file)
    if seed is not None:
        content["seed"] = seed
    with progress("placing the scanner") as advance:
        scene = simulation.simulate(content, base_dir=config.parent, progress=advance)
    simulation.write_scene(scene, output, force=force)
    say(
        f"{output / 'dataset'}: {len(scene.poses)} poses, {len(scene.scans)} points; truth in {output / 'truth'}"
    )


def _robot_of_urdf(urdf: Path, base: str | None, tip: str | None) -> dict[str, Any]:
    from scalar.ingest.urdf import robot_from_urdf

    return robot_from_urdf(urdf, base, tip)[0].to_mapping()


def _robot_of_scene(config: Path) -> tuple[Mapping[str, Any] | None, str | None]:
    """Return the arm that a scene takes from a URDF or from the library, and where it stands; None where the scene has a robot file or a table.

    Raises:
        InvalidInput: The file is no YAML, the scene names a URDF with other keys than ``urdf``, ``base`` and ``tip``, or other values than texts, or
            it names neither a file that exists nor an arm of the library.
    """
    from scalar.data.io.plain_yaml import load_yaml

    content: Any = load_yaml(config)
    robot = content.get("robot") if isinstance(content, dict) else None
    if isinstance(robot, str) and robot.lower().endswith(".urdf"):
        robot = {"urdf": robot}
    if isinstance(robot, str):
        return _named_robot(robot, config)
    if not isinstance(robot, dict) or "urdf" not in robot:
        return None, None
    for key, value in robot.items():
        if key not in _KEYS:
            message = "where robot has the key urdf, base and tip are the only other ones; remove this key"
            raise InvalidInput(Fault(config.name, message, column=f"robot.{key}"))
        if not isinstance(value, str) or not value:
            kind = (
                "path of the URDF, relative to this file" if key == "urdf" else "name of a link of the URDF"
            )
            raise InvalidInput(Fault(config.name, f"write the {kind}", column=f"robot.{key}"))
    urdf = config.parent / robot["urdf"]
    return _robot_of_urdf(urdf, robot.get("base"), robot.get("tip")), urdf.name


def _named_robot(robot: str, config: Path) -> tuple[Mapping[str, Any] | None, str | None]:
    """Return the arm of the library that a scene names, and its name; None where the text is the path of a file.

    Raises:
        InvalidInput: The text is neither; or it is the path of a dataset, which is no robot file.
    """
    from scalar.data.description import DESCRIPTION
    from scalar.robots import has_arm, read_arm, similar_names

    path = config.parent / robot
    if path.is_file() and path.name != DESCRIPTION:
        return None, None
    if path.is_file() or (path / DESCRIPTION).is_file():
        message = f"{robot!r} is a dataset: write what stands under robot in its {DESCRIPTION} under robot here, or name an arm of the library"
        raise InvalidInput(Fault(config.name, message, column="robot"))
    if has_arm(robot):
        return read_arm(robot).mapping, robot
    similar = similar_names(Path(robot).stem)
    meant = f"did you mean {', '.join(similar)}? " if similar else ""
    message = (
        f"{robot!r} is neither a robot file in the folder of this file nor an arm of the library; {meant}"
        "`scalar init --list` lists the arms, and paths are relative to this file"
    )
    raise InvalidInput(Fault(config.name, message, column="robot"))
