"""The datasets that `scalar diagnose --batch` diagnoses (a fleet), and the name of each in the table and in the folder of results."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from pathlib import Path

DESCRIPTION = "dataset.yaml"
_MEASURED = {f"{table}.{ending}" for table in ("scans", "points") for ending in ("csv", "parquet")}
"""Tables of measured points. A folder with poses.csv alone may as well be a plan."""


def datasets_in(folders: Sequence[Path], output: Path | None = None) -> list[Path]:
    """Return the folders to diagnose, in the order of their names: those given that are datasets, and all datasets below the others.

    Folders that cannot be a dataset, but were probably meant as one, are returned too, so that each has a line of the table that says what is wrong:
    a folder that was given and holds no dataset; below it, a folder that holds nothing, that cannot be read, or that holds measured tables without
    a dataset.yaml. Links to folders are followed if they are
    given, but not if they are found below, since these may form a circle.

    Args:
        folders: Datasets, or folders with datasets below them.
        output: Folder of the results. Below a folder that is given it is passed over: a run that was stopped may have left empty folders in it.
    """
    found: dict[Path, None] = {}
    for folder in folders:
        below = [folder] if (folder / DESCRIPTION).is_file() else list(_below(folder, output))
        found |= dict.fromkeys(path.absolute() for path in below or [folder])
    return sorted(found, key=lambda path: path.parts)


def names_of(paths: Sequence[Path]) -> list[str]:
    """Return a name for each folder: the last parts of its path, the same number of parts for each.

    There are as few parts as leave the names distinct and none inside another. If no number of parts does, the names are numbered.

    Args:
        paths: The folders, as absolute paths, each once.
    """
    parts = [[part for part in path.parts if part != path.anchor] or ["root"] for path in paths]
    for last in range(1, max(map(len, parts), default=1) + 1):
        names = ["/".join(part[-last:]) for part in parts]
        # No result may lie inside the folder of another.
        inside = any(f"{name}/".startswith(f"{other}/") for name, other in _neighbours(sorted(names)))
        if not inside:
            return names
    return [f"{k + 1}-{part[-1]}" for k, part in enumerate(parts)]


def _neighbours(names: Sequence[str]) -> Iterator[tuple[str, str]]:
    """Yield each name with the one before it; sorted by parts, a name that lies inside another follows it."""
    ordered = sorted(names, key=lambda name: name.split("/"))
    yield from zip(ordered[1:], ordered[:-1], strict=True)


def _below(folder: Path, output: Path | None) -> Iterator[Path]:
    """Yield the datasets below a folder, and what was probably meant as one; hidden folders are left out."""
    results = None if output is None else os.path.realpath(output)
    unreadable: list[Path] = []
    for place, folders, files in os.walk(
        folder, onerror=lambda error: unreadable.append(Path(error.filename))
    ):
        nothing = not files and all(os.path.islink(os.path.join(place, name)) for name in folders)
        folders[:] = sorted(name for name in folders if not name.startswith("."))
        if Path(place) != folder and os.path.realpath(place) == results:
            folders.clear()
        elif DESCRIPTION in files or nothing or _MEASURED.intersection(files):
            folders.clear()
            yield Path(place)
    yield from unreadable
