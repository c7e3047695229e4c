"""``scalar import``: tables of another form into a dataset."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import click

from scalar.cli.group import cli
from scalar.cli.options import PATH
from scalar.cli.terminal import say
from scalar.cli.validate import describe_content


@cli.command("import")
@click.argument("mapping", type=PATH)
@click.argument("sources", metavar="SOURCE...", type=PATH, nargs=-1, required=True)
@click.option("-o", "--output", "output", type=PATH, required=True, help="Dataset folder to write.")
def import_(mapping: Path, sources: Sequence[Path], output: Path) -> None:
    """Import foreign tables into a dataset.

    The YAML file MAPPING states columns, units and separators of the tables. A SOURCE is a CSV file, a MATLAB matrix
    (.mat), or a folder that holds the files that MAPPING names.

    \b
    Example (see configs/measured for complete mappings):
      scalar import my-tracker.yaml measurements.csv -o my-cell
      scalar diagnose my-cell -o out
    """
    from scalar.data.folder import read_folder
    from scalar.ingest.convert import import_dataset

    import_dataset(mapping, sources, output)
    say(describe_content(read_folder(output)))
    say(f"written: {output}")
