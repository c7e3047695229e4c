"""Make a random workcell and measure in it: the true robot has the maker's geometry, the nominal one is a little wrong.

A second opinion on ``scalar``: kinematics, rays and contacts are the tests' own. Of ``scalar`` it uses the plain containers ``Dataset``,
``Robot``, ``Sensor`` and ``PlaneGuess``. Left out: collisions, and the edges of target planes.
"""

from __future__ import annotations

import numpy as np
import pandas as pd

from scalar.data.dataset import Dataset
from scalar.data.declared import PlaneGuess, Sensor
from scalar.geometry.robot import Robot
from tests.kinematics import PARAMETER_KINDS, joint_names, random_transform, rotate_about, transform
from tests.measuring_poses import random_poses, scan, scanning_poses, touching_poses
from tests.robot_configs import FIXED_WITH_PLANES, FIXED_WITH_PROBE, robot_mapping
from tests.workcell import PLANE_NAMES, Scene, Truth, with_noise

SCANNER = np.array([[-1.0, 0, 0, -0.1275], [0, -1.0, 0, -0.033], [0, 0, 1.0, 0.1015], [0, 0, 0, 1.0]])
"""``T_flange_sensor`` of the original paper's scanner: half a turn about z."""


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
    """Return a dataset that was measured in a random workcell, with its truth.

    Args:
        robot: Name in ``configs/robots``.
        kind: Of the sensor: ``line-laser``, ``probe`` or ``tracker``.
        seed: Of all that is drawn.
        poses_per_plane: Poses on each of the three target planes; a tracker sees three times as many.
        points_per_scan: One number for all scans, or the bounds between which it is drawn.
        noise: Standard deviation [m]: along the ray or z, along the normal of a contact, along each axis
        of a tracker.
        stated_noise: The noise that the dataset states [m]; None: it states none; negative: it states the true one.
        length_error: Of a and d in the nominal robot [m]: the standard deviation, or the bound if
        ``uniform_error``.
        angle_error: Of alpha and theta [rad], as ``length_error``.
        uniform_error: Errors uniform within the bounds instead of Gaussian.
        exact: Parameters that the nominal robot has right; by default those that the data do not determine.
        plane_tilt: Angle between guessed and true normals [rad], about a random axis.
        plane_offset: Error of the guessed distances [m], of random sign.
        nominal_pose: Whether the dataset states the sensor's pose.
        pose_offset: Error of the stated pose: length [m] and angle [rad], in random directions.
        error_axis: ``ray`` or ``z``.
        upright: Whether the floor is exactly level and the walls exactly upright; else all are tilted by a few degrees.
        still_joint: A joint, from 1, that never moves.
        target_planes: True normals ``(3, 3)`` and distances ``(3,)`` [m], the first seen from above, the others from
        below.
        T_flange_sensor: True pose ``(4, 4)`` of the sensor on the flange.
    """
    rng = np.random.default_rng(seed)
    mapping = robot_mapping(robot)
    joints = mapping["joints"]
    n = len(joints)
    geometry = np.array([[float(joint.get(k, 0.0)) for joint in joints] for k in PARAMETER_KINDS])
    limits = np.array([joint["limits"] for joint in joints], dtype=float)
    reach = np.hypot(geometry[0], geometry[2]).sum()
    normals, distances = _target_planes(rng, reach, upright) if target_planes is None else target_planes
    truth = Truth(
        geometry=geometry,
        T_base_0=transform(mapping.get("base")),
        T_n_flange=transform(mapping.get("flange")),
        T_flange_sensor=T_flange_sensor,
        limits=limits,
        normals=normals if kind != "tracker" else np.empty((0, 3)),
        distances=distances if kind != "tracker" else np.empty(0),
        T_tracker_base=random_transform(rng, 2.0, 2.0),
    )
    low, high = points_per_scan if isinstance(points_per_scan, tuple) else (points_per_scan, points_per_scan)
    counts = rng.integers(low, high + 1, size=3 * poses_per_plane)
    index = np.tile(np.arange(3), poses_per_plane)
    still = None if still_joint is None else (still_joint - 1, float(limits[still_joint - 1] @ [0.4, 0.6]))
    q, clean, starts = _measured(rng, truth, kind, index, counts, still, noise)

    if exact is None:
        exact = FIXED_WITH_PLANES[robot]
        if kind == "probe":
            exact = (*exact, FIXED_WITH_PROBE[robot])
    nominal = geometry + _errors(rng, geometry, length_error, angle_error, uniform_error, exact)
    T_nominal = T_flange_sensor @ random_transform(rng, *pose_offset) if nominal_pose else None
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
        source="tests/random_scene.py",
        robot=Robot(robot, nominal, limits, truth.T_base_0, truth.T_n_flange, np.array([0.0, 0.0, -9.81])),
        sensor=sensor,
        planes=planes,
        poses=poses,
        points=with_noise(clean, sensor, noise, rng),
        starts=starts,
    )
    return Scene(dataset, truth, clean, noise)


