"""Kinds of sensor, a file each, behind one protocol (``scalar.sensors.protocol``); nothing else in the package knows a kind by name."""

from scalar.sensors.fixed_target import FixedTarget
from scalar.sensors.point_by_point import PointByPoint
from scalar.sensors.protocol import Guess, Measurement, Pieces, Rows, Scans, Target, as_scans, stated_sigma
from scalar.sensors.registry import kind_named, kind_of, measure, register, unregister

__all__ = [
    "FixedTarget",
    "Guess",
    "Measurement",
    "Pieces",
    "PointByPoint",
    "Rows",
    "Scans",
    "Target",
    "as_scans",
    "kind_named",
    "kind_of",
    "measure",
    "register",
    "stated_sigma",
    "unregister",
]
