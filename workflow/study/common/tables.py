"""Read and write the tables of a study as CSV files. A table is written whole or not at all, and the same numbers give the same bytes."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from scalar.data.io.atomic import atomic_write

DIGITS = 9  # significant digits of a number in a table: enough for every figure and comparison


def write_table(path: str | Path, table: pd.DataFrame, digits: int = DIGITS) -> None:
    """Write a table to a CSV file, with ``digits`` significant digits of each number."""
    with atomic_write(path) as temporary:
        table.to_csv(temporary, index=False, float_format=f"%.{digits}g", lineterminator="\n")


def read_table(path: str | Path) -> pd.DataFrame:
    """Return the table in a CSV file."""
    return pd.read_csv(path)


def of_case(table: pd.DataFrame, case: str) -> pd.DataFrame:
    """Return the rows of one case of a study, in their order."""
    return table.loc[table["case"].astype(str) == case]


def read_tables(paths: Sequence[str | Path]) -> pd.DataFrame:
    """Return tables with the same columns as one, in the given order; an empty cell and ``nan`` are missing values, ``null`` is a text."""
    tables = [pd.read_csv(path, keep_default_na=False, na_values=["", "nan"]) for path in paths]
    return pd.concat(tables, ignore_index=True)
