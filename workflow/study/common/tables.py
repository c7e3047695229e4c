"""Tables of a study as CSV: whole or not at all, enough digits, the same bytes from the same numbers."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from scalar.data.io.atomic import atomic_write

DIGITS = 9  # of a number in a table: rounding shows neither in a figure nor in a comparison


def write_table(path: str | Path, table: pd.DataFrame, digits: int = DIGITS) -> None:
    """Write a table to a CSV file, numbers with so many significant digits."""
    with atomic_write(path) as temporary:
        table.to_csv(temporary, index=False, float_format=f"%.{digits}g", lineterminator="\n")


def read_table(path: str | Path) -> pd.DataFrame:
    """Return the table in a CSV file."""
    return pd.read_csv(path)


def of_case(table: pd.DataFrame, case: str) -> pd.DataFrame:
    """Return the rows of one case of a study, in their order."""
    return table.loc[table["case"].astype(str) == case]


def read_tables(paths: Sequence[str | Path]) -> pd.DataFrame:
    """Return tables of the same columns below one another, in the order given; an empty cell is missing, the word null is a word."""
    tables = [pd.read_csv(path, keep_default_na=False, na_values=["", "nan"]) for path in paths]
    return pd.concat(tables, ignore_index=True)
