"""The group of all commands: its help, and how errors are reported: one line on stderr for each fault, and an exit status."""

from __future__ import annotations

import os
import sys
from typing import Any, NoReturn, TextIO

import click

from scalar import __version__
from scalar.cli import unexpected
from scalar.cli.terminal import say
from scalar.errors import ScalarError

_ARGUMENTS = "scalar.cli.arguments"
_INTERRUPTED = 130  # as of a shell: 128 plus the number of the signal SIGINT
_BROKEN_PIPE = 141  # the same for SIGPIPE


def _discard(*streams: TextIO) -> None:
    """Let what is still buffered, and what is written later, go nowhere: the reader of these streams has ended."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    for stream in streams:
        os.dup2(nowhere, stream.fileno())


def _end_without_reader() -> NoReturn:
    """End without a message because the reader of the output has ended, as ``head`` does, which is no fault."""
    _discard(sys.stdout, sys.stderr)
    sys.exit(_BROKEN_PIPE)


def _report(text: str) -> None:
    """Write lines on stderr, each with the name of the program; nothing if the reader of stderr has ended.

    The exit status then still says what was wrong, and does not depend on when the reader ended.
    """
    try:
        for line in text.splitlines():
            say(f"scalar: {line}", err=True)
    except BrokenPipeError:
        _discard(sys.stderr)


class _Group(click.Group):
    """A group that reports errors, whether the package's own, the system's or any other, as lines on stderr and an exit status."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        ctx.meta[_ARGUMENTS] = list(args)
        return super().parse_args(ctx, args)

    def make_context(self, *args: Any, **kwargs: Any) -> click.Context:
        try:
            return super().make_context(*args, **kwargs)
        except BrokenPipeError:  # help is printed here
            _end_without_reader()

    def main(self, *args: Any, **kwargs: Any) -> Any:
        try:
            return super().main(*args, **kwargs)
        except BrokenPipeError:  # click was writing what is wrong with the arguments
            _discard(sys.stdout, sys.stderr)
            sys.exit(click.UsageError.exit_code)

    def invoke(self, ctx: click.Context) -> Any:
        try:
            return super().invoke(ctx)
        except ScalarError as error:
            _report(str(error) or type(error).__name__)
            ctx.exit(error.exit_status)
        except BrokenPipeError:
            _end_without_reader()
        except OSError as error:
            _report(f"{error.filename or 'output'}: {error.strerror or error}")
            ctx.exit(2)
        except KeyboardInterrupt:
            ctx.exit(_INTERRUPTED)
        except (click.ClickException, click.exceptions.Exit, click.Abort):
            raise
        except Exception as error:
            try:
                unexpected.report(error, ctx.meta[_ARGUMENTS])
            except BrokenPipeError:
                _discard(sys.stderr)
            ctx.exit(unexpected.EXIT_STATUS)


@click.group(
    cls=_Group,
    epilog=f"{unexpected.TRACEBACK}=1 in the environment shows where a fault of the software itself arose.",
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
)
@click.version_option(__version__, prog_name="scalar")
def cli() -> None:
    """Calibrate a robot and the sensor on its flange together.

    The data are scans of three or more planes, contacts of a touch probe with planes, or points of a laser tracker. Initial guesses of the
    planes suffice.

    \b
    Your own data in five lines:
      scalar init my-cell --robot ur10e --sensor line-laser
      scalar validate my-cell
      scalar calibrate my-cell -o out
      scalar predict out/calibration.json joints.csv -o frames.csv
      scalar diagnose my-cell -o out          # what does the model lack?

    Exit status: 0 done; 2 the input is at fault; 3 the data cannot determine the model;
    70 a fault of the software itself; 130 interrupted; 141 the program that read the output has ended.
    """
