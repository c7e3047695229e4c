"""The workcell for which poses are planned: arm, sensor and target as they are declared or calibrated, and what the sensor can see."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd

from scalar.data.dataset import Dataset
from scalar.data.declared import PlaneGuess, Sensor
from scalar.estimation.model import Model
from scalar.estimation.result import Calibration
from scalar.geometry.planes import Planes
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import Array
from scalar.sensors import kind_named, measure
from scalar.units import DEG

_FLAT = 30.0 * DEG  # between the normal of a target plane that lies flat and the vertical, at most
_TEMPERATURE = 20.0  # deg C, assumed for poses that are not measured yet


@dataclass(frozen=True)
class View:
    """What a scanner sees.

    Attributes:
        near, far: Limits of the range along a ray [m].
        fan: Half of the opening angle [rad].
        incidence: Largest angle between a ray and the normal of the plane [rad].
        points: Number of points of a scan.
    """

    near: float = 0.10
    far: float = 0.45
    fan: float = 15.0 * DEG
    incidence: float = 50.0 * DEG
    points: int = 100


@dataclass(frozen=True, eq=False)
class Workcell:
    """The workcell for which poses are planned.

    Attributes:
        model: Arm, sensor, target and effects, at their best known values.
        sensor: The sensor. Its kind and its noise are used; the noise has to be stated.
        planes: The planes of the target, as ``model.target`` has them; empty without planes.
        view: What the sensor sees, if it is a scanner.
        repeatability: Standard deviation, along each axis, with which the arm takes a pose again [m].
    """

    model: Model
    sensor: Sensor
    planes: tuple[PlaneGuess, ...]
    view: View
    repeatability: float

    @classmethod
    def of(
        cls,
        robot: Robot,
        sensor: Sensor,
        planes: tuple[PlaneGuess, ...],
        near: Calibration | None = None,
        view: View | None = None,
        repeatability: float = 0.0,
        *,
        same_campaign: bool = False,
    ) -> Workcell:
        """Return the workcell as it is declared, or near a calibration.

        Args:
            robot: The nominal arm; its limits hold near a calibration too, for they may have been narrowed since.
            sensor: The sensor with its nominal pose and its noise.
            planes: Initial guesses of the planes.
            near: A calibration, which then gives the arm, the sensor's place, the planes of the same names, and the effects.
            view: What a scanner sees; None for the values of ``View``.
            repeatability: Standard deviation, along each axis, with which the arm takes a pose again [m].
            same_campaign: Whether the planned poses are added to those of the calibration. If not, its effects that do not stay with the
                arm are left out; effects that change in time, or that need what is recorded with each pose, are always left out.
        """
        if near is not None:
            sensor = replace(sensor, T_flange_sensor=near.model.T_flange_sensor)
            planes = _calibrated(planes, near)
        names = tuple(plane.name for plane in planes)
        dataset = _dataset(robot, sensor, planes, np.zeros((len(names) or 1, robot.n_joints)), names, {})
        model = Calibration.nominal(dataset).model
        if near is not None:
            arm = near.model
            effects = [e for e in arm.effects if same_campaign or e.stays_with_arm]
            still = tuple(e for e in effects if not (e.is_change_in_time or e.needs_records))
            calibrated, nominal = (
                replace(arm_of, limits=robot.limits) for arm_of in (arm.robot, arm.nominal)
            )
            model = replace(model, robot=calibrated, nominal=nominal, effects=still)
        return cls(model.rebased(), sensor, planes, view or View(), repeatability)

    @property
    def on_planes(self) -> bool:
        """Return whether a pose measures one of the planes."""
        return bool(self.planes)

    @property
    def noise(self) -> float:
        """Return the noise of the sensor [m]."""
        return float(self.sensor.noise or 0.0)

    @property
    def touches_planes(self) -> bool:
        """Return whether the sensor measures a plane by touching it."""
        return kind_named(self.sensor.kind).contact_iterations > 0

    @property
    def equations_per_pose(self) -> int:
        """Return how many independent equations a pose gives."""
        index = np.arange(len(self.planes)) if self.on_planes else np.array([-1])
        q = np.zeros((len(index), self.model.nominal.n_joints))
        return measure(self.dataset(q, index)).equations_per_pose

    def dataset(self, q: Array, plane: Array) -> Dataset:
        """Return poses with what the sensor would measure there without error.

        Columns that effects may need, those in question included, are made up: directions of approach at random, one temperature for all.

        Args:
            q: ``(N, n)`` [rad], joint angles.
            plane: ``(N,)``, index of the plane that each pose measures; -1 without planes.
        """
        sides = np.random.default_rng(0).choice([-1.0, 1.0], q.shape)
        columns = {f"approach{i + 1}": side for i, side in enumerate(sides.T)}
        columns["temperature"] = np.full(len(q), _TEMPERATURE)
        names = [self.planes[k].name for k in plane] if self.on_planes else None
        dataset = _dataset(self.model.nominal, self.sensor, self.planes, q, names, columns)
        T = self.model.robot.flange(q) @ self.model.T_flange_sensor
        kind = kind_named(self.sensor.kind)
        if kind.scans:
            points = scan_points(T, self.normals[plane], self.distances[plane], self.view)[0]
            n = points.shape[1]
            return replace(dataset, points=points.reshape(-1, 2), starts=n * np.arange(len(q) + 1))
        if kind.format.table is None:
            return dataset
        return replace(dataset, points=T[:, :3, 3].copy(), starts=np.arange(len(q) + 1))

    @property
    def normals(self) -> Array:
        """Return the normals of the planes ``(K, 3)``."""
        return np.array([plane.normal for plane in self.planes]).reshape(-1, 3)

    @property
    def distances(self) -> Array:
        """Return the distances of the planes ``(K,)`` [m]."""
        return np.array([plane.distance for plane in self.planes])

    def covered(self, k: int, points: Array) -> Array:
        """Return which points ``(..., 3)`` [m] of plane k, in the base frame, lie within its stated extent; all of them if none is stated."""
        plane = self.planes[k]
        if plane.centre is None or plane.radius is None:
            return np.ones(points.shape[:-1], dtype=bool)
        offset = points - plane.centre
        along = offset - (offset @ plane.normal)[..., None] * plane.normal
        return np.linalg.norm(along, axis=-1) <= plane.radius

    def ends(self, k: int) -> bool:
        """Return whether plane k is known to end, so that the arm may pass beside it.

        Its extent has to be stated. A target plane that lies flat rests on a floor or a table, which goes on.
        """
        plane, gravity = self.planes[k], self.model.nominal.gravity
        if plane.centre is None or plane.radius is None:
            return False
        return abs(float(plane.normal @ gravity)) < np.cos(_FLAT) * float(np.linalg.norm(gravity))

    def solids(self) -> list[dict[str, Any]]:
        """Return the planes as the test for collisions takes them, as dataset.yaml has them: those that do not end have no extent."""
        mappings = [plane.to_mapping() for plane in self.planes]
        return [
            m if self.ends(k) else {key: m[key] for key in m if key != "extent"}
            for k, m in enumerate(mappings)
        ]

    def sensor_frames(self, q: Array) -> Array:
        """Return the sensor's frames ``(N, 4, 4)`` in the base frame, effects left out."""
        return self.model.robot.flange(q) @ self.model.T_flange_sensor


