"""A tiny robot cell of its own: joint angles in, perfect and noisy measurements out, with the truth beside
them.

A second opinion on ``scalar``: forward kinematics by multiplying elementary 4 x 4 matrices, rays cut with
planes in closed form,
contacts of a probe solved in closed form. Nothing here calls ``scalar``'s kinematics, residuals or
simulation; of ``scalar`` it
uses the plain containers ``Dataset``, ``Robot``, ``Sensor`` and ``PlaneGuess`` and the writer. Left out:
collisions, target planes' edges.
"""

from __future__ import annotations

import functools
import json
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import yaml

from scalar.data.dataset import Dataset
from scalar.data.dataset_writer import write_dataset
from scalar.data.declared import PlaneGuess, Sensor
from scalar.geometry.robot import Robot

CONFIGS = Path(__file__).parents[1] / "configs" / "robots"
KINDS = ("a", "alpha", "d", "theta", "beta")
PUBLISHED_HELD = ("d_6", "theta_6", "d_2", "a_1", "alpha_1", "theta_1", "d_1")
HELD = {
    "vs060": PUBLISHED_HELD,
    "puma560": PUBLISHED_HELD,
    "ur10e": (*PUBLISHED_HELD, "d_3"),
    "panda": ("d_7", "theta_7", "a_1", "alpha_1", "theta_1", "d_1"),
}
"""What planes cannot show, by robot: kept at its truth in the nominal model, so that raw errors mean
something.
"""
SCALE = {"vs060": "a_3", "puma560": "a_3", "ur10e": "a_3", "panda": "d_5"}
"""What a probe cannot show besides: one length, kept at its truth as well."""

SCANNER = np.array([[-1.0, 0, 0, -0.1275], [0, -1.0, 0, -0.033], [0, 0, 1.0, 0.1015], [0, 0, 0, 1.0]])
"""The paper's scanner on the flange: half a turn about z."""
FAN = np.deg2rad(15.0)
STANDOFF = (0.10, 0.45)  # m
GRAZING = np.cos(np.deg2rad(50.0))
PLANE_NAMES = ("floor", "wall_x", "wall_y")


def rotation(axis: int, angle: Any) -> np.ndarray:
    """Return ``(..., 4, 4)`` rotations about the x, y or z axis (0, 1, 2) by angles ``(...)`` [rad]."""
    angle = np.asarray(angle, dtype=float)
    T = np.zeros((*angle.shape, 4, 4))
    i, j = (axis + 1) % 3, (axis + 2) % 3
    T[..., axis, axis] = T[..., 3, 3] = 1.0
    T[..., i, i] = T[..., j, j] = np.cos(angle)
    T[..., i, j], T[..., j, i] = -np.sin(angle), np.sin(angle)
    return T


def shift(axis: int, length: Any) -> np.ndarray:
    """Return ``(..., 4, 4)`` translations along the x, y or z axis (0, 1, 2) by lengths ``(...)`` [m]."""
    length = np.asarray(length, dtype=float)
    T = np.zeros((*length.shape, 4, 4))
    T[...] = np.eye(4)
    T[..., axis, 3] = length
    return T


def rotate_about(axis: np.ndarray, angle: float) -> np.ndarray:
    """Return the rotation ``(3, 3)`` by an angle [rad] about any axis ``(3,)``: Rodrigues' formula."""
    x, y, z = np.asarray(axis, dtype=float) / np.linalg.norm(axis)
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K


