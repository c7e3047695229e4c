"""Poses at which a sensor meets its target planes, and what it measures there without noise: rays cut with planes, and contacts of a
probe, both in closed form.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from tests.workcell import Truth

FAN_HALF_ANGLE = np.deg2rad(15.0)
RANGES = (0.10, 0.45)  # m, along a ray
GREATEST_INCIDENCE = np.deg2rad(50.0)  # between a ray and the normal of the plane that it meets


def random_poses(
    rng: np.random.Generator, limits: np.ndarray, count: int, still: tuple[int, float] | None
) -> np.ndarray:
    """Return joint angles ``(count, n)`` [rad] within limits ``(n, 2)``; ``still`` is a joint, from 0, that does not move, and its angle."""
    q = limits[:, 0] + rng.random((count, len(limits))) * np.ptp(limits, axis=1)
    if still is not None:
        q[:, still[0]] = still[1]
    return q


def scanning_poses(
    rng: np.random.Generator,
    truth: Truth,
    index: np.ndarray,
    still: tuple[int, float] | None,
    batch: int = 3000,
) -> np.ndarray:
    """Return joint angles ``(N, n)`` [rad] at which the whole fan meets the target plane of index ``(N,)``, within ``RANGES`` and
    ``GREATEST_INCIDENCE``.

    Args:
        index: Of the target plane of each pose, ``(N,)``. The first plane is scanned from the side of its normal, the others from behind.
        still: A joint, from 0, that does not move, and its angle [rad].
        batch: How many random poses are tried at once.
    """
    found: list[list[np.ndarray]] = [[] for _ in truth.normals]
    wanted = np.bincount(index, minlength=len(truth.normals))
    fan = np.array([-FAN_HALF_ANGLE, 0.0, FAN_HALF_ANGLE])
    for _ in range(200):
        q = random_poses(rng, truth.limits, batch, still)
        T = truth.sensor(q)
        for k, (n, d) in enumerate(zip(truth.normals, truth.distances, strict=True)):
            reach, cosine = ranges_to_plane(T, n, np.full(len(q), d), fan)
            inside = (T[:, :3, 3] @ n > d) == (k == 0)
            good = inside & np.all(
                (reach > RANGES[0]) & (reach < RANGES[1]) & (cosine > np.cos(GREATEST_INCIDENCE)), axis=1
            )
            found[k].extend(q[good])
        if all(len(f) >= w for f, w in zip(found, wanted, strict=True)):
            break
    else:
        raise AssertionError("no poses found: the target planes are out of the arm's reach")
    poses = np.empty((len(index), len(truth.limits)))
    for k in range(len(truth.normals)):
        poses[index == k] = found[k][: wanted[k]]
    return poses


def scan(
    rng: np.random.Generator, truth: Truth, q: np.ndarray, index: np.ndarray, counts: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return points ``(P, 2)`` [m] in the sensor frame without noise, of rays at random angles within the fan, and the row where each scan
    begins ``(N + 1,)``.

    Args:
        q: Joint angles ``(N, n)`` [rad].
        index: Of the target plane of each pose, ``(N,)``.
        counts: Points of each scan ``(N,)``.
    """
    starts = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
    owner = np.repeat(np.arange(len(q)), counts)
    angles = rng.uniform(-FAN_HALF_ANGLE, FAN_HALF_ANGLE, size=(len(owner), 1))
    T = truth.sensor(q)[owner]
    reach, _ = ranges_to_plane(T, truth.normals[index[owner]], truth.distances[index[owner]], angles)
    return np.column_stack([reach * np.sin(angles), reach * np.cos(angles)]), starts


def touching_poses(
    rng: np.random.Generator,
    truth: Truth,
    index: np.ndarray,
    gap: np.ndarray,
    still: tuple[int, float] | None,
) -> np.ndarray:
    """Return joint angles ``(N, n)`` [rad] at which the tip ``o`` of the probe is a given gap from its target plane.

    The height over a plane is ``A + B cos q_j + C sin q_j`` in any one joint: three heights give A, B, C, and
    the angle follows.

    Args:
        index: Of the target plane of each pose, ``(N,)``.
        gap: ``n . o - d`` ``(N,)`` [m].
        still: A joint, from 0, that does not move, and its angle [rad].
    """
    movable = [j for j in (1, 2, 3) if still is None or j != still[0]]
    poses = np.empty((len(index), len(truth.limits)))
    todo = np.arange(len(index))
    for _ in range(200):
        tried = np.resize(todo, max(len(todo), 300))
        q = random_poses(rng, truth.limits, len(tried), still)
        j = int(rng.choice(movable))
        n, d = truth.normals[index[tried]], truth.distances[index[tried]] + gap[tried]
        height = []
        for angle in (0.0, np.pi, np.pi / 2):
            q[:, j] = angle
            height.append(np.sum(n * truth.sensor(q)[:, :3, 3], axis=1))
        A, B = (height[0] + height[1]) / 2, (height[0] - height[1]) / 2
        C = height[2] - A
        with np.errstate(invalid="ignore"):
            swing = np.arccos((d - A) / np.hypot(B, C)) * rng.choice([-1.0, 1.0], size=len(tried))
        q[:, j] = (np.arctan2(C, B) + swing + np.pi) % (2 * np.pi) - np.pi
        good = np.isfinite(swing) & (q[:, j] > truth.limits[j, 0]) & (q[:, j] < truth.limits[j, 1])
        poses[tried[good]] = q[good]
        todo = np.setdiff1d(todo, tried[good])
        if not len(todo):
            return poses
    raise AssertionError("no contacts found: the target planes are out of the arm's reach")


def ranges_to_plane(
    T: np.ndarray, n: np.ndarray, d: Any, angles: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the ranges [m] along rays to a plane ``n . p = d``, and the cosines of their incidence, both ``(..., r)``.

    Args:
        T: ``T_base_sensor`` ``(..., 4, 4)``.
        n, d: The plane in the base frame: normal ``(..., 3)`` and distance ``(...)`` [m].
        angles: Of the rays in the sensor's x-z plane, from z ``(..., r)`` [rad].
    """
    X, Z, o = T[..., :3, 0], T[..., :3, 2], T[..., :3, 3]
    nX, nZ, no = (np.sum(n * v, axis=-1)[..., None] for v in (X, Z, o))
    along = nX * np.sin(angles) + nZ * np.cos(angles)
    with np.errstate(divide="ignore"):
        return (np.asarray(d)[..., None] - no) / along, np.abs(along)
