"""A laser tracker: it measures targets on the flange in its own frame, whose pose relative to the base is unknown.

``f = R o + t - y`` for a target at o in the base frame, measured at y. What the estimator calls the sensor's *target* is the unknown frame
``T_tracker_base = (R, t)``, one for each session. A pose may show some or all of several targets on the flange, each by its position or by its whole
pose, and every measurement may have a noise of its own. The rows of a pose are those of the positions of all targets, then those of their rotations,
``log(R R_base_target R_measured^T)``; the rows of a target that was not measured at the pose are zero.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from scalar.data.sensor_formats import MeasuredTable, SensorFormat
from scalar.geometry.se3 import Array, exp_so3
from scalar.sensors.pose_noise import NoiseComponent
from scalar.sensors.position_errors import with_position_errors
from scalar.sensors.protocol import Measurement
from scalar.sensors.rows import Rows, UsualNoise
from scalar.sensors.target import Target
from scalar.sensors.tracker_frames import TargetOffsets, TrackerFrames
from scalar.sensors.tracker_noise import TrackerNoise, placed
from scalar.sensors.tracker_rows import tracked_rows
from scalar.sensors.tracker_start import Tracked

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset

_TURN = ("rx", "ry", "rz")


@dataclass(frozen=True, eq=False)
class Tracker(Measurement):
    """The measurements of a tracker: K targets in N poses.

    Attributes:
        names: Names of the K targets.
        positions: ``(N, K, 3)`` [m], in the tracker's frame; zero for a target that was not measured.
        rotations: ``(N, K, 3, 3)``, from a target's frame to the tracker's; None if positions alone were measured.
        noise_of: Standard deviations of all measurements.
        target_index: ``(N,)``, the session of each pose.
    """

    names: tuple[str, ...]
    positions: Array
    rotations: Array | None
    noise_of: TrackerNoise
    target_index: Array
    observes_orientation: bool = False
    measures_positions = True

    format = SensorFormat(
        "tracker",
        on_planes=False,
        needs_nominal_pose=True,
        table=MeasuredTable(
            "points",
            {"x": "m", "y": "m", "z": "m"},
            False,
            "row",
            largest=200.0,
            optional={"noise": "m", **dict.fromkeys(_TURN, "rad"), "rotation_noise": "rad"},
            together=(_TURN,),
            noises=("noise", "rotation_noise"),
            item="target",
        ),
        references=MeasuredTable(
            "nests",
            {"x": "m", "y": "m", "z": "m"},
            True,
            "row",
            largest=200.0,
            optional={"noise": "m"},
            noises=("noise",),
            item="nest",
        ),
        options={
            "rotation_noise": {
                "type": "number",
                "exclusiveMinimum": 0,
                "description": "one standard deviation of a measured orientation about each axis, greater than 0 [rad]",
            }
        },
    )
    words = target_words = "tracker"
    measured = "tracked"
    on_flange = "target", "rx,ry,rz have other axes of the target, or the last joint has another zero"
    residual_words = "distance to the tracked point"
    usual_noise = UsualNoise("a laser tracker scatters by 0.01 to 0.05 mm an axis, a camera by 0.1 mm", 2e-4)

    @classmethod
    def of(cls, dataset: Dataset, extra_basis: Sequence[str] = ()) -> Tracker:
        """Return the measurements of the targets that occur in a dataset."""
        session = dataset.session if dataset.session is not None else np.zeros(dataset.n_poses, dtype=int)
        pose = dataset.pose_of_point
        columns = dataset.point_columns
        named = columns.get("target")
        which = np.zeros(len(pose), dtype=int) if named is None else named.astype(int)
        present, item = np.unique(which, return_inverse=True)
        names = tuple(dataset.targets[i] for i in present) if dataset.targets else ("",)
        shape = (dataset.n_poses, len(names))
        seen = np.zeros(shape, dtype=bool)
        seen[pose, item] = True
        positions = np.zeros((*shape, 3))
        positions[pose, item] = dataset.points
        rotations = None
        if _TURN[0] in columns:
            rotations = np.tile(np.eye(3), (*shape, 1, 1))
            rotations[pose, item] = exp_so3(np.column_stack([columns[name] for name in _TURN]))
        unknowns = 4 * dataset.robot.n_joints + 6 * (int(session.max()) + 1) + 6 * len(names)
        of_positions = dataset.sensor.noise, placed(columns.get("noise"), pose, item, shape)
        of_turns = (
            dataset.sensor.options.get("rotation_noise"),
            placed(columns.get("rotation_noise"), pose, item, shape),
        )
        noise = TrackerNoise.of(seen, of_positions, None if rotations is None else of_turns, unknowns)
        return cls(names, positions, rotations, noise, np.asarray(session), rotations is not None)

    @property
    def seen(self) -> Array:
        """Return which targets were measured at each pose, ``(N, K)`` bool."""
        return self.noise_of.seen

    @property
    def sigma(self) -> float:  # type: ignore[override]
        """Return the root mean square standard deviation of a coordinate [m]."""
        return self.noise_of.typical

    @property
    def sigma_stated(self) -> bool:  # type: ignore[override]
        """Return whether the noise of positions is stated, for all of them or for each."""
        return self.noise_of.position_stated

    @property
    def sigma_known(self) -> bool:
        """Return whether the noise of positions is stated, or shown by the targets of each pose."""
        return self.noise_of.position_stated or self.noise_of.measured

    @property
    def rows_per_pose(self) -> int:  # type: ignore[override]
        """Return the number of rows: three for each target, and three more if rotations were measured."""
        return len(self.names) * (3 if self.rotations is None else 6)

    @property
    def equations(self) -> Array:
        """Return how many rows of each pose are measured ``(N,)`` int."""
        return self.seen.sum(axis=1) * (3 if self.rotations is None else 6)

    def initial_target(self, dataset: Dataset) -> TrackerFrames:
        """Return frames at the identity and targets at the sensor, since a dataset does not state their places."""
        n = int(self.target_index.max()) + 1
        names = ("tracker",) if n == 1 else tuple(f"tracker@{s + 1}" for s in range(n))
        targets = TargetOffsets.at_sensor(self.names, self.rotations is not None)
        return TrackerFrames(names, np.tile(np.eye(3), (n, 1, 1)), np.zeros((n, 6)), targets)

    def fitted_target(self, T_base_sensor: Array, target: Target) -> TrackerFrames:
        """Return the least-squares frames and places of the targets for given poses of the sensor."""
        assert isinstance(target, TrackerFrames)
        tracked = Tracked(self.names, self.seen, self.positions, self.rotations, self.target_index)
        return tracked.fitted(T_base_sensor, target)

    def _linear(
        self, T_base_sensor: Array, target: Target, index: Array, *, perfect: bool = False
    ) -> tuple[Array, Array, Array]:
        """Return residuals [m, rad] and derivatives as ``tracked_rows`` does; of measurements without error if ``perfect``."""
        assert isinstance(target, TrackerFrames)
        measured = (None, None) if perfect else (self.positions, self.rotations)
        return tracked_rows(
            T_base_sensor, target, index, self.names, *measured, oriented=self.rotations is not None
        )

    def rows(self, T_base_sensor: Array, target: Target, point_effects: Sequence[Any] = ()) -> Rows:
        """Return ``(R o + t - y) / sigma``, and ``log(R R_base_target R_measured') / sigma_rotation``, with their derivatives."""
        residual, wrench, by_target = self._linear(T_base_sensor, target, self.target_index)
        residual, extra = self._with_errors(residual, T_base_sensor, target, point_effects)
        scale = self.noise_of.weights()[:, :, None]
        return Rows(residual * scale[:, :, 0], wrench * scale, by_target * scale, extra * scale)

    def _with_errors(
        self, residual: Array, T_base_sensor: Array, target: Target, effects: Sequence[Any]
    ) -> tuple[Array, Array]:
        """Return what ``with_position_errors`` does, of the targets that a model has."""
        seen = self.seen & np.array([target.targets.index(name) is not None for name in self.names])  # type: ignore[attr-defined]
        y = np.where(seen[:, :, None], self.positions, np.nan)
        return with_position_errors(residual, effects, T_base_sensor, target, self.target_index, y)

    def distances(
        self, T_base_sensor: Array, target: Target, point_effects: Sequence[Any] = ()
    ) -> tuple[Array, Array]:
        """Return for each pose the sum of squared distances between model and measurement ``(N,)`` [m^2], and the number of targets in it ``(N,)``.

        Orientations are left out, and the number is at least 1.
        """
        assert isinstance(target, TrackerFrames)
        residual = self._linear(T_base_sensor, target, self.target_index)[0]
        residual = self._with_errors(residual, T_base_sensor, target, point_effects)[0]
        squares = residual[:, : 3 * len(self.names)].reshape(*self.seen.shape, 3) ** 2 * self.seen[:, :, None]
        known = self.seen & np.array([target.targets.index(name) is not None for name in self.names])
        return np.sum(squares, axis=(1, 2)), np.maximum(known.sum(axis=1), 1)

    def perfect_rows(self, T_base_sensor: Array, target: Target, index: Array) -> tuple[Array, Array, Array]:
        """Return the derivatives of measurements of all targets: every pose can be measured."""
        _, wrench, by_target = self._linear(T_base_sensor, target, index, perfect=True)
        return wrench, by_target, np.ones(len(wrench), dtype=bool)

    # Weights and noise

    def reweighted(self, T_base_sensor: Array, target: Target) -> Tracker:
        """Return the same measurement with a noise that is not stated, or stated too large, estimated from the residuals of the model."""
        if self.noise_of.fixed:
            return self
        residual, wrench, _ = self._linear(T_base_sensor, target, self.target_index)
        noise = self.noise_of.estimated(residual, wrench)
        return self if noise is self.noise_of else replace(self, noise_of=noise)

    def counting(self, coefficients: int) -> Tracker:
        """Return the same measurement, which counts coefficients of effects among the parameters when it estimates its noise."""
        return replace(self, noise_of=replace(self.noise_of, unknowns=self.noise_of.unknowns + coefficients))

    def weighted_like(self, other: Measurement) -> Tracker:
        """Return the same measurement with the noise of another measurement of the same poses; it is not estimated again."""
        assert isinstance(other, Tracker)
        return replace(self, noise_of=replace(other.noise_of, fixed=True))

    @property
    def estimated_noise(self) -> tuple[NoiseComponent, ...]:
        """Return the noise of positions and of orientations where it is estimated."""
        return self.noise_of.components()

    @property
    def ratio_to_stated(self) -> float | None:
        """Return the noise of positions over the stated one; None if none was stated."""
        return self.noise_of.ratio_to_stated

    def in_metres(self) -> tuple[Tracker, float]:
        """Return the positions alone with equal weights, and the factor that converts their rows to metres."""
        sigma = self.sigma
        noise = replace(self.noise_of, position=np.full(self.seen.shape, sigma), rotation=None)
        return replace(self, rotations=None, noise_of=noise), sigma

    def noise_floor(self, T_base_sensor: Array, target: Target) -> float:
        """Return the root mean square distance [m] of a target that noise alone causes."""
        return self.sigma * float(np.sqrt(3))

    def common_error(self, T_base_sensor: Array, target: Target) -> Array:
        """Return the derivatives of the rows by a common shift of all targets of a pose, ``(N, m, 3)`` [1/m]."""
        N, K = self.seen.shape
        found = np.zeros((N, self.rows_per_pose, 3))
        found[:, : 3 * K] = np.tile(np.eye(3), (K, 1)) * self.noise_of.weights()[:, : 3 * K, None]
        return found

    # How the residual is shown

    def shift(self, predicted: Array, residual: Array) -> tuple[Array, Array, Array]:
        """Return each pose's predicted shift, the residual's shift along it and its standard error, ``(N,)`` [m] each, from positions alone."""
        n, sigma = 3 * len(self.names), self.noise_of.of_poses
        size = np.linalg.norm(predicted[:, :n], axis=1)
        along = predicted[:, :n] / np.maximum(size, 1e-300)[:, None]
        return size * sigma, np.sum(along * residual[:, :n], axis=1) * sigma, sigma

    def shown_residual(self, residual: Array) -> Array:
        """Return the size of each pose's residual shift ``(N,)`` [m], from positions alone."""
        return np.linalg.norm(residual[:, : 3 * len(self.names)], axis=1) * self.noise_of.of_poses

    @classmethod
    def target_motion(cls, dataset: Dataset) -> Array | None:
        """Return the motion of the base relative to the tracker that nests show, ``(N, 6)`` [rad, m] in the base frame, or None without nests.

        The tracker's place is taken from a fit with the nominal arm, whose errors change this small motion by a percent or less.
        """
        nests, T = dataset.references, dataset.sensor.T_flange_sensor
        if nests is None or T is None or not len(nests.pose):
            return None
        from scalar.sensors.observed_motion import motion_of_base  # SciPy's sparse matrices load slowly

        measured = cls.of(dataset)
        frames = measured.fitted_target(dataset.robot.flange(dataset.q) @ T, measured.initial_target(dataset))
        return motion_of_base(nests, measured.target_index, frames.transforms)

    @classmethod
    def shows_turns(cls, dataset: Dataset) -> bool:
        """Return whether turns are measured: by orientations, or by several targets, since a turn about one of them moves the others."""
        return _TURN[0] in dataset.point_columns or len(dataset.targets) > 1

    # How the target is saved

    @classmethod
    def target_to_mapping(cls, target: Target, std: Mapping[str, float]) -> dict[str, Any]:
        """Return the frames and targets; their standard errors stand with the parameters."""
        assert isinstance(target, TrackerFrames)
        return target.to_mapping()

    @classmethod
    def target_from_mapping(cls, mapping: Mapping[str, Any]) -> TrackerFrames:
        """Return the frames and targets of ``target_to_mapping``."""
        return TrackerFrames.from_mapping(mapping)