def rotation_vector(R: np.ndarray) -> np.ndarray:
    """Return the rotation vectors ``(..., 3)`` [rad] of rotations ``(..., 3, 3)``, by way of quaternions;
    any angle up to pi.
    """
    m = np.asarray(R, dtype=float)
    # The four candidates of a quaternion; the one with the largest norm is accurate (Shepperd, 1978).
    xx, yy, zz = m[..., 0, 0], m[..., 1, 1], m[..., 2, 2]
    xy, xz, yz = m[..., 0, 1] + m[..., 1, 0], m[..., 0, 2] + m[..., 2, 0], m[..., 1, 2] + m[..., 2, 1]
    wx, wy, wz = m[..., 2, 1] - m[..., 1, 2], m[..., 0, 2] - m[..., 2, 0], m[..., 1, 0] - m[..., 0, 1]
    rows = np.stack(
        [
            np.stack([1 + xx + yy + zz, wx, wy, wz], -1),
            np.stack([wx, 1 + xx - yy - zz, xy, xz], -1),
            np.stack([wy, xy, 1 - xx + yy - zz, yz], -1),
            np.stack([wz, xz, yz, 1 - xx - yy + zz], -1),
        ],
        -2,
    )
    best = np.argmax(np.linalg.norm(rows, axis=-1), axis=-1)
    quaternion = np.take_along_axis(rows, best[..., None, None], axis=-2)[..., 0, :]
    quaternion = quaternion / np.linalg.norm(quaternion, axis=-1, keepdims=True)
    quaternion = quaternion * np.where(quaternion[..., :1] < 0, -1.0, 1.0)
    sine = np.linalg.norm(quaternion[..., 1:], axis=-1, keepdims=True)
    angle = 2 * np.arctan2(sine, quaternion[..., :1])
    return quaternion[..., 1:] * np.where(sine > 1e-12, angle / np.where(sine > 1e-12, sine, 1.0), 2.0)


def robot_mapping(name: str) -> dict[str, Any]:
    """Return the content of ``configs/robots/<name>.yaml``."""
    return dict(_robot_mapping(name))


@functools.cache
def _robot_mapping(name: str) -> dict[str, Any]:
    return yaml.safe_load((CONFIGS / f"{name}.yaml").read_text(encoding="utf-8"))


def fixed(mapping: dict[str, Any] | None) -> np.ndarray:
    """Return the transform ``(4, 4)`` of ``{translation, rotation_vector}``."""
    T = np.eye(4)
    if mapping:
        T[:3, 3] = mapping.get("translation", [0, 0, 0])
        turn = np.array(mapping.get("rotation_vector", [0, 0, 0]), dtype=float)
        if np.linalg.norm(turn) > 0:
            T[:3, :3] = rotate_about(turn, float(np.linalg.norm(turn)))
    return T


@dataclass(frozen=True, eq=False)
class Truth:
    """The true cell.

    Attributes:
        geometry: ``(5, n)``, rows as in ``KINDS`` [m, rad].
        T_base_0, T_n_flange, T_flange_sensor: ``(4, 4)``.
        limits: ``(n, 2)`` [rad].
        normals: ``(K, 3)``, distances: ``(K,)`` [m]; empty for a tracker.
        T_tracker_base: ``(4, 4)``, for a tracker.
    """

    geometry: np.ndarray
    T_base_0: np.ndarray
    T_n_flange: np.ndarray
    T_flange_sensor: np.ndarray
    limits: np.ndarray
    normals: np.ndarray
    distances: np.ndarray
    T_tracker_base: np.ndarray

    def sensor(self, q: np.ndarray) -> np.ndarray:
        """Return ``T_base_sensor`` ``(N, 4, 4)`` at joint angles ``(N, n)`` [rad]."""
        return chain(self.geometry, q, self.T_base_0) @ self.T_n_flange @ self.T_flange_sensor

    def parameters(self) -> dict[str, float]:
        """Return the true value of every parameter of robot and sensor by name."""
        n = self.geometry.shape[1]
        values = {
            f"{kind}_{i + 1}": float(self.geometry[k, i]) for k, kind in enumerate(KINDS) for i in range(n)
        }
        turn = rotation_vector(self.T_flange_sensor[:3, :3])
        values.update(
            {f"sensor_{axis}": float(x) for axis, x in zip("xyz", self.T_flange_sensor[:3, 3], strict=True)}
        )
        values.update({f"sensor_r{axis}": float(x) for axis, x in zip("xyz", turn, strict=True)})
        return values

    def mapping(self) -> dict[str, Any]:
        """Return the content of ``truth.json``."""
        parameters: dict[str, Any] = {
            kind: row.tolist() for kind, row in zip(KINDS, self.geometry, strict=True)
        }
        parameters["t"] = self.T_flange_sensor[:3, 3].tolist()
        parameters["r"] = rotation_vector(self.T_flange_sensor[:3, :3]).tolist()
        planes = {"names": list(PLANE_NAMES[: len(self.normals)])}
        planes.update(normals=self.normals.tolist(), distances=self.distances.tolist())
        return {"parameters": parameters, "planes": planes, "effects": []}

    def poses(self, count: int, rng: np.random.Generator) -> pd.DataFrame:
        """Return random poses within the limits with the true sensor frames: the columns of
        ``truth_poses.csv``.
        """
        q = self.limits[:, 0] + rng.random((count, len(self.limits))) * np.ptp(self.limits, axis=1)
        T = self.sensor(q)
        columns = ["pose", *joint_names(q.shape[1]), "x", "y", "z", "rx", "ry", "rz"]
        values = np.column_stack([np.arange(count), q, T[:, :3, 3], rotation_vector(T[:, :3, :3])])
        return pd.DataFrame(values, columns=columns).astype({"pose": int})


