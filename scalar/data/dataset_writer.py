"""Write datasets: folders that appear whole or not at all, with numbers that read back exactly."""

from __future__ import annotations

import hashlib
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from scalar.data.description import DESCRIPTION
from scalar.data.folder import POSES, known_files
from scalar.data.io.atomic import atomic_directory, check_replaceable
from scalar.data.io.plain_yaml import dump_yaml, load_yaml
from scalar.errors import InvalidInput

if TYPE_CHECKING:
    import pandas as pd

_FILES_SHOWN = 3  # names of files that a message lists
_MARK = "# Written by SCALAR, and replaced by it while unchanged: "
_ANOTHER = "give another place for the output, or remove what is there"


def write_dataset(
    dataset_dir: str | os.PathLike[str],
    *,
    mapping: dict[str, Any],
    poses: pd.DataFrame,
    table_format: str = "csv",
    force: bool = False,
    **measured: pd.DataFrame | None,
) -> None:
    """Write a dataset folder, which appears whole or not at all; numbers read back exactly as they were.

    Args:
        dataset_dir: the folder; a dataset there is replaced if this function wrote it and nobody has changed it since.
        mapping: the content of dataset.yaml.
        poses: the rows of poses.csv.
        table_format: ``csv`` or ``parquet``, for all tables but poses.csv.
        force: whether a dataset there is replaced in any case.
        measured: the tables of the measurements by the stem of their file's name, as in ``scans=`` or ``points=``.

    Raises:
        InvalidInput: the folder cannot be written, or holds something else.
        ValueError: a number is not finite, or the table format is unknown.
    """
    if table_format not in ("csv", "parquet"):
        raise ValueError(f"table_format must be csv or parquet, not {table_format!r}")
    may_replace = _is_dataset if force else _is_unchanged
    with atomic_directory(dataset_dir, may_replace=may_replace, remedy=_remedy(Path(dataset_dir))) as folder:
        dump_yaml(mapping, folder / DESCRIPTION)
        _write_table(poses, folder / POSES)
        for name, table in measured.items():
            if table is not None:
                _write_table(table, folder / f"{name}.{table_format}")
        with (folder / DESCRIPTION).open("a", encoding="utf-8", newline="\n") as file:
            file.write(f"{_MARK}{_checksum(folder)}\n")


def refuse_dataset(dataset_dir: str | os.PathLike[str], force: bool = False) -> None:
    """Refuse a place that ``write_dataset`` would refuse, before anything is computed for it.

    Raises:
        InvalidInput: it holds something that may not be replaced.
    """
    path = Path(dataset_dir)
    check_replaceable(path, _is_dataset if force else _is_unchanged, _remedy(path))


def _remedy(path: Path) -> str:
    """Return why a dataset may not replace what is at a path, and what to do; --force is offered only where it would help."""
    if not path.is_dir():
        return f"not a folder; {_ANOTHER}"
    others = sorted({item.name for item in path.iterdir()} - set(known_files()))
    if others:
        shown = ", ".join(others[:_FILES_SHOWN]) + (", ..." if len(others) > _FILES_SHOWN else "")
        return f"it holds more than the files of a dataset ({shown}), so that not even --force replaces it; {_ANOTHER}"
    if not _is_dataset(path):
        return f"it is no dataset, so that not even --force replaces it; {_ANOTHER}"
    return "not a dataset as SCALAR wrote it; give another place, or say --force to replace it"


def _is_dataset(path: Path) -> bool:
    """Return whether a folder holds a dataset and nothing else."""
    if not {item.name for item in path.iterdir()} <= set(known_files()):
        return False
    try:
        mapping = load_yaml(path / DESCRIPTION)
    except InvalidInput:
        return False
    return isinstance(mapping, dict) and str(mapping.get("format", "")).startswith("scalar-dataset/")


def _is_unchanged(path: Path) -> bool:
    """Return whether a folder is a dataset that ``write_dataset`` wrote and nobody has changed since."""
    if not _is_dataset(path):
        return False
    *_, last = (path / DESCRIPTION).read_text(encoding="utf-8").splitlines()
    return last == f"{_MARK}{_checksum(path)}"


def _checksum(folder: Path) -> str:
    """Return the checksum of the files of a dataset, without the line of dataset.yaml that states it."""
    digest = hashlib.sha256()
    for path in sorted(folder.iterdir()):
        content = path.read_bytes()
        if path.name == DESCRIPTION:
            content = content.partition(_MARK.encode())[0]
        digest.update(path.name.encode() + b"\0" + hashlib.sha256(content).digest())
    return digest.hexdigest()[:32]


def _write_table(table: pd.DataFrame, path: Path) -> None:
    """Write a table with float64 in the shortest form that reads back exactly, the same bytes each time."""
    numbers = table.select_dtypes("number")
    if not np.isfinite(numbers.to_numpy(dtype=float)).all():
        raise ValueError(f"{path.name}: a number is not finite")
    table = table.astype({name: np.float64 for name in table.select_dtypes("floating").columns})
    if path.suffix == ".parquet":
        import pyarrow as pa
        import pyarrow.parquet as pq

        columns = {str(name): table[name].to_numpy() for name in table.columns}
        pq.write_table(pa.table(columns), path, compression="zstd")
    else:
        table.to_csv(path, index=False, lineterminator="\n")
