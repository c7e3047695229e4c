"""What a dataset folder holds of each kind of sensor: what dataset.yaml has to say, and which table has the measurements.

The reader knows no kind by name. Every kind (``scalar.sensors``) states its format here when it is registered. Where formats are asked
for first, the suppliers that ``supply_from`` was given are called, once each; the package names its own in ``scalar/__init__.py``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class MeasuredTable:
    """The table of what a sensor measured, ``<stem>.csv`` or ``<stem>.parquet``.

    Attributes:
        stem: Of the name of the file.
        units: ``{column: unit}`` of every column besides ``pose``, in the order of ``Dataset.points``; a unit is ``m`` or ``rad``.
        several_rows: Whether a pose has one row or more; else it has exactly one, or one for each item.
        row: What a row is, in messages.
        largest: No real length is beyond this [m]; a number that is must be in other units.
        optional: ``{column: unit}`` of columns that version 2 of the format may have beside them.
        together: Groups of optional columns that come together or not at all.
        noises: Those of the optional columns that are standard deviations.
        item: Text column that names which of several things a row measures, one row for each that a pose shows; None where there is none.
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
        """Return the names of the columns that version 2 may have beside them."""
        return (*([] if self.item is None else [self.item]), *self.optional)

    @property
    def files(self) -> tuple[str, str]:
        """Return the names that the file may have."""
        return (f"{self.stem}.csv", f"{self.stem}.parquet")


@dataclass(frozen=True)
class SensorFormat:
    """What a dataset folder holds of one kind of sensor.

    Attributes:
        kind: As in ``sensor.kind`` of dataset.yaml.
        on_planes: Whether every pose measures one of the planes that dataset.yaml lists and poses.csv names.
        needs_nominal_pose: Whether ``sensor.nominal_pose`` has to be stated.
        table: The table of the measurements; None where the joint angles and the plane say it all.
        references: The table of points fixed to the base that version 2 may have beside the measurements; None where there is none.
        options: Further keys under ``sensor`` in dataset.yaml, each with its JSON schema; a ``description`` there serves in messages.
    """

    kind: str
    on_planes: bool
    needs_nominal_pose: bool
    table: MeasuredTable | None
    references: MeasuredTable | None = None
    options: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)


_formats: dict[str, SensorFormat] = {}
_suppliers: list[Callable[[], object]] = []


def supply_from(supplier: Callable[[], object]) -> None:
    """Have ``supplier`` called, once, when formats are first asked for; it adds them by ``add_format``."""
    _suppliers.append(supplier)


def add_format(format: SensorFormat) -> None:
    """Add the format of a kind of sensor, in the place of an earlier one of the same kind."""
    _formats[format.kind] = format


def remove_format(kind: str) -> None:
    """Remove the format of a kind of sensor."""
    del _formats[kind]


def sensor_formats() -> Mapping[str, SensorFormat]:
    """Return ``{kind: format}`` of all kinds of sensor, in the order in which they were added."""
    while _suppliers:
        _suppliers.pop(0)()
    return _formats
