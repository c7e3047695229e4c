"""A sound campaign of a random arm of the library: a scanner on three planes, or a tracker, at random poses.

The true arm differs from its table by a millimetre and two milliradians, and nothing else is wrong with it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from scalar.robots import read_arm
from study.common.kinematics import pose_mapping, random_transform, rotate_about, rotation, translation
from study.spoiled_setups.campaign import (
    Campaign,
    flange_frames,
    geometry_of,
    in_standard_rows,
    with_geometry,
)
from study.spoiled_setups.design import SCANNER, SetUp

PLANES = ("floor", "wall_x", "wall_y")
SHARE_OF_RANGE, WIDEST = 0.8, 2.6
"""Share of each joint's range that the poses use, and largest half of it [rad]."""
LENGTH_ERROR, ANGLE_ERROR = 1e-3, 2e-3  # bounds of the errors of the table [m, rad]
MOUNT_ERROR = (5e-3, 0.05)  # of the declared pose of the sensor [m, rad]
LEANING, GUESS_OFFSET = (
    0.05,
    5e-3,
)  # of planes: standard deviation of components of their normals; of declared distances [m]
SCANNER_MOUNT = rotation(2, np.pi) @ translation(0, 0.12) @ translation(2, 0.1)
TARGET_MOUNT = translation(0, 0.05) @ translation(2, 0.1)
FAN = 0.26  # rad, half angle of the fan
RANGES, INCIDENCE = (0.10, 0.45), 0.9  # m along a ray; rad between ray and normal
POINTS = 15  # of a scan
BATCH, ROUNDS = 4000, 150  # random poses tried at once, and how often


@dataclass(frozen=True, eq=False)
class Workcell:
    """A sound campaign with its truth.

    Attributes:
        campaign: As its files have it.
        true_robot: The ``robot:`` block with the true numbers.
        T_flange_sensor: True pose ``(4, 4)`` of the sensor.
    """

    campaign: Campaign
    true_robot: dict[str, Any]
    T_flange_sensor: np.ndarray


class OutOfReach(Exception):
    """The planes cannot be scanned by this arm."""


def workcell(setup: SetUp, rng: np.random.Generator) -> Workcell:
    """Return a sound campaign.

    Args:
        setup: What was drawn for the set.
        rng: Draws the errors of the table, poses, planes and noise.

    Raises:
        OutOfReach: The arm hardly reaches the planes with this scanner.
    """
    arm = read_arm(setup.arm)
    nominal: dict[str, Any] = dict(arm.mapping)
    geometry = geometry_of(nominal)
    size = np.array([LENGTH_ERROR, ANGLE_ERROR, LENGTH_ERROR, ANGLE_ERROR, 0.0])[:, None]
    true = with_geometry(nominal, geometry + size * rng.uniform(-1, 1, geometry.shape))
    scanning = setup.sensor == SCANNER
    mount = SCANNER_MOUNT if scanning else TARGET_MOUNT
    T_flange_sensor = mount @ random_transform(rng, 3e-3, 0.02)
    sensor: dict[str, Any] = {"kind": setup.sensor, "noise": setup.noise_m}
    if scanning:
        sensor["error_axis"] = "ray"
    if setup.states_pose:
        length, angle = MOUNT_ERROR * rng.uniform(0, 1, 2)
        sensor["nominal_pose"] = pose_mapping(T_flange_sensor @ random_transform(rng, length, angle))
    limits = np.array([joint["limits"] for joint in nominal["joints"]], dtype=float)
    measured = _scans if scanning else _positions
    reach = float(np.hypot(geometry[0], geometry[2]).sum())
    planes, q, labels, points = measured(setup, rng, true, T_flange_sensor, limits, reach)
    if setup.standard:
        nominal, true = in_standard_rows(nominal), in_standard_rows(true)
    if not setup.named:
        nominal = {**nominal, "name": "arm"}
    return Workcell(Campaign(nominal, sensor, planes, q, labels, points), true, T_flange_sensor)


def random_angles(
    rng: np.random.Generator, limits: np.ndarray, count: int, share: float = SHARE_OF_RANGE
) -> np.ndarray:
    """Return joint angles ``(count, n)`` [rad] around the middle of the limits ``(n, 2)``, over a share of these."""
    low, high = limits.T
    half = np.minimum(share * (high - low) / 2, WIDEST)
    return (low + high) / 2 + half * rng.uniform(-1, 1, (count, len(limits)))


def _positions(
    setup: SetUp, rng: np.random.Generator, true: Any, T: np.ndarray, limits: np.ndarray, reach: float
) -> tuple[tuple[Any, ...], np.ndarray, tuple[str, ...], tuple[np.ndarray, ...]]:
    """Return no planes, joint angles, no labels, and the positions that a tracker at a random place measures."""
    q = random_angles(rng, limits, setup.poses)
    T_tracker_base = random_transform(rng, 2.0, 2.0)
    places = (T_tracker_base @ flange_frames(true, q) @ T)[:, :3, 3]
    places = places + setup.noise_m * rng.standard_normal(places.shape)
    return (), q, (), tuple(places[:, None, :])


