"""Kinds of sensor: one file each; the only place that lists them is ``KINDS``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from scalar.sensors.line_laser import LineLaser
from scalar.sensors.measurement import Measurement, Rows, Target
from scalar.sensors.probe import Probe
from scalar.sensors.tracker import Tracker

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset

KINDS: dict[str, type[LineLaser | Probe | Tracker]] = {
    "line-laser": LineLaser,
    "probe": Probe,
    "tracker": Tracker,
}

__all__ = ["KINDS", "Measurement", "Rows", "Target", "measure"]


def measure(dataset: Dataset, extra_basis: Sequence[str] = ()) -> LineLaser | Probe | Tracker:
    """Return the dataset as its own kind of sensor sees it.

    Args:
        dataset: What was measured.
        extra_basis: Functions of a point that effects on points need kept (``scalar.sensors.line_laser.point_basis``).
    """
    return KINDS[dataset.sensor.kind].of(dataset, extra_basis)
