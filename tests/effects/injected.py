"""Workcells with something wrong that nobody declared: injected by this file's own kinematics and rays, sharing
nothing with ``scalar.effects``.

``tests.random_scene`` gives poses, the nominal robot and where each ray points; the rays are cut
again here with an arm whose joints err, whose lengths grow, whose base tilts or whose target planes are bent. What
is injected is a function of a ``PoseData``: the joint angles as the encoders read them and everything else that
is known of the poses.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pandas as pd

from scalar.data.dataset import Dataset
from tests.kinematics import joint_names, rotation, rotation_vector, translation
from tests.random_scene import make_scene
from tests.workcell import PLANE_NAMES, Scene, Truth, with_noise

A, ALPHA, D, THETA, BETA = range(5)


@dataclass(frozen=True)
class PoseData:
    """What is known of N poses: encoder angles ``(N, n)`` [rad], order ``(N,)`` and other columns by name, ``(N,)`` each."""

    q: np.ndarray
    order: np.ndarray
    columns: dict[str, np.ndarray]


Function = Callable[[PoseData], np.ndarray]


def _nothing(size: tuple[int, ...]) -> Function:
    return lambda at: np.zeros((len(at.q), *size))


@dataclass(frozen=True)
class Flaws:
    """What is wrong with a workcell.

    Attributes:
        joints: Errors of the joint angles ``(N, n)`` [rad]; the arm stands at q + dq.
        geometry: Changes of the geometry ``(N, 5, n)``.
        base: Motions of the whole arm ``(N, 4, 4)``.
        slip: (order of the first pose after it, T_old_new).
        bent: By target plane: curvatures (uu, uv, vv) [1/m] about a point of the target plane near where it is scanned.
        moved: By target plane: (order of the first pose after it, translation along the normal [m], turns [rad]).
        creep: By target plane: (order at which it begins, translation along the normal [m] by the last pose).
        measured: Range as the laser has it from the true range, [m] to [m].
        jitter: Standard deviation of every joint, afresh for every pose [rad].
        bias: Standard deviation of an error of the range common to a scan [m].
        drift: Error of the range [m] at each order ``(N,)``.
    """

    joints: Function | None = None
    geometry: Function | None = None
    base: Function | None = None
    slip: tuple[float, np.ndarray] | None = None
    bent: dict[str, tuple[float, float, float]] = field(default_factory=dict)
    moved: dict[str, tuple[float, float, tuple[float, float]]] = field(default_factory=dict)
    creep: dict[str, tuple[float, float]] = field(default_factory=dict)
    measured: Callable[[np.ndarray], np.ndarray] = lambda r: r
    jitter: float = 0.0
    bias: float = 0.0
    drift: Callable[[np.ndarray], np.ndarray] = np.zeros_like


@dataclass(frozen=True, eq=False)
class Cell:
    """A dataset of a flawed workcell, with its truth."""

    scene: Scene
    dataset: Dataset
    flaws: Flaws

    def sensor(self, at: PoseData) -> np.ndarray:
        """Return where the sensor truly stands ``(N, 4, 4)``."""
        return true_frames(self.scene.truth, self.flaws, at, np.zeros_like(at.q))

    def truth_poses(self, count: int, rng: np.random.Generator) -> tuple[pd.DataFrame, PoseData]:
        """Return random poses within the limits with their true frames, in the state at the end."""
        limits = self.scene.truth.limits
        q = limits[:, 0] + rng.random((count, len(limits))) * np.ptp(limits, axis=1)
        at = PoseData(q, np.full(count, float(self.dataset.n_poses - 1)), {})
        T = self.sensor(at)
        names = ["pose", *joint_names(q.shape[1]), "x", "y", "z", "rx", "ry", "rz"]
        values = np.column_stack([np.arange(count), q, T[:, :3, 3], rotation_vector(T[:, :3, :3])])
        return pd.DataFrame(values, columns=names).astype({"pose": int}), at


def true_frames(truth: Truth, flaws: Flaws, at: PoseData, jitter: np.ndarray) -> np.ndarray:
    """Return the true frames of the sensor ``(N, 4, 4)`` in the base frame, joint after joint."""
    N, n = at.q.shape
    q = at.q + jitter + (flaws.joints or _nothing((n,)))(at)
    g = truth.geometry + (flaws.geometry or _nothing((5, n)))(at)
    T = np.broadcast_to(truth.T_base_0, (N, 4, 4))
    if flaws.base is not None:
        T = flaws.base(at) @ T
    for i in range(n):
        T = T @ rotation(0, g[:, ALPHA, i]) @ translation(0, g[:, A, i]) @ rotation(1, g[:, BETA, i])
        T = T @ rotation(2, q[:, i] + g[:, THETA, i]) @ translation(2, g[:, D, i])
    T = T @ truth.T_n_flange @ truth.T_flange_sensor
    if flaws.slip is not None:
        first, motion = flaws.slip
        T = T @ np.where((at.order >= first)[:, None, None], motion, np.eye(4))
    return T


def target_plane_axes(truth: Truth, target_plane: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return two unit vectors in a target plane and its point about which it bends and turns, ``(3,)`` each."""
    k = PLANE_NAMES.index(target_plane)
    n = truth.normals[k]
    u = np.cross(n, np.eye(3)[np.argmin(np.abs(n))])
    u /= np.linalg.norm(u)
    near = np.array([0.3, 0.3, 0.3])
    return u, np.cross(n, u), near - n * (n @ near - truth.distances[k])


