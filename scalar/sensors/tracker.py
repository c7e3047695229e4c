"""A laser tracker: the sensor's origin measured in the tracker's own frame, ``f = R o + t - y``, with an unknown rigid frame.

Three signed components a pose instead of one or two. ``T_tracker_base = (R, t)`` stands in the place of the planes, one for each session.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from scalar.geometry.se3 import Array, cross, exp_so3, left_jacobian_so3, log_so3, transform
from scalar.sensors.measurement import Measurement, Rows, Target, stated_sigma

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
class Tracker(Measurement):
    """The tracked positions ``(N, 3)`` [m] of a dataset."""

    positions: Array
    target_index: Array
    sigma: float
    sigma_stated: bool

    rows_per_pose = 3
    equations_per_pose = 3
    sees_sensor_rotation = False
    has_metric = True

    @classmethod
    def of(cls, dataset: Dataset, extra_basis: Sequence[str] = ()) -> Tracker:
        """Return the positions of a dataset."""
        noise = dataset.sensor.noise
        session = dataset.session if dataset.session is not None else np.zeros(dataset.n_poses, dtype=int)
        sigma = stated_sigma(noise)
        return cls(np.asarray(dataset.points, dtype=float), np.asarray(session), sigma, noise is not None)

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
            o, y = T_base_sensor[mine, :3, 3], self.positions[mine]
            U, _, Vt = np.linalg.svd((y - y.mean(0)).T @ (o - o.mean(0)))
            rotations[s] = U @ np.diag([1.0, 1.0, np.linalg.det(U @ Vt)]) @ Vt
            coordinates[s] = np.r_[y.mean(0) - rotations[s] @ o.mean(0), 0.0, 0.0, 0.0]
        return TrackerFrames(target.names, rotations, coordinates)

    def perfect_rows(self, T_base_sensor: Array, target: Target, index: Array) -> tuple[Array, Array, Array]:
        """Return the rows of any poses: a tracker sees them all."""
        assert isinstance(target, TrackerFrames)
        _, wrench, by_target = tracked(T_base_sensor[:, :3, 3], target, index)
        return wrench, by_target, np.ones(len(wrench), dtype=bool)

    def rows(self, T_base_sensor: Array, target: Target, point_effects: Sequence[Any] = ()) -> Rows:
        """Return ``(R o + t - y) / sigma`` and its derivatives."""
        assert isinstance(target, TrackerFrames)
        predicted, wrench, by_target = tracked(T_base_sensor[:, :3, 3], target, self.target_index)
        residual = predicted - self.positions
        extra = np.zeros((len(residual), 3, 0))
        scale = 1.0 / self.sigma
        return Rows(residual * scale, wrench * scale, by_target * scale, extra)

    def reweighted(self, T_base_sensor: Array, target: Target) -> Tracker:
        """Return the same positions: a tracker's error is taken alike in all directions."""
        return self

    def distances(
        self, T_base_sensor: Array, target: Target, point_effects: Sequence[Any] = ()
    ) -> tuple[Array, Array]:
        """Return per pose the squared distance between model and tracker [m^2] and one."""
        residual = self.rows(T_base_sensor, target, point_effects).residual * self.sigma
        return np.sum(residual**2, axis=1), np.ones(len(residual), dtype=int)


def tracked(o: Array, frames: TrackerFrames, index: Array) -> tuple[Array, Array, Array]:
    """Return points ``o`` ``(N, 3)`` in the tracker's frame [m], their wrenches ``(N, 3, 6)`` and derivatives by the frame ``(N, 3, 6)``."""
    R = frames.rotations[index]
    turned = (R @ o[:, :, None])[:, :, 0]
    wrench = np.concatenate([cross(np.broadcast_to(o[:, None, :], R.shape), R), R], axis=2)
    by_target = np.zeros((len(o), 3, 6))
    by_target[:, :, :3] = np.eye(3)
    left = np.stack([left_jacobian_so3(r) for r in frames.coordinates[:, 3:]])[index]
    # d(exp(r) R0 o) = (J_l dr) x (R o): a column is J_l's column crossed with the turned point.
    columns = cross(np.swapaxes(left, 1, 2), np.broadcast_to(turned[:, None, :], R.shape))
    by_target[:, :, 3:] = np.swapaxes(columns, 1, 2)
    return turned + frames.coordinates[index, :3], wrench, by_target