def _scans(
    setup: SetUp, rng: np.random.Generator, true: Any, T: np.ndarray, limits: np.ndarray, reach: float
) -> tuple[tuple[Any, ...], np.ndarray, tuple[str, ...], tuple[np.ndarray, ...]]:
    """Return declared planes, joint angles, labels, and scans of a floor and two walls in random order."""
    normals, distances = floor_and_walls(rng, reach)
    index = rng.permutation(np.arange(setup.poses) % len(PLANES))
    q = angles_seeing(rng, true, T, limits, normals, distances, index)
    points = scans(rng, flange_frames(true, q) @ T, normals[index], distances[index], setup.noise_m)
    planes = tuple(
        {"name": name, "normal": leaning(rng, n).tolist(), "distance": float(d + GUESS_OFFSET * rng.normal())}
        for name, n, d in zip(PLANES, normals, distances, strict=True)
    )
    return planes, q, tuple(PLANES[k] for k in index), points


def scans(
    rng: np.random.Generator, frames: np.ndarray, normals: np.ndarray, distances: np.ndarray, noise: float
) -> tuple[np.ndarray, ...]:
    """Return the scans of poses, each ``(POINTS, 2)`` [m], by rays at random angles within the fan, with noise along them.

    Args:
        rng: Draws the rays and the noise.
        frames: True frames of the scanner ``(N, 4, 4)``.
        normals, distances: Of the plane before each pose, ``(N, 3)`` and ``(N,)`` [m].
        noise: Standard deviation of a range [m].
    """
    points = []
    for frame, n, d in zip(frames, normals, distances, strict=True):
        angles = np.sort(rng.uniform(-FAN, FAN, POINTS))
        along, _ = _ranges(frame[None], n, d, angles)
        ranges = along[0] + noise * rng.standard_normal(POINTS)
        points.append(np.column_stack([ranges * np.sin(angles), ranges * np.cos(angles)]))
    return tuple(points)


def angles_seeing(
    rng: np.random.Generator,
    true: Any,
    T: np.ndarray,
    limits: np.ndarray,
    normals: np.ndarray,
    distances: np.ndarray,
    index: np.ndarray,
    share: float = SHARE_OF_RANGE,
) -> np.ndarray:
    """Return joint angles ``(N, n)`` [rad] at which the whole fan meets the plane of each pose, the floor from above and the walls from within.

    Raises:
        OutOfReach: Too few random poses do.
    """
    found: list[list[np.ndarray]] = [[] for _ in normals]
    wanted = np.bincount(index, minlength=len(normals))
    fan = np.array([-FAN, 0.0, FAN])
    for _ in range(ROUNDS):
        tried = random_angles(rng, limits, BATCH, share)
        frames = flange_frames(true, tried) @ T
        for k, (n, d) in enumerate(zip(normals, distances, strict=True)):
            along, cosine = _ranges(frames, n, d, fan)
            near = (along > RANGES[0]) & (along < RANGES[1]) & (cosine > np.cos(INCIDENCE))
            right_side = (frames[:, :3, 3] @ n > d) == (k == 0)
            found[k].extend(tried[np.all(near, axis=1) & right_side])
        if all(len(poses) >= count for poses, count in zip(found, wanted, strict=True)):
            q = np.empty((len(index), len(limits)))
            for k, count in enumerate(wanted):
                q[index == k] = found[k][:count]
            return q
    raise OutOfReach


def _ranges(frames: np.ndarray, n: np.ndarray, d: float, angles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return lengths [m] of rays to the plane ``n . p = d`` and cosines of their incidence, both ``(N, r)``; angles from z in the x-z plane."""
    along = np.outer(frames[:, :3, 0] @ n, np.sin(angles)) + np.outer(frames[:, :3, 2] @ n, np.cos(angles))
    with np.errstate(divide="ignore"):
        return (d - frames[:, :3, 3] @ n)[:, None] / along, np.abs(along)


def floor_and_walls(rng: np.random.Generator, reach: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the true normals ``(3, 3)`` and distances ``(3,)`` [m] of a floor and two walls about an arm of a reach [m]."""
    return np.stack([leaning(rng, axis) for axis in np.eye(3)[[2, 0, 1]]]), np.array(
        [0.0, 0.65 * reach, 0.65 * reach]
    )


def leaning(rng: np.random.Generator, normal: np.ndarray) -> np.ndarray:
    """Return a unit normal ``(3,)`` turned by a small random angle."""
    turn = LEANING * rng.standard_normal(3)
    return rotate_about(turn, float(np.linalg.norm(turn))) @ normal


def measured_points(workcell: Workcell) -> np.ndarray:
    """Return points ``(K, 3)`` [m] in the flange's frame whose predicted places a measurement depends on: one target, or a scanner's whole frame."""
    origin = workcell.T_flange_sensor[:3, 3]
    if not workcell.campaign.labels:
        return origin[None]
    return origin + np.vstack([np.zeros(3), 0.3 * workcell.T_flange_sensor[:3, :3].T])
