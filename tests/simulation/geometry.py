"""Geometry of a scene computed a second time, without pybullet and without the simulator's own code."""

from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation


def sensor_frames(arm: Any, q: np.ndarray) -> np.ndarray:
    """Return T_base_sensor (N, 4, 4) of an arm, (N, n) [rad], by multiplying SciPy's elementary rotations."""
    frames = []
    for row in q:
        T = arm.T_base_0
        for i, angle in enumerate(row):
            T = T @ _turn("x", arm.alpha[i]) @ _shift(arm.a[i], 0, 0)
            T = T @ _turn("y", arm.beta[i]) @ _turn("z", angle + arm.theta[i]) @ _shift(0, 0, arm.d[i])
        frames.append(T @ arm.T_n_flange @ arm.T_flange_sensor)
    return np.array(frames)


def _turn(axis: str, angle: float) -> np.ndarray:
    T = np.eye(4)
    T[:3, :3] = Rotation.from_euler(axis, angle).as_matrix()
    return T


def _shift(x: float, y: float, z: float) -> np.ndarray:
    T = np.eye(4)
    T[:3, 3] = x, y, z
    return T


def fan_hits(
    T: np.ndarray, angles: np.ndarray, normal: np.ndarray, distance: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return range (M,) [m], cosine of incidence (M,), point (M, 3) [m] where a fan meets n . p = d."""
    u = np.sin(angles)[:, None] * T[:3, 0] + np.cos(angles)[:, None] * T[:3, 2]
    approach = u @ normal
    ranges = (distance - normal @ T[:3, 3]) / approach
    return ranges, np.abs(approach), T[:3, 3] + ranges[:, None] * u


def distance_to_box(points: np.ndarray, axes: np.ndarray, centre: np.ndarray, size: np.ndarray) -> np.ndarray:
    """Return the distance [m] of points (P, 3) from a solid box; 0 inside."""
    outside = np.abs((points - centre) @ axes) - size / 2
    return np.linalg.norm(np.maximum(outside, 0.0), axis=1)


def link_frames(arm: Any, q: np.ndarray) -> np.ndarray:
    """Return T_base_link (N, n, 4, 4) of the links behind each joint, by SciPy's elementary rotations."""
    frames = np.empty((*q.shape, 4, 4))
    for k, row in enumerate(q):
        T = arm.T_base_0
        for i, angle in enumerate(row):
            T = T @ _turn("x", arm.alpha[i]) @ _shift(arm.a[i], 0, 0)
            T = T @ _turn("y", arm.beta[i]) @ _turn("z", angle + arm.theta[i]) @ _shift(0, 0, arm.d[i])
            frames[k, i] = T
    return frames


def masses_at(arm: Any, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return where the masses of an arm are, (N, n + 1, 3) [m], the sensor's last, and how heavy, (n + 1,) [kg]."""
    frames = link_frames(arm, q)
    centres = np.einsum("nlij,lj->nli", frames[..., :3, :3], arm.weights.centres) + frames[..., :3, 3]
    sensor = sensor_frames(arm, q)[:, None, :3, 3]
    return np.concatenate([centres, sensor], axis=1), np.append(arm.weights.masses, arm.weights.sensor)