def joint_names(n: int) -> list[str]:
    """Return q1..qn."""
    return [f"q{i + 1}" for i in range(n)]


def chain(geometry: np.ndarray, q: np.ndarray, T_base_0: np.ndarray | None = None) -> np.ndarray:
    """Return the frame of the last joint ``(N, 4, 4)``: Rx(alpha) Tx(a) Ry(beta) Rz(q + theta) Tz(d), joint
    after joint.
    """
    T = np.broadcast_to(np.eye(4) if T_base_0 is None else T_base_0, (len(q), 4, 4))
    a, alpha, d, theta, beta = geometry
    for i in range(len(a)):
        before = rotation(0, alpha[i]) @ shift(0, a[i]) @ rotation(1, beta[i])
        T = T @ before @ rotation(2, q[:, i] + theta[i]) @ shift(2, d[i])
    return T


def standard_chain(rows: list[tuple[float, float, float, float]], q: np.ndarray) -> np.ndarray:
    """Return the last frame ``(N, 4, 4)`` of standard DH rows (theta, d, a, alpha): Rz(q + theta) Tz(d)
    Tx(a) Rx(alpha).
    """
    T = np.broadcast_to(np.eye(4), (len(q), 4, 4))
    for i, (theta, d, a, alpha) in enumerate(rows):
        T = T @ rotation(2, q[:, i] + theta) @ shift(2, d) @ shift(0, a) @ rotation(0, alpha)
    return T


@dataclass(frozen=True, eq=False)
class Scene:
    """A dataset with its truth, and how to draw its noise anew without moving anything.

    Attributes:
        dataset: As the calibrator sees it.
        truth: What it does not see.
        clean: The points without noise, as in ``Dataset.points``; for a probe, the distances along the
        normals, all zero.
        noise: One standard deviation [m].
    """

    dataset: Dataset
    truth: Truth
    clean: np.ndarray
    noise: float

    def redraw(self, rng: np.random.Generator) -> Dataset:
        """Return the dataset with another draw of the noise: same poses, same rays. Not for a probe."""
        return replace(self.dataset, points=with_noise(self.clean, self.dataset.sensor, self.noise, rng))

    def mapping(self) -> dict[str, Any]:
        """Return the content of dataset.yaml."""
        sensor: dict[str, Any] = {
            "kind": self.dataset.sensor.kind,
            "error_axis": self.dataset.sensor.error_axis,
        }
        if self.dataset.sensor.noise is not None:
            sensor["noise"] = self.dataset.sensor.noise
        if self.dataset.sensor.T_flange_sensor is not None:
            sensor["nominal_pose"] = pose_mapping(self.dataset.sensor.T_flange_sensor)
        robot = self.dataset.robot
        joints = [
            {
                **{kind: float(robot.geometry[k, i]) for k, kind in enumerate(KINDS)},
                "limits": robot.limits[i].tolist(),
            }
            for i in range(robot.n_joints)
        ]
        mapping: dict[str, Any] = {
            "format": "scalar-dataset/2",
            "name": self.dataset.name,
            "robot": {
                "name": robot.name,
                "convention": "modified-dh",
                "joints": joints,
                "base": pose_mapping(robot.T_base_0),
                "flange": pose_mapping(robot.T_n_flange),
            },
            "sensor": sensor,
        }
        if self.dataset.planes:
            mapping["planes"] = [
                {"name": p.name, "normal": p.normal.tolist(), "distance": float(p.distance)}
                for p in self.dataset.planes
            ]
        return mapping

    def tables(self) -> dict[str, pd.DataFrame]:
        """Return the tables as keywords of ``write_dataset``."""
        data = self.dataset
        tables = {"poses": data.poses}
        if data.sensor.kind == "line-laser":
            ids = np.repeat(data.pose_ids, np.diff(data.starts))
            tables["scans"] = pd.DataFrame({"pose": ids, "x": data.points[:, 0], "z": data.points[:, 1]})
        elif data.sensor.kind == "tracker":
            columns = dict(zip("xyz", data.points.T, strict=True))
            tables["points"] = pd.DataFrame({"pose": data.pose_ids, **columns})
        return tables

    def write(self, folder: Path) -> Path:
        """Write the dataset folder and return its path."""
        write_dataset(folder, mapping=self.mapping(), **self.tables())
        return folder

    def write_truth(self, folder: Path, rng: np.random.Generator, count: int = 500) -> Path:
        """Write the truth folder and return its path."""
        folder.mkdir(parents=True)
        (folder / "truth.json").write_text(json.dumps(self.truth.mapping()), encoding="utf-8")
        self.truth.poses(count, rng).to_csv(folder / "truth_poses.csv", index=False)
        return folder


