"""A dataset reduced to rows, once for each set of functions that its effects need kept: every refit of a diagnosis asks for the same."""

from __future__ import annotations

from collections.abc import Sequence

from scalar.data.dataset import Dataset
from scalar.sensors import Measurement, measure


class MeasuredRows:
    """The rows of a dataset, compressed when they are first asked for."""

    def __init__(self, dataset: Dataset) -> None:
        """Take the dataset, which must not change."""
        self._dataset = dataset
        self._known: dict[tuple[str, ...], Measurement] = {}

    def keeping(self, extra_basis: Sequence[str]) -> Measurement:
        """Return the rows with some functions of a point kept, as ``scalar.sensors.measure`` gives them."""
        names = tuple(extra_basis)
        if names not in self._known:
            self._known[names] = measure(self._dataset, names)
        return self._known[names]
