"""``scalar demo``: inject a secret effect in a simulated workcell, diagnose it, and say afterwards what the secret was."""

from __future__ import annotations

import random
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import click

from scalar.cli.group import cli
from scalar.cli.options import PATH
from scalar.cli.simulator import simulator
from scalar.cli.terminal import say
from scalar.units import DEG, MM

_REMEDY = "the demo overwrites nothing; name another folder by -o"
_SEEDS = 10_000
"""A seed is drawn below this number if none is given. Arbitrary: small, so that a seed is quick to retype."""


@cli.command()
@click.option(
    "-o", "--output", type=PATH, metavar="DIR", help="Folder to write to; scalar-demo-SEED if not given."
)
@click.option(
    "--seed", type=click.IntRange(min=0), help="Seed of a demonstration to repeat; drawn if not given."
)
def demo(output: Path | None, seed: int | None) -> None:
    """Show a diagnosis on a simulated workcell with a secret effect.

    The arm, its sensor or its surroundings get an effect that the rigid model lacks. The dataset does not say which. The diagnosis reads
    only the dataset; the secret is revealed after its answer. This needs pybullet. Nothing is overwritten.

    Writes DIR/dataset, DIR/truth and DIR/diagnosis, which has report.html.

    \b
    Example:
      scalar demo
      scalar demo --seed 7 -o my-demo
    """
    simulation = simulator("demo")
    seed = random.randrange(_SEEDS) if seed is None else seed
    output = Path(f"scalar-demo-{seed}") if output is None else output
    scene = _scene(seed)
    from scalar.cli.diagnosis_words import describe_diagnosis
    from scalar.cli.progress import progress, stages_and_runs
    from scalar.data.dataset import read_dataset
    from scalar.data.io.atomic import atomic_directory
    from scalar.diagnosis import diagnose
    from scalar.report.output import write_diagnosis
    from scalar.report.pose_numbers import with_pose_numbers

    with atomic_directory(output, remedy=_REMEDY) as folder:
        say(
            f"1 of 3: a simulated {scene['robot']['name']} gets a secret effect and scans {len(scene['planes'])} planes "
            f"(seed {seed})"
        )
        with progress("placing the scanner") as advance:
            simulated = simulation.simulate(scene, progress=advance)
        simulation.write_scene(simulated, folder)
        dataset = read_dataset(folder / "dataset")
        say(f"2 of 3: {len(dataset.poses)} poses are diagnosed; the dataset does not mention the secret")
        with stages_and_runs() as (advance, _):
            result = diagnose(dataset, progress=advance, outer_folds=0)
        say("3 of 3: the report is written")
        (folder / "diagnosis").mkdir()
        write_diagnosis(result, folder / "diagnosis")
    say(f"\n{describe_diagnosis(result)}")
    say(f"\nreport: {output / 'diagnosis' / 'report.html'} (opens in a browser, offline)")
    for secret in simulated.truth["effects"]:
        say(with_pose_numbers(reveal(secret, result.to_mapping()["effects"], result.verdict), dataset))
    say(
        f"next: `scalar diagnose {output / 'dataset'} -o {output / 'tested'}` tests the findings on poses that took no part in the diagnosis;"
    )
    say("  `scalar init --help` says how to begin a dataset of your own")


def reveal(secret: Mapping[str, Any], found: list[Mapping[str, Any]], verdict: str) -> str:
    """Return a sentence on what the secret was, and whether the diagnosis has named it.

    Args:
        secret: An entry of ``effects`` in truth.json.
        found: ``effects`` of diagnosis.json.
        verdict: Its ``verdict``.
    """
    from scalar.report import words

    same_kind = [entry for entry in found if entry["name"] == secret["name"]]
    if any(_same_place(entry["target"], secret["target"]) for entry in same_kind):
        outcome = "the diagnosis has named it"
    elif same_kind:
        outcome = "the diagnosis has named this kind of effect, but at another place"
    elif found:
        outcome = "the diagnosis has named something else"
    else:
        outcome = f"the diagnosis has not named it; its verdict is `{verdict}`"
    title = words.title(secret["name"], secret["target"])
    return f"the secret was: {title}, {_size(secret)}; {outcome}"


def _size(secret: Mapping[str, Any]) -> str:
    """Return how large a secret is, in the units of the diagnosis; of a compliance the largest deflection."""
    size, unit = secret["size"], secret["unit"]
    deflections = [secret.get("largest_tilt_rad", 0.0), *secret.get("largest_deflection_rad", {}).values()]
    if max(deflections) > 0:
        return f"up to {max(deflections) / DEG:.2g} deg, with {size:.3g} {unit}"
    divisor, shown = {"rad": (DEG, "deg"), "m": (MM, "mm")}.get(unit, (1.0, unit))
    return f"of size {size / divisor:.3g} {shown}"


def _same_place(found: Mapping[str, Any], secret: Mapping[str, Any]) -> bool:
    """Return whether two targets name the same place.

    The beginnings of changes (`at`) are not compared. The joints that were found may be any subset of the true ones. Of several orders that were
    found, one has to be the true one.

    Args:
        found: Target of an effect of the diagnosis.
        secret: Target of the injected effect.
    """
    if "joints" in secret:
        joints = set(found.get("joints") or [found.get("joint")])
        return joints <= set(secret["joints"])
    if "order" in secret and "orders" in found:
        return found.get("joint") == secret.get("joint") and secret["order"] in found["orders"]
    return all(found.get(key) == value for key, value in secret.items() if key != "at")


def _scene(seed: int) -> dict[str, Any]:
    """Return the config of the workcell with the secret that the seed draws."""
    from importlib import resources

    from scalar.data.io.plain_yaml import load_yaml
    from scalar.robots import read_arm

    with resources.as_file(resources.files("scalar.simulation").joinpath("demo.yaml")) as path:
        content = load_yaml(path)
    secret = random.Random(seed).choice(content["secrets"])
    robot = dict(read_arm(content["robot"]).mapping)
    return {**content["scene"], "seed": seed, "robot": robot, "injected": [{"effect": secret}]}
