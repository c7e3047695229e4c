"""Show on stderr what is running, if stderr is a terminal."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager


@contextmanager
def progress(label: str) -> Iterator[Callable[[str, int, int], None]]:
    """Show a progress bar on stderr while the block runs, if stderr is a terminal; yields ``advance(stage, done, total)``."""
    if not sys.stderr.isatty():
        yield lambda stage, done, total: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(label, total=None)
        yield lambda stage, done, total: bar.update(
            task, description=stage, completed=done, total=total or None
        )


@contextmanager
def stages_and_runs() -> Iterator[tuple[Callable[[str], None], Callable[[int, int], None]]]:
    """Show on stderr which stage is running, and a bar for repeated runs, if stderr is a terminal.

    Yields a function that takes the stage's name, and one that takes the number of finished runs and of all runs.
    """
    with progress("reading") as advance:
        yield (
            lambda stage: advance(stage, 0, 0),
            lambda done, total: advance("diagnosing without a part of the poses", done, total),
        )
