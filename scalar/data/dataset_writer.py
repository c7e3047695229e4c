"""The one writer of datasets: a folder that appears whole or not at all, with numbers that read back exactly."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from scalar.data.description import DESCRIPTION
from scalar.data.folder import POSES, known_files
from scalar.data.io.atomic import atomic_directory
from scalar.data.io.plain_yaml import dump_yaml, load_yaml
from scalar.errors import InvalidInput

if TYPE_CHECKING:
    import pandas as pd


def write_dataset(
    dataset_dir: str | os.PathLike[str],
    *,
    mapping: dict[str, Any],
    poses: pd.DataFrame,
    table_format: str = "csv",
    **measured: pd.DataFrame | None,
) -> None:
    """Write a dataset folder, which appears whole or not at all; numbers read back exactly as they were.

    Args:
        dataset_dir: replaced if it is a dataset already and holds nothing else.
        mapping: the content of dataset.yaml.
        poses: the rows of poses.csv.
        table_format: ``csv`` or ``parquet``, for the measurements.
        measured: the rows of the measurements, by the name of their file, as in ``scans=`` or ``points=``.

    Raises:
        InvalidInput: the folder cannot be written, or holds something else than a dataset.
        ValueError: a number is not finite.
    """
    if table_format not in ("csv", "parquet"):
        raise ValueError(f"table_format is csv or parquet, not {table_format!r}")
    with atomic_directory(dataset_dir, may_replace=_is_dataset) as folder:
        dump_yaml(mapping, folder / DESCRIPTION)
        _write_table(poses, folder / POSES)
        for name, table in measured.items():
            if table is not None:
                _write_table(table, folder / f"{name}.{table_format}")


def _is_dataset(path: Path) -> bool:
    """Return whether a folder holds a dataset and nothing else."""
    if not {item.name for item in path.iterdir()} <= set(known_files()):
        return False
    try:
        mapping = load_yaml(path / DESCRIPTION)
    except InvalidInput:
        return False
    return isinstance(mapping, dict) and str(mapping.get("format", "")).startswith("scalar-dataset/")


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