def scan_points(T: Array, normals: Array, distances: Array, view: View) -> tuple[Array, Array, Array]:
    """Return the points of scans ``(N, M, 2)`` [m] in the scanner's XZ plane, and their ranges [m] and cosines of incidence ``(N, M)``.

    The range of a ray that does not meet the plane ahead of the scanner is negative.

    Args:
        T: ``(N, 4, 4)``, the scanner in the base frame.
        normals: ``(N, 3)``, of the plane that each scans.
        distances: ``(N,)`` [m], of the same planes.
        view: What the scanner sees.
    """
    angles = np.linspace(-view.fan, view.fan, view.points)
    rays = np.stack([np.sin(angles), np.cos(angles)], axis=1)
    slant = np.einsum("nk,nkj->nj", normals, T[:, :3, [0, 2]]) @ rays.T
    height = distances - np.sum(normals * T[:, :3, 3], axis=1)
    reach = height[:, None] / np.where(np.abs(slant) > 1e-9, slant, 1e-9)
    return reach[:, :, None] * rays, reach, np.abs(slant)


def _calibrated(planes: tuple[PlaneGuess, ...], near: Calibration) -> tuple[PlaneGuess, ...]:
    """Return the planes, with calibrated normals and distances where the calibration has a plane of the same name."""
    target = near.model.target
    if not isinstance(target, Planes):
        return planes
    found = {n: (v, d) for n, v, d in zip(target.names, target.normals, target.distances, strict=True)}
    return tuple(
        replace(p, normal=found[p.name][0], distance=float(found[p.name][1])) if p.name in found else p
        for p in planes
    )


def _dataset(
    robot: Robot,
    sensor: Sensor,
    planes: tuple[PlaneGuess, ...],
    q: Array,
    names: object,
    columns: dict[str, Array],
) -> Dataset:
    poses = pd.DataFrame(q, columns=[f"q{i + 1}" for i in range(robot.n_joints)])
    poses.insert(0, "pose", np.arange(1, len(q) + 1))
    if planes:
        poses.insert(1, "plane", names)
    for name, values in columns.items():
        poses[name] = values
    table = kind_named(sensor.kind).format.table
    nothing = np.empty((0, 2 if table is None else len(table.units)))
    return Dataset("plan", "", robot, sensor, planes, poses, nothing, np.zeros(len(q) + 1, dtype=np.int64))
