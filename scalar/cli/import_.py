"""``scalar import``: make a dataset from tables of another form."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import click

from scalar.cli.group import cli
from scalar.cli.options import BASE, PATH, TIP, refuse_links_without_urdf
from scalar.cli.outputs import FORCE
from scalar.cli.terminal import say
from scalar.cli.validate import describe_content
from scalar.errors import Fault, InvalidInput

_TABLES = {".csv", ".mat", ".tsv", ".xlsm", ".xlsx"}
_YAML = {".yaml", ".yml"}
_FILES_SHOWN = 6  # files of which rows were left out that are named


def _say_keys(context: click.Context, _option: click.Parameter, wanted: bool) -> None:
    """Print every key of a mapping with its meaning, and end."""
    from scalar.ingest.mapping_keys import keys_of_a_mapping

    if not wanted or context.resilient_parsing:
        return
    for key, meaning in keys_of_a_mapping():
        say(f"{key}: {meaning}" if meaning else key)
    context.exit()


def _say_example(context: click.Context, _option: click.Parameter, folder: Path | None) -> None:
    """Print a mapping to begin with, and end."""
    from scalar.ingest.example_mapping import example_mapping

    if folder is None or context.resilient_parsing:
        return
    say(example_mapping(folder))
    context.exit()


@cli.command("import")
@click.argument("mapping", type=PATH)
@click.argument("sources", metavar="SOURCE...", type=PATH, nargs=-1, required=True)
@click.option("-o", "--output", "output", type=PATH, required=True, help="Dataset folder to write.")
@click.option(
    "--urdf", type=PATH, metavar="FILE", help="URDF of the robot, if the dataset in MAPPING has no robot."
)
@BASE
@TIP
@click.option(
    "--example",
    type=PATH,
    metavar="FOLDER",
    is_eager=True,
    expose_value=False,
    callback=_say_example,
    help="Print a mapping to begin with for the robot and the sensor of FOLDER, which `scalar init` wrote, and end.",
)
@click.option(
    "--keys",
    is_flag=True,
    is_eager=True,
    expose_value=False,
    callback=_say_keys,
    help="Print every key that MAPPING may have, with its meaning, and end. NAME stands for a name of your choice, [] for each entry of a list.",
)
@FORCE
def import_(
    mapping: Path,
    sources: Sequence[Path],
    output: Path,
    urdf: Path | None,
    base: str | None,
    tip: str | None,
    force: bool,
) -> None:
    """Import foreign tables into a dataset.

    The YAML file MAPPING states columns, units and separators of the tables. A SOURCE is a CSV file, a spreadsheet
    (.xlsx), a MATLAB matrix (.mat), or a folder that holds the files that MAPPING names. docs/mapping.md has small mappings for a tracker and a
    scanner; 'scalar import --keys' prints all keys.

    \b
    Map a table with a whole profile in each row and x in the headers of its columns (Keyence LJ) like this:
      points:
        files: [{name: LJ_profiles.csv}]
        text: {separator: ",", decimal: ".", missing: ["-99.9999"]}
        row_profiles: {}
        drop_without: [z]
        columns:
          pose: {column: "No."}
          x: {column: "@x", unit: mm}
          z: {column: "@z", unit: mm}
    If each column is a profile, write column_profiles: {x: "X [mm]"} instead, and pose: {column: "@head_number"}.

    \b
    Example (see configs/measured for complete mappings):
      scalar import --example my-cell > my-tracker.yaml       # a mapping to begin with, for tables in degrees and millimetres
      scalar import my-tracker.yaml measurements.csv -o my-cell
      scalar import my-tracker.yaml measurements.csv --urdf robot.urdf --tip tool0 -o my-cell
      scalar diagnose my-cell -o out
    """
    from scalar.data.folder import read_folder
    from scalar.ingest.convert import import_dataset

    _refuse_exchanged(mapping, sources)
    refuse_links_without_urdf(urdf, base, tip)
    robot = None
    if urdf is not None:
        from scalar.ingest.urdf import robot_from_urdf

        robot = robot_from_urdf(urdf, base, tip)[0].to_mapping()
    left_out, of_joints = import_dataset(mapping, sources, output, robot, force=force)
    say(describe_content(read_folder(output)))
    for rows in left_out[:_FILES_SHOWN]:
        say(f"  {rows}")
    if more := left_out[_FILES_SHOWN:]:
        say(
            f"  {len(more)} more files of which rows were left out: {sum(len(rows.rows) for rows in more)} rows in all"
        )
    for sentence in of_joints:
        say(f"  {sentence}")
    say(f"written: {output}")


def _refuse_exchanged(mapping: Path, sources: Sequence[Path]) -> None:
    """Raise InvalidInput if a table stands where the mapping is expected, and a YAML file among the tables."""
    yaml = [source for source in sources if source.suffix.lower() in _YAML]
    if yaml and mapping.suffix.lower() in _TABLES:
        message = f"a table, where the mapping is expected; the mapping comes first: scalar import {yaml[0]} {mapping} -o ..."
        raise InvalidInput(Fault(str(mapping), message))
