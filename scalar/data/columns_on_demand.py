"""Columns of a table of poses that are computed when one of them is first asked for: the fit of a rigid arm needs none of them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import cached_property

from scalar.geometry.se3 import Array


class ColumnsOnDemand(Mapping[str, Array]):
    """Columns by name, ``(N,)`` each.

    Args:
        compute: Returns the columns.
    """

    def __init__(self, compute: Callable[[], dict[str, Array]]) -> None:
        self._compute = compute

    @cached_property
    def _columns(self) -> dict[str, Array]:
        return self._compute()

    def __getitem__(self, name: str) -> Array:
        """Return a column by name."""
        return self._columns[name]

    def __iter__(self) -> Iterator[str]:
        """Return the names."""
        return iter(self._columns)

    def __len__(self) -> int:
        """Return the number of columns."""
        return len(self._columns)