def ranges(
    truth: Truth, flaws: Flaws, T: np.ndarray, index: np.ndarray, order: np.ndarray, angles: np.ndarray
) -> np.ndarray:
    """Return the true ranges ``(P,)`` [m] of rays at angles ``(P,)`` from z.

    The sensors stand at ``T`` ``(P, 4, 4)``; ``index`` ``(P,)`` says which target plane each ray meets.

    Along a ray the height over a target plane is a parabola in the range: the root near the flat target plane's is the hit.
    """
    o = T[:, :3, 3]
    e = T[:, :3, 0] * np.sin(angles)[:, None] + T[:, :3, 2] * np.cos(angles)[:, None]
    hits = np.empty(len(o))
    last = max(float(order.max()), 1.0)
    for k in np.unique(index):
        mine = index == k
        target_plane = PLANE_NAMES[k]
        u, v, centre = target_plane_axes(truth, target_plane)
        n = np.broadcast_to(truth.normals[k], (int(mine.sum()), 3)).copy()
        lift = np.zeros(int(mine.sum()))
        if target_plane in flaws.moved:
            first, along, (turn_u, turn_v) = flaws.moved[target_plane]
            after = (order[mine] >= first).astype(float)
            lift += after * along
            n += after[:, None] * (turn_u * u + turn_v * v)
            n /= np.linalg.norm(n, axis=1, keepdims=True)
        if target_plane in flaws.creep:
            first, along = flaws.creep[target_plane]
            lift += along * np.maximum(order[mine] - first, 0.0) / (last - first)
        s, t = o[mine] - centre, e[mine]
        uu, uv, vv = flaws.bent.get(target_plane, (0.0, 0.0, 0.0))
        H = uu * np.outer(u, u) + uv * (np.outer(u, v) + np.outer(v, u)) / 2 + vv * np.outer(v, v)
        # n . (s + r t) - lift - (s + r t)' H (s + r t) = 0
        c0 = np.sum(n * s, 1) - lift - np.einsum("pi,ij,pj->p", s, H, s)
        c1 = np.sum(n * t, 1) - 2 * np.einsum("pi,ij,pj->p", s, H, t)
        c2 = -np.einsum("pi,ij,pj->p", t, H, t)
        hits[mine] = 2 * -c0 / (c1 + np.sign(c1) * np.sqrt(c1 * c1 - 4 * c2 * c0))
    return hits