def _measured(
    rng: np.random.Generator,
    truth: Truth,
    kind: str,
    index: np.ndarray,
    counts: np.ndarray,
    still: tuple[int, float] | None,
    noise: float,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return joint angles ``(N, n)`` [rad], what a sensor would measure there without noise [m], and where the points of each pose start.

    Args:
        rng: Draws the poses.
        truth: The workcell.
        kind: Of the sensor.
        index: ``(N,)``, the target plane of each pose.
        counts: ``(N,)``, the number of points of each scan.
        still: A joint that never moves, with its angle [rad]; or None.
        noise: Of a contact, along the normal [m].
    """
    one_each = np.arange(len(index) + 1, dtype=np.int64)
    if kind == "line-laser":
        q = scanning_poses(rng, truth, index, still)
        return q, *scan(rng, truth, q, index, counts)
    if kind == "probe":
        q = touching_poses(rng, truth, index, noise * rng.standard_normal(len(index)), still)
        return q, np.empty((0, 2)), np.zeros_like(one_each)
    q = random_poses(rng, truth.limits, len(index), still)
    o = truth.sensor(q)[:, :3, 3]
    return q, o @ truth.T_tracker_base[:3, :3].T + truth.T_tracker_base[:3, 3], one_each


def _target_planes(rng: np.random.Generator, reach: float, upright: bool) -> tuple[np.ndarray, np.ndarray]:
    """Return the normals ``(3, 3)`` and distances ``(3,)`` [m] of a floor and two walls within the arm's reach [m]."""
    normals = np.array([[0.0, 0, 1], [1.0, 0, 0], [0, 1.0, 0]])
    if not upright:
        normals = np.stack([_tilted(rng, normal, np.deg2rad(rng.uniform(1.0, 6.0))) for normal in normals])
    return normals, np.array([0.0, 0.65 * reach, 0.65 * reach])


def _tilted(rng: np.random.Generator, normal: np.ndarray, angle: float) -> np.ndarray:
    """Return a unit normal ``(3,)`` turned by an angle [rad] about a random axis at right angles to it."""
    axis = np.cross(normal, rng.standard_normal(3))
    return rotate_about(axis, angle) @ normal


def _errors(
    rng: np.random.Generator,
    geometry: np.ndarray,
    length: float,
    angle: float,
    uniform: bool,
    exact: tuple[str, ...],
) -> np.ndarray:
    """Return the errors of a nominal geometry ``(5, n)`` [m, rad]: none in beta and in the parameters named as exact."""
    unit = rng.uniform(-1.0, 1.0, geometry.shape) if uniform else rng.standard_normal(geometry.shape)
    error = unit * np.array([length, angle, length, angle, 0.0])[:, None]
    for name in exact:
        kind, _, number = name.partition("_")
        error[PARAMETER_KINDS.index(kind), int(number) - 1] = 0.0
    return error
