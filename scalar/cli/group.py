"""The group of all commands: its help, and what an error becomes on the terminal: a line a fault on stderr, and an exit status."""

from __future__ import annotations

from typing import Any

import click

from scalar import __version__
from scalar.errors import ScalarError


class _Group(click.Group):
    """A group that turns the package's own errors into lines on stderr and an exit status."""

    def invoke(self, ctx: click.Context) -> Any:
        try:
            return super().invoke(ctx)
        except ScalarError as error:
            for line in str(error).splitlines() or [type(error).__name__]:
                click.echo(f"scalar: {line}", err=True)
            ctx.exit(error.exit_status)
        except OSError as error:
            click.echo(f"scalar: {error.filename or 'output'}: {error.strerror or error}", err=True)
            ctx.exit(2)


@click.group(cls=_Group, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.version_option(__version__, prog_name="scalar")
def cli() -> None:
    """Calibrate a robot and the sensor on its flange together, from scans of three rough planes.

    \b
    Your own data in four lines:
      scalar validate my-cell
      scalar calibrate my-cell -o out
      scalar predict out/calibration.json joints.csv -o frames.csv
      scalar diagnose my-cell -o out          # what does the model lack?

    Exit status: 0 done; 2 the input is at fault; 3 the data cannot determine the model.
    """