def make_cell(
    flaws: Flaws = Flaws(),
    *,
    seed: int = 0,
    robot: str = "vs060",
    poses_per_plane: int = 60,
    points_per_scan: int | tuple[int, int] = 32,
    noise: float = 1e-4,
    columns: Callable[[np.random.Generator, int, int], dict[str, np.ndarray]] | None = None,
    **scene: Any,
) -> Cell:
    """Return a workcell with flaws, as a line laser sees it.

    Args:
        flaws: What is wrong.
        seed: Of everything.
        robot, poses_per_plane, points_per_scan, noise, scene: As in ``make_scene``.
        columns: Further columns of poses.csv from a generator, the number of poses and of joints.
    """
    rng = np.random.default_rng([seed, 77])
    sizes = {"poses_per_plane": poses_per_plane, "points_per_scan": points_per_scan, "noise": noise}
    base = make_scene(robot, seed=seed, **sizes, **scene)
    data = base.dataset
    N = data.n_poses
    extra = columns(rng, N, data.q.shape[1]) if columns else {}
    at = PoseData(data.q, np.arange(N, dtype=float), extra)
    T = true_frames(base.truth, flaws, at, flaws.jitter * rng.standard_normal(data.q.shape))
    owner = np.repeat(np.arange(N), np.diff(data.starts))
    angles = np.arctan2(base.clean[:, 0], base.clean[:, 1])
    r = ranges(base.truth, flaws, T[owner], data.plane_index[owner], owner.astype(float), angles)
    r = flaws.measured(r) + (flaws.drift(at.order) + flaws.bias * rng.standard_normal(N))[owner]
    points = with_noise(np.column_stack([r * np.sin(angles), r * np.cos(angles)]), data.sensor, noise, rng)
    return Cell(base, replace(data, points=points, poses=data.poses.assign(**extra)), flaws)


def on_joint(joint: int, function: Callable[[PoseData], np.ndarray]) -> Function:
    """Return an error of one joint (from 1), given by a function of the poses' data that returns ``(N,)`` [rad]."""

    def errors(at: PoseData) -> np.ndarray:
        dq = np.zeros_like(at.q)
        dq[:, joint - 1] = function(at)
        return dq

    return errors


def gravity_torques(
    truth: Truth, q: np.ndarray, masses: np.ndarray, centres: np.ndarray, step: float = 1e-5
) -> np.ndarray:
    """Return minus the gradient of the potential energy ``(N, n)`` [N m] by central differences.

    Args:
        truth: Gives the chain.
        q: ``(N, n)`` [rad].
        masses: ``(n,)`` [kg].
        centres: ``(n, 3)`` [m], of mass in each link's own frame.
    """

    def energy(angles: np.ndarray) -> np.ndarray:
        T = np.broadcast_to(truth.T_base_0, (len(angles), 4, 4))
        total = np.zeros(len(angles))
        for i in range(angles.shape[1]):
            g = truth.geometry[:, i]
            T = T @ rotation(0, g[ALPHA]) @ translation(0, g[A]) @ rotation(1, g[BETA])
            T = T @ rotation(2, angles[:, i] + g[THETA]) @ translation(2, g[D])
            total += masses[i] * 9.81 * (T[:, 2, :3] @ centres[i] + T[:, 2, 3])
        return total

    columns = []
    for j in range(q.shape[1]):
        ahead, behind = q.copy(), q.copy()
        ahead[:, j] += step
        behind[:, j] -= step
        columns.append(-(energy(ahead) - energy(behind)) / (2 * step))
    return np.column_stack(columns)


def shares_of_torque(truth: Truth, q: np.ndarray, joint: int) -> np.ndarray:
    """Return the gravity torque on a joint, from 1, of an arm with links that get lighter, over the largest of it ``(N,)``."""
    n = q.shape[1]
    torque = gravity_torques(truth, q, np.linspace(8.0, 1.0, n), np.full((n, 3), 0.08))[:, joint - 1]
    return torque / np.abs(torque).max()


def sag(truth: Truth, compliance: np.ndarray, rng: np.random.Generator) -> Function:
    """Return joints that give way [rad] under links of random masses, ``compliance`` ``(n,)`` [rad/(N m)]."""
    n = truth.geometry.shape[1]
    masses = np.linspace(8.0, 1.0, n) * rng.uniform(0.7, 1.3, n)
    centres = rng.uniform(-0.15, 0.15, (n, 3))
    # The middle of a link lies towards the next frame.
    for i in range(n - 1):
        centres[i, 0] += truth.geometry[A, i + 1] / 2
        centres[i, 2] -= truth.geometry[D, i] / 2
    return lambda at: compliance * gravity_torques(truth, at.q, masses, centres)
