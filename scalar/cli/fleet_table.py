"""``scalar diagnose --batch``: many datasets, one table."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from scalar.cli.fleet import Job, run_all
from scalar.cli.fleet_folders import datasets_in, names_of
from scalar.cli.progress import progress
from scalar.cli.terminal import say, say_written

TABLE = "fleet.csv"


def diagnose_fleet(
    folders: Sequence[Path], output: Path, folds: int, modules: Sequence[Path], cores: int | None = None
) -> int:
    """Diagnose all datasets of some folders, write one table, and return the exit status: 0, or that of the first that was refused.

    Args:
        folders: Datasets, or folders with datasets below them.
        output: Folder for the table and a folder of results for each dataset.
        folds: Number of parts of the outer split; 0 for quick answers.
        modules: Files with effects from outside the package.
        cores: Number of processes that run at once; None for as many as there are processors that this process may use.

    Raises:
        InvalidInput: The output cannot be written.
    """
    from scalar.data.io.regular_file import refuse_special
    from scalar.diagnosis.held_out.repeated_runs import available_cores
    from scalar.report import prepare
    from scalar.report.fleet_row import COLUMNS, cells

    refuse_special(output / TABLE)
    prepare()  # once here, and not in each forked process
    datasets = datasets_in(folders, output)
    names = names_of(datasets)
    jobs = [
        Job(name, path, output / name, folds, tuple(modules))
        for name, path in zip(names, datasets, strict=True)
    ]
    finished: dict[int, str] = {}
    said = 0
    with progress("diagnosing") as advance:

        def done(k: int, row: Mapping[str, Any]) -> None:
            """Print the lines of finished datasets in the order of the table, whichever is finished first."""
            nonlocal said
            finished[k] = _line(row)
            advance(f"diagnosing {len(jobs)} datasets", len(finished), len(jobs))
            while said in finished:
                say(finished[said])
                said += 1

        advance(f"diagnosing {len(jobs)} datasets", 0, len(jobs))
        rows = run_all(jobs, cores or available_cores(), done)
    _write(output / TABLE, [list(COLUMNS), *(cells(row) for row in rows)])
    refused = [int(row["status"]) for row in rows if row["status"]]
    say_written(output / TABLE, len(rows), "dataset", f", {len(refused)} refused")
    return refused[0] if refused else 0


def _line(row: Mapping[str, Any]) -> str:
    """Return one line for the terminal on what was found in a dataset."""
    if row["status"]:
        return f"{row['folder']}: refused, {row['message']}"
    unsure = f"perhaps {row['unsure_effects']}" if row["unsure_effects"] else ""
    found = "; ".join(filter(None, [row["effects"], unsure])) or "no effect found"
    before, after = row["held_out_before_mm"], row["held_out_after_mm"]
    return f"{row['folder']}: {found} ({before:.4f} -> {after:.4f} mm on held-out poses)"


def _write(path: Path, lines: Sequence[Sequence[str]]) -> None:
    from scalar.data.io.atomic import atomic_write

    with atomic_write(path) as temporary, open(temporary, "w", encoding="utf-8", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows(lines)
