"""Draw candidate poses: within the joint limits, where the sensor measures, on the arm's side of the planes, and free of collisions.

Joint angles are drawn at random. A scanner has to see its plane over the whole fan, within its range and incidence, and within the extent of the
target plane if that is stated, with no other plane in between; a sensor that measures by touch is moved until it touches its plane
(``contact_step``). Joints and sensor stay on the arm's side of every plane. The caller supplies the test for collisions, from a physics engine if
there is one.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from scalar.errors import Fault, InvalidInput
from scalar.geometry.se3 import Array
from scalar.planning.workcell import Workcell, scan_points
from scalar.sensors import kind_named, measure

Allowed = Callable[[Array], Array]
"""Takes joint angles ``(N, n)`` [rad] and returns which of them touch nothing, ``(N,)`` bool."""

_BATCH = 2048
_BATCHES = 200  # chosen: 400,000 draws; a plane that is rarely seen in so many can hardly be measured
_CLEARANCE = 0.02  # m, least distance of joints and sensor from the planes
_BASE_FRAMES = 2  # the first frames of an arm stand at its base, and may be on the floor
_LEAST_SHARE = 0.1  # least share of the wanted candidates that a plane has to have: with fewer there is nothing to choose from


@dataclass(frozen=True, eq=False)
class Candidates:
    """Poses from which a plan is chosen.

    Attributes:
        q: ``(N, n)`` [rad].
        plane: ``(N,)``, index of the plane that each measures; -1 without planes.
    """

    q: Array
    plane: Array


def draw_candidates(
    workcell: Workcell,
    count: int,
    rng: np.random.Generator,
    allowed: Allowed | None = None,
    *,
    one_turn: bool = False,
) -> Candidates:
    """Return candidate poses, equally many for each plane.

    Args:
        workcell: The workcell.
        count: Number of poses, over all planes.
        rng: Draws them.
        allowed: Says which joint angles touch nothing; None if collisions are not tested.
        one_turn: Whether joints with limits wider than a turn stay within one turn, which gives the same postures by shorter moves.

    Raises:
        InvalidInput: A plane cannot be measured from enough poses, or too few poses touch nothing.
    """
    items = range(len(workcell.planes)) if workcell.on_planes else [-1]
    share = -(-count // len(items))
    found = [_poses_for_plane(workcell, k, share, rng, allowed, one_turn) for k in items]
    for k, q in zip(items, found, strict=True):
        if len(q) < _LEAST_SHARE * share:
            raise InvalidInput(_too_few(workcell, k, len(q)))
    plane = np.concatenate([np.full(len(q), k) for k, q in zip(items, found, strict=True)])
    return Candidates(np.concatenate(found), plane)


def _poses_for_plane(
    workcell: Workcell,
    k: int,
    wanted: int,
    rng: np.random.Generator,
    allowed: Allowed | None,
    one_turn: bool,
) -> Array:
    """Return up to ``wanted`` poses ``(K, n)`` [rad] that measure the plane with index k, or that have no plane to measure if k is -1."""
    nominal = workcell.model.nominal
    low, high = (_one_turn(nominal.limits, nominal.prismatic) if one_turn else nominal.limits).T
    kept: list[Array] = []
    total = 0
    for _ in range(_BATCHES):
        q = rng.uniform(low, high, (_BATCH, len(low)))
        q = _measurable(workcell, q, k)
        q = q[np.all((q >= low) & (q <= high), axis=1)]
        q = q[_inside(workcell, q, k)]
        q = q[: 2 * (wanted - total)]  # the test for contact is the slow one
        if allowed is not None and len(q):
            q = q[allowed(q)]
        kept.append(q[: wanted - total])
        total += len(kept[-1])
        if total >= wanted:
            break
    return np.concatenate(kept)


def _one_turn(limits: Array, prismatic: Sequence[int]) -> Array:
    """Return the limits ``(n, 2)`` [rad; m where a joint slides], those of joints that turn cut to one turn about their middle."""
    middle = limits.mean(axis=1, keepdims=True)
    half = np.full_like(middle, np.pi)
    half[list(prismatic)] = np.inf
    return np.clip(limits, middle - half, middle + half)


def _measurable(workcell: Workcell, q: Array, k: int) -> Array:
    """Return the poses in which the sensor measures plane k; one that measures by touch is first moved until it touches the plane."""
    if k < 0:
        return q
    kind = kind_named(workcell.sensor.kind)
    if kind.scans:
        return q[_sees(workcell, workcell.sensor_frames(q), k)]
    index = np.full(len(q), k)
    robot = workcell.model.robot
    dataset = workcell.dataset(q, index)
    measurement = measure(dataset)
    target, which = measurement.initial_target(dataset), np.zeros(len(q), dtype=int)
    for _ in range(kind.contact_iterations):
        frames = robot.frames(q)
        T = frames[:, -1] @ robot.T_n_flange @ workcell.model.T_flange_sensor
        q = q + measurement.contact_step(T, target, which, robot.screws(frames)[:, :, robot.joint_columns])
    frames = workcell.sensor_frames(q)
    return q[measurement.perfect_rows(frames, target, which)[2] & workcell.covered(k, frames[:, :3, 3])]


def _sees(workcell: Workcell, T: Array, k: int) -> Array:
    """Return in which of the frames T ``(N, 4, 4)`` a scanner sees plane k over its whole fan, ``(N,)`` bool."""
    view = workcell.view
    N = len(T)

    def scan(item: int) -> tuple[Array, Array, Array]:
        normals = np.broadcast_to(workcell.normals[item], (N, 3))
        return scan_points(T, normals, np.full(N, workcell.distances[item]), view)

    points, reach, cosine = scan(k)
    good = (reach >= view.near) & (reach <= view.far) & (cosine >= np.cos(view.incidence))
    good &= workcell.covered(k, T[:, None, :3, 3] + points @ T[:, :3, [0, 2]].transpose(0, 2, 1))
    for other in range(len(workcell.planes)):
        if other != k:
            at, between, _ = scan(other)
            passes = (between <= 0) | (between > reach)
            if workcell.ends(other):
                passes |= ~workcell.covered(
                    other, T[:, None, :3, 3] + at @ T[:, :3, [0, 2]].transpose(0, 2, 1)
                )
            good &= passes
    return np.all(good, axis=1)


def _inside(workcell: Workcell, q: Array, k: int) -> Array:
    """Return which poses keep joints and sensor on the arm's side of every plane ``(N,)`` bool; of one that ends, where they face it."""
    if not len(q) or not workcell.on_planes:
        return np.ones(len(q), dtype=bool)
    robot = workcell.model.robot
    low, high = robot.limits.T
    random_frames = robot.frames(np.random.default_rng(0).uniform(low, high, (_BATCH // 8, robot.n_joints)))
    middle = random_frames[:, _BASE_FRAMES:, :3, 3].mean(axis=(0, 1))
    side = np.sign(workcell.normals @ middle - workcell.distances)
    frames = robot.frames(q)[:, _BASE_FRAMES:]
    sensor = workcell.sensor_frames(q)[:, None]
    keep = np.ones(len(q), dtype=bool)
    for item, (normal, distance) in enumerate(zip(workcell.normals, workcell.distances, strict=True)):
        parts = frames if workcell.touches_planes and item == k else np.concatenate([frames, sensor], axis=1)
        height = (parts[..., :3, 3] @ normal - distance) * side[item]
        beside = ~workcell.covered(item, parts[..., :3, 3]) if workcell.ends(item) else np.False_
        keep &= np.all((height > _CLEARANCE) | beside, axis=1)
    return keep


def _too_few(workcell: Workcell, k: int, found: int) -> Fault:
    """Return the fault that plane k can be measured from too few random poses."""
    drawn = _BATCH * _BATCHES
    if k < 0:
        message = f"only {found} of {drawn} random poses within the joint limits touch nothing; check robot.joints and its limits"
        return Fault("dataset.yaml", message, None, "robot.joints")
    name = workcell.planes[k].name
    place = "its place" if workcell.planes[k].radius is None else "its place, its extent"
    message = (
        f"the sensor sees the plane '{name}' from {found} of {drawn} random poses; check {place} and sensor.nominal_pose, "
        "move it, or give what the scanner sees by --range, --fan and --incidence"
    )
    return Fault("dataset.yaml", message, None, f"planes[{k}]")