def pose_mapping(T: np.ndarray) -> dict[str, list[float]]:
    """Return ``{translation, rotation_vector}`` of a transform ``(4, 4)``."""
    return {"translation": T[:3, 3].tolist(), "rotation_vector": rotation_vector(T[:3, :3]).tolist()}


def make_scene(
    robot: str = "vs060",
    kind: str = "line-laser",
    *,
    seed: int = 0,
    poses_per_plane: int = 40,
    points_per_scan: int | tuple[int, int] = 100,
    noise: float = 1e-4,
    stated_noise: float | None = -1.0,
    length_error: float = 2e-3,
    angle_error: float = np.deg2rad(1.0),
    uniform_error: bool = False,
    exact: tuple[str, ...] | None = None,
    plane_tilt: float = 0.0,
    plane_offset: float = 0.0,
    nominal_pose: bool = True,
    pose_offset: tuple[float, float] = (5e-3, np.deg2rad(3.0)),
    error_axis: str = "ray",
    upright: bool = False,
    still_joint: int | None = None,
    target_planes: tuple[np.ndarray, np.ndarray] | None = None,
    T_flange_sensor: np.ndarray = SCANNER,
) -> Scene:
    """Return a random cell: a true robot of the maker's geometry, a nominal one that is a little wrong.

    Args:
        robot: Name in ``configs/robots``.
        kind: Of sensor.
        seed: Of everything.
        poses_per_plane: Poses on each of the three target planes; a tracker sees three times as many.
        points_per_scan: M, or the lowest and highest M.
        noise: One standard deviation [m]: along the ray or z, along the normal of a contact, along each axis
        of a tracker.
        stated_noise: What the dataset says of it; negative: the truth.
        length_error: Of a and d in the nominal robot [m], one standard deviation, or the bound if
        ``uniform_error``.
        angle_error: Of alpha and theta [rad], as ``length_error``.
        uniform_error: Errors uniform within the bounds instead of Gaussian.
        exact: Parameters that the nominal robot has right; by default what planes cannot show.
        plane_tilt: Angle between rough and true normals [rad], about a random axis.
        plane_offset: Error of the rough distances [m], of random sign.
        nominal_pose: Whether the dataset states the sensor's pose.
        pose_offset: How wrong that is: length [m] and angle [rad], in random directions.
        error_axis: ``ray`` or ``z``.
        upright: Target planes exactly level and upright; else tilted by a few degrees.
        still_joint: A joint, from 1, that never moves.
        target_planes: True normals ``(3, 3)`` and distances ``(3,)`` [m], the first seen from above, the others from
        below.
        T_flange_sensor: True pose ``(4, 4)`` of the sensor on the flange.
    """
    rng = np.random.default_rng(seed)
    mapping = robot_mapping(robot)
    joints = mapping["joints"]
    n = len(joints)
    geometry = np.array([[float(joint.get(k, 0.0)) for joint in joints] for k in KINDS])
    limits = np.array([joint["limits"] for joint in joints], dtype=float)
    reach = np.hypot(geometry[0], geometry[2]).sum()
    normals, distances = _target_planes(rng, reach, upright) if target_planes is None else target_planes
    truth = Truth(
        geometry=geometry,
        T_base_0=fixed(mapping.get("base")),
        T_n_flange=fixed(mapping.get("flange")),
        T_flange_sensor=T_flange_sensor,
        limits=limits,
        normals=normals if kind != "tracker" else np.empty((0, 3)),
        distances=distances if kind != "tracker" else np.empty(0),
        T_tracker_base=_random_transform(rng, 2.0, 2.0),
    )
    low, high = points_per_scan if isinstance(points_per_scan, tuple) else (points_per_scan, points_per_scan)
    counts = rng.integers(low, high + 1, size=3 * poses_per_plane)
    index = np.tile(np.arange(3), poses_per_plane)
    still = None if still_joint is None else (still_joint - 1, float(limits[still_joint - 1] @ [0.4, 0.6]))
    if kind == "line-laser":
        q = _scanning_poses(rng, truth, index, still)
        clean, starts = _scan(rng, truth, q, index, counts)
    elif kind == "probe":
        q = _touching_poses(rng, truth, index, noise * rng.standard_normal(len(index)), still)
        clean, starts = np.empty((0, 2)), np.zeros(len(index) + 1, dtype=np.int64)
    else:
        q = _random_poses(rng, limits, len(index), still)
        o = truth.sensor(q)[:, :3, 3]
        clean = o @ truth.T_tracker_base[:3, :3].T + truth.T_tracker_base[:3, 3]
        starts = np.arange(len(index) + 1, dtype=np.int64)

    if exact is None:
        exact = (*HELD[robot], SCALE[robot]) if kind == "probe" else HELD[robot]
    nominal = geometry + _errors(rng, geometry, length_error, angle_error, uniform_error, exact)
    T_nominal = None
    if nominal_pose:
        T_nominal = T_flange_sensor @ _random_transform(rng, *pose_offset)
    sensor = Sensor(
        kind, T_nominal, noise if stated_noise is not None and stated_noise < 0 else stated_noise, error_axis
    )
    poses = pd.DataFrame(q, columns=joint_names(n))
    poses.insert(0, "pose", np.arange(1, len(q) + 1))
    planes: tuple[PlaneGuess, ...] = ()
    if kind != "tracker":
        poses.insert(1, "plane", np.array(PLANE_NAMES, dtype=object)[index])
        guesses = [_tilted(rng, normal, plane_tilt) for normal in normals]
        off = distances + plane_offset * rng.choice([-1.0, 1.0], size=3)
        planes = tuple(PlaneGuess(*entry) for entry in zip(PLANE_NAMES, guesses, off.tolist(), strict=True))
    dataset = Dataset(
        name=f"{robot}-{kind}-{seed}",
        source="tests/helpers.py",
        robot=Robot(robot, nominal, limits, truth.T_base_0, truth.T_n_flange, np.array([0.0, 0.0, -9.81])),
        sensor=sensor,
        planes=planes,
        poses=poses,
        points=with_noise(clean, sensor, noise, rng),
        starts=starts,
    )
    return Scene(dataset, truth, clean, noise)


