"""``scalar simulate``: a dataset by the physics engine, and its truth."""

from __future__ import annotations

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

    CONFIG describes the scene. Its arm may be that of a URDF, robot: {urdf: arm.urdf, base: base_link, tip: tool0}, with a path relative to CONFIG.
    With --urdf, the arm of that description stands in the scene instead of its own. Writes the dataset to DIR/dataset and its truth to DIR/truth.

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
    robot = None
    if urdf is None:
        urdf, base, tip = _urdf_of_scene(config)
    if urdf is not None:
        from scalar.ingest.urdf import robot_from_urdf

        robot = robot_from_urdf(urdf, base, tip)[0].to_mapping()
    content = simulation.load_config(config, robot=robot, robot_file=None if urdf is None else urdf.name)
    if seed is not None:
        content["seed"] = seed
    with progress("placing the scanner") as advance:
        scene = simulation.simulate(content, base_dir=config.parent, progress=advance)
    simulation.write_scene(scene, output, force=force)
    say(
        f"{output / 'dataset'}: {len(scene.poses)} poses, {len(scene.scans)} points; truth in {output / 'truth'}"
    )


def _urdf_of_scene(config: Path) -> tuple[Path | None, str | None, str | None]:
    """Return the URDF that a scene names for its arm, its base and its tip; None where it names none.

    Raises:
        InvalidInput: The file is no YAML, or the scene names a URDF with other keys than ``urdf``, ``base`` and ``tip``, or other values than texts.
    """
    from scalar.data.io.plain_yaml import load_yaml

    content: Any = load_yaml(config)
    robot = content.get("robot") if isinstance(content, dict) else None
    if isinstance(robot, str) and robot.lower().endswith(".urdf"):
        robot = {"urdf": robot}
    if not isinstance(robot, dict) or "urdf" not in robot:
        return None, None, None
    for key, value in robot.items():
        if key not in _KEYS:
            message = "beside urdf, robot has the keys base and tip only; remove this key"
            raise InvalidInput(Fault(config.name, message, column=f"robot.{key}"))
        if not isinstance(value, str) or not value:
            kind = (
                "path of the URDF, relative to this file" if key == "urdf" else "name of a link of the URDF"
            )
            raise InvalidInput(Fault(config.name, f"write the {kind}", column=f"robot.{key}"))
    return config.parent / robot["urdf"], robot.get("base"), robot.get("tip")
