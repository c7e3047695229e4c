"""The target of a tracker: its frame in each session, and the places on the flange of further targets besides the first.

The sensor of the model is the first target. The others are rigid with it: ``T_base_target = T_base_sensor T_sensor_target``, with an unknown offset,
and an unknown rotation as well where whole poses were measured. Their coordinates are common to all sessions.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from scalar.geometry.robot import fixed_transform_mapping
from scalar.geometry.se3 import (
    Array,
    exp_so3,
    left_jacobian_so3,
    log_so3,
    transform,
    transform_from_rotation_vector,
)

_PLACE, _TURN = ("x", "y", "z"), ("rx", "ry", "rz")


@dataclass(frozen=True, eq=False)
class TargetOffsets:
    """The places of K targets in the frame of the sensor, which is the first of them: ``p_sensor = exp(r) R_reference p_target + t``.

    Attributes:
        names: Names of the K targets, the first included; one empty name if the data name no targets.
        oriented: Whether orientations were measured, so that each target has a rotation as well.
        references: ``(K, 3, 3)``, reference rotations.
        coordinates: ``(K, 6)``, t [m] and r [rad]; zero for the first.
    """

    names: tuple[str, ...] = ("",)
    oriented: bool = False
    references: Array = field(default_factory=lambda: np.eye(3)[None])
    coordinates: Array = field(default_factory=lambda: np.zeros((1, 6)))

    @classmethod
    def at_sensor(cls, names: Sequence[str], oriented: bool) -> TargetOffsets:
        """Return targets that all coincide with the sensor."""
        K = len(names)
        return cls(tuple(names), oriented, np.tile(np.eye(3), (K, 1, 1)), np.zeros((K, 6)))

    @property
    def rotations(self) -> Array:
        """Return the rotations ``(K, 3, 3)`` from a target's frame to the sensor's."""
        return exp_so3(self.coordinates[:, 3:]) @ self.references

    @property
    def transforms(self) -> Array:
        """Return ``T_sensor_target`` ``(K, 4, 4)``."""
        return transform(self.rotations, self.coordinates[:, :3])

    @property
    def per_target(self) -> int:
        """Return the number of coordinates of each target but the first."""
        return 6 if self.oriented else 3

    def free(self) -> Array:
        """Return the free coordinates ``((K - 1) per_target,)``."""
        return self.coordinates[1:, : self.per_target].ravel()

    def with_free(self, vector: Array) -> TargetOffsets:
        """Return the targets at other free coordinates."""
        coordinates = self.coordinates.copy()
        coordinates[1:, : self.per_target] = np.reshape(vector, (-1, self.per_target))
        return replace(self, coordinates=coordinates)

    def rebased(self) -> TargetOffsets:
        """Return the same targets with their current rotations as references."""
        return self._about(self.rotations, np.zeros((len(self.names), 3)))

    def absolute(self) -> TargetOffsets:
        """Return the same targets with absolute rotation vectors."""
        return self._about(np.tile(np.eye(3), (len(self.names), 1, 1)), log_so3(self.rotations))

    def _about(self, references: Array, turns: Array) -> TargetOffsets:
        coordinates = np.concatenate([self.coordinates[:, :3], turns], axis=1)
        return replace(self, references=references, coordinates=coordinates)

    def index(self, name: str) -> int | None:
        """Return the index of the target with a name, or None."""
        return self.names.index(name) if name in self.names else None

    def derivatives(self, name: str) -> Array:
        """Return the derivatives of a target's pose by the free coordinates, in the axes of the sensor's frame.

        Returns:
            ``(6, (K - 1) per_target)``: the shift of the target's origin [m], then its rotation about that origin [rad].
        """
        k, width = self.names.index(name), self.per_target
        found = np.zeros((6, (len(self.names) - 1) * width))
        if k > 0:
            at = (k - 1) * width
            found[:3, at : at + 3] = np.eye(3)
            if self.oriented:
                found[3:, at + 3 : at + 6] = left_jacobian_so3(self.coordinates[k, 3:])
        return found


@dataclass(frozen=True, eq=False)
class TrackerFrames:
    """The tracker's frames ``T_tracker_base`` of S sessions, ``p_tracker = exp(r) R_reference p_base + t``, and the targets on the flange.

    Attributes:
        names: Names of the S frames.
        reference_rotations: ``(S, 3, 3)``.
        coordinates: ``(S, 6)``, t [m] and r [rad].
        targets: The targets on the flange.
    """

    names: tuple[str, ...]
    reference_rotations: Array
    coordinates: Array
    targets: TargetOffsets = field(default_factory=TargetOffsets)

    @property
    def rotations(self) -> Array:
        """Return the rotations ``(S, 3, 3)``."""
        return exp_so3(self.coordinates[:, 3:]) @ self.reference_rotations

    @property
    def transforms(self) -> Array:
        """Return ``T_tracker_base`` ``(S, 4, 4)``."""
        return transform(self.rotations, self.coordinates[:, :3])

    @property
    def common(self) -> int:
        """Return the number of coordinates that all sessions share: those of the targets, which are the last."""
        return len(self.targets.free())

    @property
    def parameter_names(self) -> list[str]:
        """Return ``<name>_x .. <name>_rz`` of every frame, then ``target_<name>_x ..`` of every target but the first."""
        frames = [f"{name}_{p}" for name in self.names for p in (*_PLACE, *_TURN)]
        per_target = (*_PLACE, *_TURN)[: self.targets.per_target]
        return [*frames, *(f"target_{name}_{p}" for name in self.targets.names[1:] for p in per_target)]

    @property
    def parameter_units(self) -> list[str]:
        """Return the units, in the order of the names."""
        one = ["m", "m", "m", "rad", "rad", "rad"]
        return one * len(self.names) + one[: self.targets.per_target] * (len(self.targets.names) - 1)

    @property
    def vector(self) -> Array:
        """Return the coordinates ``(6 S + common,)``."""
        return np.concatenate([self.coordinates.ravel(), self.targets.free()])

    def with_vector(self, vector: Array) -> TrackerFrames:
        """Return the frames and targets at coordinates ``(6 S + common,)`` about the same references."""
        vector = np.array(vector, dtype=float)
        end = 6 * len(self.names)
        coordinates, targets = vector[:end].reshape(-1, 6), self.targets
        return replace(self, coordinates=coordinates, targets=targets.with_free(vector[end:]))

    def rebased(self) -> TrackerFrames:
        """Return the same frames and targets with their current rotations as references."""
        coordinates = self.coordinates.copy()
        coordinates[:, 3:] = 0.0
        return TrackerFrames(self.names, self.rotations, coordinates, self.targets.rebased())

    def expressed_about(self, guess: TrackerFrames) -> TrackerFrames:
        """Return the same frames with absolute rotation vectors; ``guess`` is not used."""
        coordinates = np.concatenate([self.coordinates[:, :3], log_so3(self.rotations)], axis=1)
        references = np.tile(np.eye(3), (len(self.names), 1, 1))
        return TrackerFrames(self.names, references, coordinates, self.targets.absolute())

    def to_mapping(self) -> dict[str, Any]:
        """Return the entries of ``calibration.json``: ``tracker_frames``, and ``targets`` if they are named or have orientations."""
        frames = zip(self.names, self.transforms, strict=True)
        mapping: dict[str, Any] = {
            "tracker_frames": [
                {"name": name, "T_tracker_base": fixed_transform_mapping(T)} for name, T in frames
            ]
        }
        if self.targets.names != ("",) or self.targets.oriented:
            on_flange = zip(self.targets.names, self.targets.transforms, strict=True)
            mapping["targets"] = [
                {
                    "name": name,
                    "oriented": self.targets.oriented,
                    "T_sensor_target": fixed_transform_mapping(T),
                }
                for name, T in on_flange
            ]
        return mapping

    @classmethod
    def from_mapping(cls, mapping: Mapping[str, Any]) -> TrackerFrames:
        """Return the frames of ``to_mapping``."""
        frames, targets = mapping["tracker_frames"], mapping.get("targets", [])
        names = tuple(frame["name"] for frame in frames)
        references = np.tile(np.eye(3), (len(names), 1, 1))
        coordinates = _coordinates([frame["T_tracker_base"] for frame in frames])
        if not targets:
            return cls(names, references, coordinates)
        offsets = TargetOffsets.at_sensor([t["name"] for t in targets], bool(targets[0]["oriented"]))
        offsets = replace(offsets, coordinates=_coordinates([t["T_sensor_target"] for t in targets]))
        return cls(names, references, coordinates, offsets)


def _coordinates(transforms: Sequence[Mapping[str, Any]]) -> Array:
    """Return translations [m] and rotation vectors [rad], ``(n, 6)``, of the entries of a file."""
    found = [
        np.r_[T[:3, 3], log_so3(T[:3, :3])]
        for T in (transform_from_rotation_vector(t["translation"], t["rotation_vector"]) for t in transforms)
    ]
    return np.array(found).reshape(-1, 6)
