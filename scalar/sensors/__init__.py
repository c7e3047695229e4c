"""Kinds of sensor, one file for each, behind one protocol (``scalar.sensors.protocol``); nothing else in the package knows a kind by name."""

from scalar.sensors.fixed_target import FixedTarget
from scalar.sensors.point_by_point import PointByPoint
from scalar.sensors.pose_noise import NoiseComponent, PoseNoise
from scalar.sensors.protocol import Measurement
from scalar.sensors.registry import kind_named, kind_of, measure, register, unregister
from scalar.sensors.rows import Pieces, Rows, stated_sigma
from scalar.sensors.scans import Scans, as_scans
from scalar.sensors.target import Guess, Target, by_coordinates, on_flange

__all__ = [
    "FixedTarget",
    "Guess",
    "Measurement",
    "NoiseComponent",
    "Pieces",
    "PointByPoint",
    "PoseNoise",
    "Rows",
    "Scans",
    "Target",
    "as_scans",
    "by_coordinates",
    "kind_named",
    "kind_of",
    "measure",
    "on_flange",
    "register",
    "stated_sigma",
    "unregister",
]
