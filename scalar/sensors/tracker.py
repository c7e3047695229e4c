"""A laser tracker: the sensor's origin measured in the tracker's own frame, ``f = R o + t - y``, with an unknown rigid frame.

Three signed components a pose instead of one or two. ``T_tracker_base = (R, t)`` stands in the place of the planes, one for each session.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from scalar.data.sensor_formats import MeasuredTable, SensorFormat
from scalar.geometry.robot import fixed_transform_mapping
from scalar.geometry.se3 import (
    Array,
    cross,
    exp_so3,
    left_jacobian_so3,
    log_so3,
    transform,
    transform_from_rotation_vector,
)
from scalar.sensors.point_by_point import PointByPoint
from scalar.sensors.rows import stated_sigma
from scalar.sensors.target import Target

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset

_PARAMETERS = ("x", "y", "z", "rx", "ry", "rz")


@dataclass(frozen=True, eq=False)
class TrackerFrames:
    """The tracker's frames ``T_tracker_base`` of S sessions: ``p_tracker = exp(r) R_reference p_base + t``.

    Attributes:
        names: S names.
        reference_rotations: ``(S, 3, 3)``.
        coordinates: ``(S, 6)``, t [m] and r [rad].
    """

    names: tuple[str, ...]
    reference_rotations: Array
    coordinates: Array

    @property
    def rotations(self) -> Array:
        """Return the rotations ``(S, 3, 3)``."""
        return exp_so3(self.coordinates[:, 3:]) @ self.reference_rotations

    @property
    def transforms(self) -> Array:
        """Return ``T_tracker_base`` ``(S, 4, 4)``."""
        return transform(self.rotations, self.coordinates[:, :3])

    @property
    def parameter_names(self) -> list[str]:
        """Return ``<name>_x .. <name>_rz`` of every frame."""
        return [f"{name}_{p}" for name in self.names for p in _PARAMETERS]

    @property
    def parameter_units(self) -> list[str]:
        """Return the units, in the order of the names."""
        return ["m", "m", "m", "rad", "rad", "rad"] * len(self.names)

    @property
    def vector(self) -> Array:
        """Return the coordinates ``(6 S,)``."""
        return self.coordinates.ravel()

    def with_vector(self, vector: Array) -> TrackerFrames:
        """Return the frames at coordinates ``(6 S,)`` about the same references."""
        return replace(self, coordinates=np.array(vector, dtype=float).reshape(-1, 6))

    def rebased(self) -> TrackerFrames:
        """Return the same frames, their references moved to where they are."""
        coordinates = self.coordinates.copy()
        coordinates[:, 3:] = 0.0
        return replace(self, reference_rotations=self.rotations, coordinates=coordinates)

    def expressed_about(self, guess: TrackerFrames) -> TrackerFrames:
        """Return the same frames with absolute rotation vectors; ``guess`` says nothing of them."""
        coordinates = np.concatenate([self.coordinates[:, :3], log_so3(self.rotations)], axis=1)
        return TrackerFrames(self.names, np.tile(np.eye(3), (len(self.names), 1, 1)), coordinates)


@dataclass(frozen=True, eq=False)
class Tracker(PointByPoint):
    """The tracked positions ``(N, 3)`` [m] of a dataset."""

    values: Array
    target_index: Array
    sigma: float
    sigma_stated: bool

    format = SensorFormat(
        "tracker",
        on_planes=False,
        needs_nominal_pose=True,
        table=MeasuredTable("points", {"x": "m", "y": "m", "z": "m"}, False, "row", largest=200.0),
    )
    words = "tracker"
    measured = "tracked"
    target_words = "tracker"
    residual_words = "distance to the tracked point"

    @classmethod
    def of(cls, dataset: Dataset, extra_basis: Sequence[str] = ()) -> Tracker:
        """Return the positions of a dataset."""
        noise = dataset.sensor.noise
        session = dataset.session if dataset.session is not None else np.zeros(dataset.n_poses, dtype=int)
        return cls(
            np.asarray(dataset.points, dtype=float),
            np.asarray(session),
            stated_sigma(noise),
            noise is not None,
        )

    def initial_target(self, dataset: Dataset) -> TrackerFrames:
        """Return frames at the identity: nothing is stated of the tracker's place."""
        n = int(self.target_index.max()) + 1
        names = ("tracker",) if n == 1 else tuple(f"tracker@{s + 1}" for s in range(n))
        return TrackerFrames(names, np.tile(np.eye(3), (n, 1, 1)), np.zeros((n, 6)))

    def fitted_target(self, T_base_sensor: Array, target: Target) -> TrackerFrames:
        """Return the rigid frames of least squares (Kabsch), the sensor's poses given."""
        assert isinstance(target, TrackerFrames)
        rotations, coordinates = target.rotations, target.coordinates.copy()
        for s in range(len(rotations)):
            mine = self.target_index == s
            o, y = T_base_sensor[mine, :3, 3], self.values[mine]
            U, _, Vt = np.linalg.svd((y - y.mean(0)).T @ (o - o.mean(0)))
            rotations[s] = U @ np.diag([1.0, 1.0, np.linalg.det(U @ Vt)]) @ Vt
            coordinates[s] = np.r_[y.mean(0) - rotations[s] @ o.mean(0), 0.0, 0.0, 0.0]
        return TrackerFrames(target.names, rotations, coordinates)

    def predicted(self, T_base_sensor: Array, target: Target, index: Array) -> tuple[Array, Array, Array]:
        """Return the sensor's origin in the tracker's frame ``(N, 3)`` [m], its wrench and its derivative by the frame ``(N, 3, 6)``."""
        assert isinstance(target, TrackerFrames)
        o, R = T_base_sensor[:, :3, 3], target.rotations[index]
        turned = (R @ o[:, :, None])[:, :, 0]
        wrench = np.concatenate([cross(np.broadcast_to(o[:, None, :], R.shape), R), R], axis=2)
        by_target = np.zeros((len(o), 3, 6))
        by_target[:, :, :3] = np.eye(3)
        left = np.stack([left_jacobian_so3(r) for r in target.coordinates[:, 3:]])[index]
        # d(exp(r) R0 o) = (J_l dr) x (R o): a column is J_l's column crossed with the turned point.
        columns = cross(np.swapaxes(left, 1, 2), np.broadcast_to(turned[:, None, :], R.shape))
        by_target[:, :, 3:] = np.swapaxes(columns, 1, 2)
        return turned + target.coordinates[index, :3], wrench, by_target

    @classmethod
    def target_to_mapping(cls, target: Target, std: Mapping[str, float]) -> dict[str, Any]:
        """Return the frames; their standard errors stand with the parameters."""
        assert isinstance(target, TrackerFrames)
        frames = zip(target.names, target.transforms, strict=True)
        return {
            "tracker_frames": [
                {"name": name, "T_tracker_base": fixed_transform_mapping(T)} for name, T in frames
            ]
        }

    @classmethod
    def target_from_mapping(cls, mapping: Mapping[str, Any]) -> TrackerFrames:
        """Return the frames of ``target_to_mapping``."""
        frames = mapping["tracker_frames"]
        coordinates = [
            np.r_[T[:3, 3], log_so3(T[:3, :3])]
            for T in (
                transform_from_rotation_vector(t["translation"], t["rotation_vector"])
                for t in (frame["T_tracker_base"] for frame in frames)
            )
        ]
        names = tuple(frame["name"] for frame in frames)
        references = np.tile(np.eye(3), (len(names), 1, 1))
        return TrackerFrames(names, references, np.array(coordinates).reshape(-1, 6))
