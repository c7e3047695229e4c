"""``scalar simulate``: a dataset by the physics engine, and its truth."""

from __future__ import annotations

from pathlib import Path

import click

from scalar.cli.group import cli
from scalar.cli.options import BASE, OUTPUT, PATH, TIP, URDF, lock_output, refuse_links_without_urdf
from scalar.cli.outputs import FORCE
from scalar.cli.simulator import simulator
from scalar.cli.terminal import say


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

    CONFIG describes the scene. With --urdf, the arm of that description stands in it instead of its own. Writes the dataset to DIR/dataset
    and its truth to DIR/truth.

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
