"""What a dataset declares besides its measurements: the nominal robot and sensor, and the initial guesses of the planes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from scalar.data.formats import DATASET_FORMAT, FEW_PLANES, IMPORTED
from scalar.data.sensor_formats import sensor_formats
from scalar.geometry.robot import Robot, fixed_transform_mapping
from scalar.geometry.se3 import transform_from_rotation_vector


@dataclass(frozen=True, eq=False)
class PlaneGuess:
    """The user's guess of a plane, ``normal . p = distance`` in the base frame.

    Attributes:
        name: name of the plane, as in poses.csv.
        normal: ``(3,)``, of length one; ``unit_plane`` scales a normal of another length together with the distance.
        distance: distance from the base's origin along the normal [m].
        distance_std: standard deviation of the distance [m] of a plane that is a known reference; else None.
        normal_std: standard deviation of the normal's direction [rad] of such a plane; else None.
        centre: ``(3,)`` [m], in the base frame: the middle of the target plane where its end is stated; else None. Only planning uses it.
        radius: of the circle about ``centre`` that the target plane covers [m]; else None.
    """

    name: str
    normal: np.ndarray
    distance: float
    distance_std: float | None = None
    normal_std: float | None = None
    centre: np.ndarray | None = None
    radius: float | None = None

    def __post_init__(self) -> None:
        """Take lists of numbers as arrays."""
        for name in ("normal", "centre"):
            value = getattr(self, name)
            object.__setattr__(self, name, None if value is None else np.asarray(value, dtype=float))

    @classmethod
    def from_mapping(cls, mapping: Mapping[str, Any]) -> PlaneGuess:
        """Return the plane of an entry of ``planes`` in dataset.yaml; its normal may have any length."""
        normal = np.array(mapping["normal"], dtype=float)
        length = float(np.linalg.norm(normal))
        known, extent = mapping.get("known", {}), mapping.get("extent", {})
        distance_std = optional_float(known.get("distance_std"))
        return cls(
            name=mapping["name"],
            normal=normal / length,
            distance=float(mapping["distance"]) / length,
            distance_std=None if distance_std is None else distance_std / length,
            normal_std=optional_float(known.get("normal_std")),
            centre=extent.get("centre"),
            radius=optional_float(extent.get("radius")),
        )

    def to_mapping(self) -> dict[str, Any]:
        """Return the plane as dataset.yaml writes it."""
        mapping: dict[str, Any] = {
            "name": self.name,
            "normal": [float(x) for x in self.normal],
            "distance": float(self.distance),
        }
        if self.distance_std is not None or self.normal_std is not None:
            mapping["known"] = {"distance_std": self.distance_std, "normal_std": self.normal_std}
        if self.centre is not None or self.radius is not None:
            centre = None if self.centre is None else [float(x) for x in self.centre]
            mapping["extent"] = {"centre": centre, "radius": self.radius}
        return mapping


@dataclass(frozen=True, eq=False)
class Sensor:
    """The nominal sensor on the flange.

    Attributes:
        kind: The name of one of the kinds in ``scalar.sensors``.
        T_flange_sensor: ``(4, 4)``, initial guess of the sensor's pose on the flange; None if it is not given.
        noise: one standard deviation along the error axis [m]; None if it is to be estimated.
        error_axis: ``ray`` (from the sensor's origin through the point) or ``z``.
        options: further settings that the kind defines, by their keys in dataset.yaml.
    """

    kind: str
    T_flange_sensor: np.ndarray | None = None
    noise: float | None = None
    error_axis: str = "ray"
    options: Mapping[str, Any] = field(default_factory=dict[str, Any])

    def to_mapping(self) -> dict[str, Any]:
        """Return the sensor as dataset.yaml writes it."""
        mapping: dict[str, Any] = {"kind": self.kind}
        if self.T_flange_sensor is not None:
            mapping["nominal_pose"] = fixed_transform_mapping(np.asarray(self.T_flange_sensor, dtype=float))
        if self.noise is not None:
            mapping["noise"] = float(self.noise)
        return mapping | {"error_axis": self.error_axis} | dict(self.options)


def description(
    name: str,
    source: str,
    robot: Robot,
    sensor: Sensor,
    planes: Sequence[PlaneGuess],
    imported: Mapping[str, str] | None = None,
    few_planes: bool = False,
) -> dict[str, Any]:
    """Return the content of dataset.yaml; what is empty or false of source, planes, ``imported`` and ``few_planes`` is left out.

    Args:
        name: Name of the dataset.
        source: Where the data come from, free text.
        robot: The nominal arm.
        sensor: Its kind, and what is known of its noise and its pose on the flange.
        planes: The initial guesses of the planes, if there are any.
        imported: What an import knew, as ``Dataset.imported`` has it.
        few_planes: As ``Dataset.few_planes`` has it.
    """
    mapping: dict[str, Any] = {"format": DATASET_FORMAT, "name": name}
    if source:
        mapping["source"] = source
    if imported:
        mapping[IMPORTED] = dict(imported)
    mapping |= {"robot": robot.to_mapping(), "sensor": sensor.to_mapping()}
    if few_planes:
        mapping[FEW_PLANES] = True
    if planes:
        mapping["planes"] = [plane.to_mapping() for plane in planes]
    return mapping


def declared_parts(mapping: Mapping[str, Any]) -> tuple[Robot, Sensor, tuple[PlaneGuess, ...]]:
    """Return the robot, the sensor and the planes that a dataset.yaml without fault declares; no planes if the sensor's kind measures none.

    Args:
        mapping: the content of dataset.yaml.
    """
    sensor = mapping["sensor"]
    pose = sensor.get("nominal_pose")
    T_flange_sensor = None
    if pose is not None:
        T_flange_sensor = transform_from_rotation_vector(pose["translation"], pose["rotation_vector"])
    format = sensor_formats()[sensor["kind"]]
    return (
        Robot.from_mapping(mapping["robot"]),
        Sensor(
            format.kind,
            T_flange_sensor,
            optional_float(sensor.get("noise")),
            sensor.get("error_axis", "ray"),
            {key: sensor[key] for key in format.options if key in sensor},
        ),
        tuple(PlaneGuess.from_mapping(plane) for plane in mapping["planes"]) if format.on_planes else (),
    )


def unit_plane(plane: PlaneGuess) -> PlaneGuess:
    """Return the plane with a normal of length one; a plane whose normal has that length already is returned as it is."""
    if abs(np.linalg.norm(plane.normal) - 1.0) < 1e-12:
        return plane
    return PlaneGuess.from_mapping(plane.to_mapping())


def optional_float(value: Any) -> float | None:
    """Return a number of a file as float; None remains None."""
    return None if value is None else float(value)
