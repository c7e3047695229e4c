"""``scalar simulate``: a dataset by the physics engine, and its truth."""

from __future__ import annotations

from pathlib import Path

import click

from scalar.cli.group import cli
from scalar.cli.options import OUTPUT, PATH, lock_output
from scalar.cli.outputs import FORCE
from scalar.cli.simulator import simulator
from scalar.cli.terminal import say


@cli.command()
@click.argument("config", type=PATH)
@OUTPUT
@click.option("--seed", type=click.IntRange(min=0), help="Seed to use instead of that in CONFIG.")
@FORCE
def simulate(config: Path, output: Path, seed: int | None, force: bool) -> None:
    """Simulate a dataset with pybullet.

    CONFIG describes the scene. Writes the dataset to DIR/dataset and its truth to DIR/truth.

    \b
    Example:
      scalar simulate configs/scenes/paper.yaml -o sim
      scalar calibrate sim/dataset -o out
      scalar evaluate out/calibration.json sim/truth -o out
    """
    from scalar.cli.progress import progress

    simulation = simulator("simulate")
    lock_output(output)
    content = simulation.load_config(config)
    if seed is not None:
        content["seed"] = seed
    with progress("placing the scanner") as advance:
        scene = simulation.simulate(content, base_dir=config.parent, progress=advance)
    simulation.write_scene(scene, output, force=force)
    say(
        f"{output / 'dataset'}: {len(scene.poses)} poses, {len(scene.scans)} points; truth in {output / 'truth'}"
    )
