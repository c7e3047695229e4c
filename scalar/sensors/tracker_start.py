"""Initial estimate of a tracker's frames and of the targets on the flange, for given poses of the first target: two closed forms in turn.

The frames that fit best to targets at known places are Kabsch's (1976); the targets that fit best to known frames are the means of their
measured places in the sensor's frame. Starting with all targets at the sensor, the two are computed in turn; each round lowers the squared
distances.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from scalar.geometry.se3 import Array, nearest_rotation
from scalar.sensors.tracker_frames import TargetOffsets, TrackerFrames

_ALTERNATIONS = 60  # rounds; each is expected to halve the error at least


@dataclass(frozen=True, eq=False)
class Tracked:
    """The measurements of a tracker, as in ``scalar.sensors.tracker.Tracker``.

    Attributes:
        names: Names of the K targets.
        seen: ``(N, K)`` bool, which targets each pose shows.
        positions: ``(N, K, 3)`` [m].
        rotations: ``(N, K, 3, 3)``; None if positions alone were measured.
        session: ``(N,)``, index of the session of each pose.
    """

    names: tuple[str, ...]
    seen: Array
    positions: Array
    rotations: Array | None
    session: Array

    def fitted(self, T_base_sensor: Array, target: TrackerFrames) -> TrackerFrames:
        """Return the frames and targets that fit best to the sensor's poses ``(N, 4, 4)``."""
        frames = self._frames(T_base_sensor, target)
        if len(self.names) == 1:
            return frames
        for _ in range(_ALTERNATIONS):
            frames = self._frames(
                T_base_sensor, replace(frames, targets=self._targets(T_base_sensor, frames))
            )
        return frames

    def _frames(self, T_base_sensor: Array, target: TrackerFrames) -> TrackerFrames:
        """Return the frames that fit best to the targets at their places of ``target``."""
        rotations, coordinates = target.rotations, target.coordinates.copy()
        places = self._places(T_base_sensor, target.targets)
        for s in range(len(rotations)):
            mine = self.seen & (self.session == s)[:, None] & np.isfinite(places).all(axis=2)
            o, y = places[mine], self.positions[mine]
            rotations[s] = nearest_rotation((y - y.mean(0)).T @ (o - o.mean(0)))
            coordinates[s] = np.r_[y.mean(0) - rotations[s] @ o.mean(0), 0.0, 0.0, 0.0]
        return TrackerFrames(target.names, rotations, coordinates, target.targets)

    def _targets(self, T_base_sensor: Array, target: TrackerFrames) -> TargetOffsets:
        """Return the targets that fit best to the frames: the mean measured place of each in the sensor's frame."""
        targets = target.targets
        R_tracker_sensor = target.rotations[self.session] @ T_base_sensor[:, :3, :3]
        at = np.einsum("nij,nj->ni", target.rotations[self.session], T_base_sensor[:, :3, 3])
        at = at + target.coordinates[self.session, :3]
        coordinates, references = targets.coordinates.copy(), targets.rotations
        for k, name in enumerate(self.names):
            i, seen = targets.index(name), self.seen[:, k]
            if i is None or i == 0 or not seen.any():
                continue
            back = np.swapaxes(R_tracker_sensor[seen], 1, 2)
            coordinates[i] = 0.0
            coordinates[i, :3] = np.mean(
                (back @ (self.positions[seen, k] - at[seen])[:, :, None])[..., 0], axis=0
            )
            if self.rotations is not None:
                references[i] = nearest_rotation(np.mean(back @ self.rotations[seen, k], axis=0))
        return replace(targets, references=references, coordinates=coordinates)

    def _places(self, T_base_sensor: Array, targets: TargetOffsets) -> Array:
        """Return where the targets are in the base frame ``(N, K, 3)`` [m]; NaN for a target that the model does not have."""
        places = np.full(self.positions.shape, np.nan)
        for k, name in enumerate(self.names):
            i = targets.index(name)
            if i == 0:
                places[:, k] = T_base_sensor[:, :3, 3]
            elif i is not None:
                offset = targets.coordinates[i, :3]
                places[:, k] = T_base_sensor[:, :3, :3] @ offset + T_base_sensor[:, :3, 3]
        return places
