"""``scalar init``: write a commented dataset folder for a robot and a sensor, ready to be filled."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import click

from scalar.cli.group import cli
from scalar.cli.options import BASE, PATH, TIP, URDF, refuse_links_without_urdf
from scalar.cli.terminal import say
from scalar.errors import Fault, InvalidInput


@cli.command()
@click.argument("folder", type=PATH, required=False)
@click.option("--robot", metavar="NAME", help="An arm of the library; --list shows them.")
@URDF
@BASE
@TIP
@click.option(
    "--dh",
    type=PATH,
    metavar="TABLE.csv",
    help="Table a_mm,alpha_deg,d_mm,theta_deg (or _m, _rad), one row per joint; optional: lower_deg,upper_deg (limits; lower_mm,upper_mm "
    "where a joint slides), type, joint (its number).",
)
@click.option(
    "--convention",
    type=click.Choice(["modified-dh", "standard-dh"]),
    help="With --dh: modified parameters (Craig: Rx(alpha) Tx(a) Rz(q + theta) Tz(d)), or standard ones (distal: Rz(q + theta) Tz(d) "
    "Tx(a) Rx(alpha)).",
)
@click.option("--sensor", metavar="KIND", help="line-laser, probe or tracker.")
@click.option("--list", "list_arms", is_flag=True, help="List the arms of the library, and do nothing else.")
def init(
    folder: Path | None,
    robot: str | None,
    urdf: Path | None,
    base: str | None,
    tip: str | None,
    dh: Path | None,
    convention: str | None,
    sensor: str | None,
    list_arms: bool,
) -> None:
    """Begin a dataset: write a commented folder, ready to be filled.

    FOLDER must not exist, or be empty. The robot comes from the library, from a URDF or from a table of Denavit-Hartenberg
    parameters; choose one of --robot, --urdf and --dh. README.txt in the folder says what belongs into which file.

    \b
    Example:
      scalar init --list
      scalar init my-cell --robot ur10e --sensor line-laser
      scalar init my-cell --urdf arm.urdf --base base_link --tip tool0 --sensor tracker
      scalar validate my-cell                 # what is still missing
    """
    if list_arms:
        say(describe_library())
        return
    if folder is None:
        raise click.UsageError("Missing argument 'FOLDER'.")
    if sum(choice is not None for choice in (robot, urdf, dh)) != 1:
        message = (
            "give one of --robot NAME, --urdf FILE and --dh TABLE.csv; `scalar init --list` shows the names"
        )
        raise InvalidInput(Fault("the robot", message))
    refuse_links_without_urdf(urdf, base, tip)
    if dh is not None and dh.suffix.lower() in (".urdf", ".xacro"):
        raise InvalidInput(Fault("--dh", f"{dh} is no DH table but a URDF; give it with --urdf"))
    if (dh is None) != (convention is None):
        missing = "--convention" if convention is None else "--dh"
        raise InvalidInput(
            Fault(
                missing,
                "missing; --dh and --convention belong together: in modified-dh (Craig's) a and alpha of a row come before the turn of its joint, "
                "in standard-dh after it",
            )
        )
    from scalar.data.blank_dataset import write_blank_dataset
    from scalar.data.sensor_formats import sensor_formats

    formats = sensor_formats()
    if sensor is None or sensor not in formats:
        raise InvalidInput(Fault("--sensor", _no_kind(sensor, formats)))
    mapping, about, remarks = _described(robot, urdf, base, tip, dh, convention)
    write_blank_dataset(folder, mapping, formats[sensor], about, remarks)
    say(f"{folder}: an empty dataset for {mapping['name']}, {len(mapping['joints'])} joints, and a {sensor}")
    for line in [*about, *remarks]:
        say(f"  {line}")
    say(f"next: read {folder / 'README.txt'}, fill the files in, and `scalar validate {folder}`")
    say(
        f"  tables in degrees, millimetres or other columns: `scalar import --example {folder}` prints a mapping for them"
    )


def _no_kind(sensor: str | None, kinds: Iterable[str]) -> str:
    """Return the message about a kind of sensor that is missing or unknown; a kind whose name stands in what was written is suggested."""
    choice = f"give one of {', '.join(kinds)}"
    if sensor is None:
        return f"missing; {choice}"
    written = re.sub("[ _-]", "", sensor.lower())
    meant = [kind for kind in kinds if kind.replace("-", "") in written]
    return f"no kind {sensor!r}; " + (f"did you mean {meant[0]}? " if len(meant) == 1 else "") + choice


def describe_library() -> str:
    """Return one line for each arm of the library."""
    from scalar.robots import arm_names, read_arm

    arms = [read_arm(name) for name in arm_names()]
    width = max(len(arm.name) for arm in arms)
    lines = [
        f"{arm.name:<{width}}  {arm.maker} {arm.model}, {len(arm.mapping['joints'])} joints, reach {arm.reach:g} m"
        + ("" if arm.verified else "; UNVERIFIED")
        for arm in arms
    ]
    verified = sum(arm.verified for arm in arms)
    lines.append(
        f"{len(arms)} arms; of {verified} two sources agree. UNVERIFIED: the sources differ, or there is one only; check the numbers"
    )
    return "\n".join(lines)


def _described(
    robot: str | None,
    urdf: Path | None,
    base: str | None,
    tip: str | None,
    dh: Path | None,
    convention: str | None,
) -> tuple[Mapping[str, Any], list[str], list[str]]:
    """Return the ``robot:`` block of dataset.yaml, lines that say where it comes from, and remarks that a user should heed."""
    if robot is not None:
        from scalar.robots import read_arm

        arm = read_arm(robot)
        status = (
            "two sources agree"
            if arm.verified
            else "UNVERIFIED: check the numbers against your arm's data sheet"
        )
        lines = [f"{arm.maker} {arm.model}, from the library: {status}."]
        lines += [f"Source: {source}" for source in arm.sources]
        lines += [f"Limits: {arm.limits_source}"]
        return arm.mapping, lines, [arm.note] if arm.note else []
    if urdf is not None:
        from scalar.effects.wording import listed
        from scalar.ingest.urdf import chain_between, read_urdf, robot_of_chain

        document = read_urdf(urdf)
        chain = chain_between(document, base, tip)
        mapping = robot_of_chain(document.name, chain)[0].to_mapping()
        for joint, named in zip(mapping["joints"], chain.moving, strict=True):
            joint["name"] = named.name  # by which `scalar import-bag` finds it among the recorded joints
        lines = [f"From {urdf.name}, {chain.base} to {chain.tip}."]
        remarks: list[str] = []
        if tip is None:
            remarks.append(
                f"The sensor is described from link {chain.tip!r}, the only last one: if that is not the flange, name the flange by --tip."
            )
        if without := [joint.name for joint in chain.moving if not joint.states_limits]:
            remarks.append(
                f"No limits stated: {listed(without)}. Those in dataset.yaml are assumed: correct them, since plans stay within them."
            )
        return mapping, lines, remarks
    from scalar.ingest.dh_table import robot_from_dh_table, suspected_radians

    assert dh is not None and convention is not None
    mapping = robot_from_dh_table(dh, convention, dh.stem)
    suspicion = suspected_radians(mapping)
    return mapping, [f"From {dh.name}."], [suspicion] if suspicion else []