def with_noise(clean: np.ndarray, sensor: Sensor, noise: float, rng: np.random.Generator) -> np.ndarray:
    """Return points with Gaussian errors along their rays, along z, or (tracker) along each axis."""
    if sensor.kind == "tracker":
        return clean + noise * rng.standard_normal(clean.shape)
    along = np.tile([0.0, 1.0], (len(clean), 1))
    if sensor.error_axis == "ray":
        along = clean / np.linalg.norm(clean, axis=1, keepdims=True)
    return clean + noise * rng.standard_normal((len(clean), 1)) * along


def _target_planes(rng: np.random.Generator, reach: float, upright: bool) -> tuple[np.ndarray, np.ndarray]:
    """Return a floor and two walls, ``(3, 3)`` and ``(3,)`` [m], within the arm's reach."""
    normals = np.array([[0.0, 0, 1], [1.0, 0, 0], [0, 1.0, 0]])
    if not upright:
        normals = np.stack([_tilted(rng, normal, np.deg2rad(rng.uniform(1.0, 6.0))) for normal in normals])
    return normals, np.array([0.0, 0.65 * reach, 0.65 * reach])


def _tilted(rng: np.random.Generator, normal: np.ndarray, angle: float) -> np.ndarray:
    """Return a unit normal turned by an angle about a random axis across it."""
    axis = np.cross(normal, rng.standard_normal(3))
    return rotate_about(axis, angle) @ normal


def _random_transform(rng: np.random.Generator, length: float, angle: float) -> np.ndarray:
    """Return a shift by a length [m] and a turn by an angle [rad], both in random directions."""
    T = np.eye(4)
    direction = rng.standard_normal(3)
    T[:3, 3] = length * direction / np.linalg.norm(direction)
    T[:3, :3] = rotate_about(rng.standard_normal(3), angle)
    return T


