"""What a dataset folder holds for each kind of sensor: what dataset.yaml has to state, and which table has the measurements.

The reader knows no kind by name. Every kind (``scalar.sensors``) adds its format here when it is registered. When formats are first
asked for, each function that was given to ``supply_from`` is called once; ``scalar/__init__.py`` gives it the one that registers the kinds.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class MeasuredTable:
    """The table of what a sensor measured, ``<stem>.csv`` or ``<stem>.parquet``.

    Attributes:
        stem: Name of the file without its ending.
        units: ``{column: unit}`` of every column besides ``pose``, in the order of ``Dataset.points``; a unit is ``m`` or ``rad``.
        several_rows: Whether a pose may have any number of rows, at least one; else it has exactly one, or one for each item.
        row: What messages call the thing that a row describes.
        largest: Largest length that can be meant [m]; a larger number is taken for one in other units.
        optional: ``{column: unit}`` of further columns that version 2 of the format may have.
        together: Groups of optional columns that are given together or not at all.
        noises: Those of the optional columns that are standard deviations.
        item: Text column that names which of several items (targets, nests) a row measures; a pose then has a row for each item that was
            measured. None if the table has no such column.
    """

    stem: str
    units: Mapping[str, str]
    several_rows: bool
    row: str
    largest: float
    optional: Mapping[str, str] = field(default_factory=dict[str, str])
    together: tuple[tuple[str, ...], ...] = ()
    noises: tuple[str, ...] = ()
    item: str | None = None

    @property
    def columns(self) -> tuple[str, ...]:
        """Return the names of all columns, ``pose`` first."""
        return ("pose", *self.units)

    @property
    def further(self) -> tuple[str, ...]:
        """Return the names of the further columns that version 2 of the format may have."""
        return (*([] if self.item is None else [self.item]), *self.optional)

    @property
    def files(self) -> tuple[str, str]:
        """Return the names that the file may have."""
        return (f"{self.stem}.csv", f"{self.stem}.parquet")


@dataclass(frozen=True)
class SensorFormat:
    """What a dataset folder holds for one kind of sensor.

    Attributes:
        kind: Name of the kind, as in ``sensor.kind`` of dataset.yaml.
        on_planes: Whether every pose measures one of the planes that dataset.yaml lists and poses.csv names.
        needs_nominal_pose: Whether ``sensor.nominal_pose`` has to be stated.
        table: The table of the measurements; None if joint angles and plane are the whole measurement.
        references: The table of points fixed to the base, which version 2 of the format may have; None if the kind has no such table.
        options: Further keys under ``sensor`` in dataset.yaml, each with its JSON schema; its ``description`` is used in messages.
    """

    kind: str
    on_planes: bool
    needs_nominal_pose: bool
    table: MeasuredTable | None
    references: MeasuredTable | None = None
    options: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)

    @property
    def scans(self) -> bool:
        """Return whether a pose measures many points of a plane at once."""
        return self.on_planes and self.table is not None

    @property
    def measured_in(self) -> str:
        """Return the file that has what was measured, as messages name it: that of the table, or poses.csv where there is none."""
        return "poses.csv" if self.table is None else f"{self.table.stem}.csv"


_formats: dict[str, SensorFormat] = {}
_suppliers: list[Callable[[], object]] = []


def supply_from(supplier: Callable[[], object]) -> None:
    """Have ``supplier`` called once, when formats are first asked for; it adds formats by ``add_format``."""
    _suppliers.append(supplier)


def add_format(format: SensorFormat) -> None:
    """Add the format of a kind of sensor, replacing an earlier one of the same kind."""
    _formats[format.kind] = format


def remove_format(kind: str) -> None:
    """Remove the format of a kind of sensor."""
    del _formats[kind]


def sensor_formats() -> Mapping[str, SensorFormat]:
    """Return ``{kind: format}`` of all kinds of sensor, in the order in which they were added."""
    while _suppliers:
        _suppliers.pop(0)()
    return _formats
