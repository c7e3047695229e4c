"""Arguments and options that several commands share, and the lock on the output folder."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import click

from scalar.errors import Fault, InvalidInput


class _Path(click.Path):
    """A path that is not empty: an empty one, as of a variable that is not set in a script, would be the working directory."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if value == "" or "\0" in str(value):
            self.fail("an empty path, or one with a null character; write the path", param, ctx)
        return super().convert(value, param, ctx)


class Number(click.FloatRange):
    """A finite number within bounds; ``nan`` compares with none of them, and would be within all."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        number = super().convert(value, param, ctx)
        if not math.isfinite(number):
            self.fail(f"{value} is not a finite number", param, ctx)
        return number


PATH = _Path(path_type=Path)
OUTPUT = click.option(
    "-o",
    "--output",
    "output",
    type=PATH,
    metavar="DIR",
    required=True,
    help="Folder to write to; made if missing.",
)

COMMANDED = click.option(
    "--commanded",
    is_flag=True,
    help="Use the commanded joint positions, qc1..qcn, instead of the logged ones, q1..qn.",
)

URDF = click.option(
    "--urdf", type=PATH, metavar="FILE", help="Robot description in URDF, with --base and --tip."
)
BASE = click.option(
    "--base", metavar="LINK", help="With --urdf: the link of the base; the root if not given."
)
TIP = click.option(
    "--tip", metavar="LINK", help="With --urdf: the link of the flange; the only last link if not given."
)

UNITS = click.option(
    "--units",
    metavar="deg,mm",
    help="Units of the tables: deg or rad, mm or m; rad,m if not given. A column may state its own (q1_deg, x_mm); the output then has them too. "
    "Degrees are written with mm unless m is stated or the travel of a joint is read in m.",
)

EFFECTS_MODULE = click.option(
    "--effects-module",
    "effects_modules",
    type=PATH,
    multiple=True,
    metavar="FILE.py",
    help="Python file with effects of your own (docs/extending.md says how); may be given again.",
)


@contextmanager
def advice_on_units() -> Iterator[None]:
    """Mention the option ``--units deg`` in the messages of faults, raised in the block, about angles that may be degrees."""
    try:
        yield
    except InvalidInput as error:
        said, say = "are these degrees? write radians", "are these degrees? say --units deg, or write radians"
        raise InvalidInput([replace(f, message=f.message.replace(said, say)) for f in error.faults]) from None


def load_effects(files: Sequence[Path]) -> None:
    """Register the effects that Python files define.

    Raises:
        InvalidInput: A file is missing, does not run, or defines no effect.
    """
    if files:
        from scalar.effects import registry

        for file in files:
            registry.load_file(file)


def refuse_links_without_urdf(urdf: Path | None, base: str | None, tip: str | None) -> None:
    """Raise InvalidInput if links are named of a URDF that is not given."""
    if urdf is None and (base is not None or tip is not None):
        message = "name links of a URDF; give --urdf FILE too, or leave them out"
        raise InvalidInput(Fault("--base, --tip", message))


def lock_output(folder: Path) -> None:
    """Make an output folder if it is missing, and lock it until this command ends, so that two commands do not mix their files.

    Raises:
        InvalidInput: The folder cannot be written, or another running process is writing to it.
    """
    from scalar.data.io.lock import locked

    click.get_current_context().with_resource(locked(folder))


def split_names(names: str | None) -> Sequence[str]:
    """Return the names of an option of the form ``NAME,...``."""
    return [name.strip() for name in names.split(",") if name.strip()] if names else ()