def _errors(
    rng: np.random.Generator,
    geometry: np.ndarray,
    length: float,
    angle: float,
    uniform: bool,
    exact: tuple[str, ...],
) -> np.ndarray:
    """Return the errors of a nominal geometry ``(5, n)``: none in beta and in what is exact."""
    unit = rng.uniform(-1.0, 1.0, geometry.shape) if uniform else rng.standard_normal(geometry.shape)
    error = unit * np.array([length, angle, length, angle, 0.0])[:, None]
    for name in exact:
        kind, _, number = name.partition("_")
        error[KINDS.index(kind), int(number) - 1] = 0.0
    return error


def _random_poses(
    rng: np.random.Generator, limits: np.ndarray, count: int, still: tuple[int, float] | None
) -> np.ndarray:
    q = limits[:, 0] + rng.random((count, len(limits))) * np.ptp(limits, axis=1)
    if still is not None:
        q[:, still[0]] = still[1]
    return q


def _ranges(T: np.ndarray, n: np.ndarray, d: Any, angles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the range to a plane along rays at angles ``(..., r)`` from z [rad], and the cosine of
    incidence, ``(..., r)``.
    """
    X, Z, o = T[..., :3, 0], T[..., :3, 2], T[..., :3, 3]
    nX, nZ, no = (np.sum(n * v, axis=-1)[..., None] for v in (X, Z, o))
    along = nX * np.sin(angles) + nZ * np.cos(angles)
    with np.errstate(divide="ignore"):
        return (np.asarray(d)[..., None] - no) / along, np.abs(along)


def _scanning_poses(
    rng: np.random.Generator,
    truth: Truth,
    index: np.ndarray,
    still: tuple[int, float] | None,
    batch: int = 3000,
) -> np.ndarray:
    """Return joint angles ``(N, n)`` at which the whole fan meets the target plane of index ``(N,)``, near enough
    and not grazing.
    """
    found: list[list[np.ndarray]] = [[] for _ in truth.normals]
    wanted = np.bincount(index, minlength=len(truth.normals))
    fan = np.array([-FAN, 0.0, FAN])
    for _ in range(200):
        q = _random_poses(rng, truth.limits, batch, still)
        T = truth.sensor(q)
        for k, (n, d) in enumerate(zip(truth.normals, truth.distances, strict=True)):
            reach, cosine = _ranges(T, n, np.full(len(q), d), fan)
            inside = (T[:, :3, 3] @ n > d) == (k == 0)
            good = inside & np.all((reach > STANDOFF[0]) & (reach < STANDOFF[1]) & (cosine > GRAZING), axis=1)
            found[k].extend(q[good])
        if all(len(f) >= w for f, w in zip(found, wanted, strict=True)):
            break
    else:
        raise AssertionError("no poses found: the target planes are out of the arm's reach")
    poses = np.empty((len(index), len(truth.limits)))
    for k in range(len(truth.normals)):
        poses[index == k] = found[k][: wanted[k]]
    return poses


def _scan(
    rng: np.random.Generator, truth: Truth, q: np.ndarray, index: np.ndarray, counts: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return perfect points ``(P, 2)`` [m] of rays spread over the fan, and where each scan begins ``(N +
    1,)``.
    """
    starts = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
    owner = np.repeat(np.arange(len(q)), counts)
    angles = rng.uniform(-FAN, FAN, size=(len(owner), 1))
    T = truth.sensor(q)[owner]
    reach, _ = _ranges(T, truth.normals[index[owner]], truth.distances[index[owner]], angles)
    return np.column_stack([reach * np.sin(angles), reach * np.cos(angles)]), starts


def _touching_poses(
    rng: np.random.Generator,
    truth: Truth,
    index: np.ndarray,
    gap: np.ndarray,
    still: tuple[int, float] | None,
) -> np.ndarray:
    """Return joint angles ``(N, n)`` at which ``n . o - d`` is the given gap ``(N,)`` [m].

    The height over a plane is ``A + B cos q_j + C sin q_j`` in any one joint: three heights give A, B, C, and
    the angle follows.
    """
    movable = [j for j in (1, 2, 3) if still is None or j != still[0]]
    poses = np.empty((len(index), len(truth.limits)))
    todo = np.arange(len(index))
    for _ in range(200):
        tried = np.resize(todo, max(len(todo), 300))
        q = _random_poses(rng, truth.limits, len(tried), still)
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
