"""Cells with one thing wrong, of the sizes that real arms have, and what a diagnosis ought to say of each."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from scalar.data.dataset import Dataset
from tests import kinematics
from tests.effects.injected import BETA, A, Cell, D, Flaws, Moment, make_cell, on_joint, sag
from tests.kinematics import joint_names
from tests.random_scene import make_scene
from tests.workcell import PLANE_NAMES

Case = Callable[[int], tuple[Cell, str, dict[str, Any]]]
"""From a seed: the cell, the name of the effect, and what its target has to say."""

WARMING = 6.0  # K over a run
GROWTH = 5e-4  # of all lengths over a run


def approaches(rng: np.random.Generator, n_poses: int, n_joints: int) -> dict[str, np.ndarray]:
    """Return the directions from which the joints arrived."""
    return {f"approach{j + 1}": rng.choice([-1.0, 1.0], n_poses) for j in range(n_joints)}


def warming(rng: np.random.Generator, n_poses: int, n_joints: int) -> dict[str, np.ndarray]:
    """Return time and a temperature that rises by ``WARMING``."""
    time = np.cumsum(rng.uniform(8.0, 12.0, n_poses))
    return {"time": time, "temperature": 20.0 + WARMING * time / time[-1]}


def draw(seed: int) -> np.random.Generator:
    """Return the generator of a case's own choices."""
    return np.random.default_rng([seed, 4711])


def compliance(seed: int, **settings: Any) -> tuple[Cell, str, dict[str, Any]]:
    """Joints that give 1e-5 rad/(N m) under the arm's weight."""
    truth = make_cell(seed=seed, poses_per_plane=3, **settings).scene.truth
    flaws = Flaws(joints=sag(truth, np.full(truth.geometry.shape[1], 1e-5), draw(seed)))
    return make_cell(flaws, seed=seed, **settings), "joint_compliance", {}


def harmonic(
    seed: int, orders: tuple[int, int] = (1, 33), **settings: Any
) -> tuple[Cell, str, dict[str, Any]]:
    """A gear error of 3e-4 rad of any order in any joint but the last."""
    rng = draw(seed)
    j, k, phase = int(rng.integers(1, 6)), int(rng.integers(*orders)), rng.uniform(0, 2 * np.pi)
    error = on_joint(j, lambda at: 3e-4 * np.sin(k * at.q[:, j - 1] + phase))
    return make_cell(Flaws(joints=error), seed=seed, **settings), "joint_harmonic", {"joint": j, "order": k}


def scale(seed: int, **settings: Any) -> tuple[Cell, str, dict[str, Any]]:
    """An angle that is 1e-3 too long in any joint but the last."""
    j = int(draw(seed).integers(1, 6))
    error = on_joint(j, lambda at: 1e-3 * at.q[:, j - 1])
    return make_cell(Flaws(joints=error), seed=seed, **settings), "joint_scale", {"joint": j}


def coupling(seed: int, **settings: Any) -> tuple[Cell, str, dict[str, Any]]:
    """1e-3 of one joint's angle in another's."""
    j, s = [(6, 5), (5, 4), (3, 2), (6, 4)][int(draw(seed).integers(4))]
    error = on_joint(j, lambda at: 1e-3 * at.q[:, s - 1])
    return make_cell(Flaws(joints=error), seed=seed, **settings), "joint_coupling", {"joint": j, "source": s}


def backlash(seed: int, **settings: Any) -> tuple[Cell, str, dict[str, Any]]:
    """A play of twice 3e-4 rad, the direction of approach recorded."""
    j = int(draw(seed).integers(1, 6))
    error = on_joint(j, lambda at: 3e-4 * at.columns[f"approach{j}"])
    cell = make_cell(Flaws(joints=error), seed=seed, columns=approaches, **settings)
    return cell, "joint_backlash", {"joint": j}


def nonparallel(seed: int, **settings: Any) -> tuple[Cell, str, dict[str, Any]]:
    """2e-3 rad between the near-parallel axes of joints 2 and 3."""
    geometry = np.zeros((5, 6))
    geometry[BETA, 2] = 2e-3
    flaws = Flaws(geometry=lambda at: np.broadcast_to(geometry, (len(at.q), 5, 6)))
    return make_cell(flaws, seed=seed, **settings), "axis_nonparallel", {"joint": 3}


def pedestal(seed: int, **settings: Any) -> tuple[Cell, str, dict[str, Any]]:
    """A base that tilts by 4e-6 rad/(N m) under masses at the ends of the links."""
    truth = make_cell(seed=seed, poses_per_plane=3, **settings).scene.truth
    masses = np.linspace(9.0, 1.0, truth.geometry.shape[1])

    def tilt(at: Moment) -> np.ndarray:
        moment = np.zeros((len(at.q), 3))
        for i in range(1, len(masses)):
            ends = kinematics.chain(truth.geometry[:, : i + 1], at.q[:, : i + 1], truth.T_base_0)[:, :3, 3]
            moment += masses[i] * np.cross(ends, [0.0, 0.0, -9.81])
        w = 4e-6 * moment
        T = np.tile(np.eye(4), (len(w), 1, 1))
        T[:, :3, :3] += np.cross(np.eye(3)[None], w[:, None, :])  # to first order: 1e-7
        return T

    return make_cell(Flaws(base=tilt), seed=seed, **settings), "base_compliance", {}


def drift(seed: int, **settings: Any) -> tuple[Cell, str, dict[str, Any]]:
    """Lengths that grow by 5e-4 with the temperature, which is recorded."""
    truth = make_cell(seed=seed, poses_per_plane=3, **settings).scene.truth
    lengths = np.zeros_like(truth.geometry)
    lengths[[A, D]] = truth.geometry[[A, D]]

    def growth(at: Moment) -> np.ndarray:
        return GROWTH / WARMING * (at.columns["temperature"] - 20.0)[:, None, None] * lengths

    return make_cell(Flaws(geometry=growth), seed=seed, columns=warming, **settings), "thermal_drift", {}


def slip(seed: int, **settings: Any) -> tuple[Cell, str, dict[str, Any]]:
    """A sensor that shifts by 0.5 mm in the middle of the run."""
    rng = draw(seed)
    motion = np.eye(4)
    motion[:3, 3] = 5e-4 * unit(rng)
    n = 3 * settings.get("poses_per_plane", 60)
    first = float(rng.integers(n // 4, 3 * n // 4))
    return make_cell(Flaws(slip=(first, motion)), seed=seed, **settings), "sensor_slip", {"order": first}


def distortion(seed: int, **settings: Any) -> tuple[Cell, str, dict[str, Any]]:
    """A range that is curved by 0.01 /m, a third of a millimetre at its ends."""
    flaws = Flaws(measured=lambda r: r + 0.01 * (r - 0.25) ** 2)
    return make_cell(flaws, seed=seed, **settings), "range_distortion", {}


def offset(seed: int, **settings: Any) -> tuple[Cell, str, dict[str, Any]]:
    """A range that is 0.5 mm short."""
    return make_cell(Flaws(measured=lambda r: r - 5e-4), seed=seed, **settings), "range_offset", {}


def bow(seed: int, **settings: Any) -> tuple[Cell, str, dict[str, Any]]:
    """A target plane that is 0.5 mm higher half a metre from its middle."""
    target_plane = PLANE_NAMES[int(draw(seed).integers(3))]
    return (
        make_cell(Flaws(bent={target_plane: (2e-3, 0.0, 2e-3)}), seed=seed, **settings),
        "plane_bow",
        {"plane": target_plane},
    )


def knock(seed: int, **settings: Any) -> tuple[Cell, str, dict[str, Any]]:
    """A target plane that moves by 0.5 mm in the middle of the run."""
    rng = draw(seed)
    target_plane = PLANE_NAMES[int(rng.integers(3))]
    n = 3 * settings.get("poses_per_plane", 60)
    first = float(rng.integers(n // 4, 3 * n // 4))
    flaws = Flaws(moved={target_plane: (first, 5e-4, (0.0, 0.0))})
    return make_cell(flaws, seed=seed, **settings), "plane_moved", {"plane": target_plane, "order": first}


def jitter(seed: int, **settings: Any) -> tuple[Cell, str, dict[str, Any]]:
    """Joints that repeat to 2e-4 rad."""
    return make_cell(Flaws(jitter=2e-4), seed=seed, **settings), "pose_jitter", {}


def bias(seed: int, **settings: Any) -> tuple[Cell, str, dict[str, Any]]:
    """Scans with an error of 0.2 mm each."""
    return make_cell(Flaws(bias=2e-4), seed=seed, **settings), "scan_bias", {}


def unnamed(seed: int, **settings: Any) -> tuple[Cell, str, dict[str, Any]]:
    """Joint 3 errs with the product of two other joints' angles, as no effect of the catalogue does."""
    error = on_joint(3, lambda at: 5e-4 * np.sin(at.q[:, 1] * at.q[:, 4]))
    return make_cell(Flaws(joints=error), seed=seed, **settings), "unattributed", {"depends_on": {"q2", "q5"}}


def own_curve(seed: int, curve: Callable[[np.ndarray, np.random.Generator], np.ndarray]) -> Flaws:
    """A joint that errs along its own angle by what is neither its gear's nor in proportion."""
    rng = draw(seed)
    j = int(rng.integers(1, 6))
    state = rng.bit_generator.state

    def error(at: Moment) -> np.ndarray:
        again = np.random.default_rng()
        again.bit_generator.state = state
        return curve(at.q[:, j - 1], again)

    return Flaws(joints=on_joint(j, error))


def worn_teeth(q: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """4e-4 rad over a quarter of a radian, with flanks of another quarter."""
    return 4e-4 * np.clip(1.5 - np.abs(q - rng.uniform(-0.5, 0.5)) / 0.25, 0.0, 1.0)


def lost_count(q: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """3e-4 rad beyond one angle."""
    return 3e-4 * (q > rng.uniform(-0.4, 0.4))


def bent_scale(q: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """6e-4 rad a radian, the sign of which turns at one angle."""
    return 6e-4 * np.abs(q - rng.uniform(-0.4, 0.4))


def belt(q: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """A sawtooth of 6e-4 rad whose period is no whole part of a turn."""
    period = rng.uniform(0.5, 1.0)
    return 6e-4 * (np.mod(q, period) / period - 0.5)


def late_jump(seed: int) -> Flaws:
    """A joint that is 5e-4 rad off from a moment on."""
    rng = draw(seed)
    j, share = int(rng.integers(2, 6)), rng.uniform(0.3, 0.7)
    return Flaws(
        joints=on_joint(j, lambda at: 5e-4 * (at.columns["time"] > share * at.columns["time"].max()))
    )


def swaying_floor(seed: int) -> Flaws:
    """A base that sways by 0.3 mm some times in a run."""
    rng = draw(seed)
    way, periods = 3e-4 * unit(rng), rng.uniform(2.0, 6.0)

    def sway(at: Moment) -> np.ndarray:
        T = np.tile(np.eye(4), (len(at.q), 1, 1))
        share = at.columns["time"] / at.columns["time"].max()
        T[:, :3, 3] = np.sin(2 * np.pi * periods * share + 1.0)[:, None] * way
        return T

    return Flaws(base=sway)


UNNAMED: dict[str, Callable[[int], Flaws]] = {
    "worn teeth": lambda seed: own_curve(seed, worn_teeth),
    "lost count": lambda seed: own_curve(seed, lost_count),
    "bent scale": lambda seed: own_curve(seed, bent_scale),
    "belt": lambda seed: own_curve(seed, belt),
    "late jump": late_jump,
    "swaying floor": swaying_floor,
}

NAMED: dict[str, Case] = {
    "compliance": compliance,
    "harmonic": harmonic,
    "scale": scale,
    "coupling": coupling,
    "backlash": backlash,
    "nonparallel": nonparallel,
    "pedestal": pedestal,
    "drift": drift,
    "slip": slip,
    "distortion": distortion,
    "bow": bow,
    "knock": knock,
    "jitter": jitter,
    "bias": bias,
}


def unit(rng: np.random.Generator) -> np.ndarray:
    """Return a random direction ``(3,)``."""
    v = rng.standard_normal(3)
    return v / np.linalg.norm(v)


def spoiled(
    dataset: Dataset,
    rng: np.random.Generator,
    *,
    points: float = 0.0,
    poses: float = 0.0,
    labels: float = 0.0,
) -> tuple[Dataset, dict[str, Any]]:
    """Return a dataset with gross errors, and what they are.

    Args:
        dataset: Without.
        rng: Chooses.
        points: Share of the points that are off by 2 to 30 mm along their rays.
        poses: Share of the poses whose joint angles belong to no scan of theirs.
        labels: Share of the poses that name another target plane.
    """
    cloud, frame = dataset.points.copy(), dataset.poses.copy()
    N = dataset.n_poses
    corrupted = rng.choice(N, round((poses + labels) * N), replace=False)
    wrong_poses, wrong_labels = np.split(corrupted, [round(poses * N)])
    stray = np.flatnonzero(rng.random(len(cloud)) < points)
    r = np.linalg.norm(cloud[stray], axis=1, keepdims=True)
    away = rng.uniform(2e-3, 3e-2, (len(stray), 1)) * rng.choice([-1.0, 1.0], (len(stray), 1))
    cloud[stray] *= 1 + away / r
    joints = joint_names(dataset.q.shape[1])
    angles = frame[joints].to_numpy(copy=True)
    angles[wrong_poses] += rng.uniform(0.05, 0.5, (len(wrong_poses), angles.shape[1]))
    frame[joints] = angles
    names = [plane.name for plane in dataset.planes]
    plane = frame["plane"].to_numpy(dtype=object).copy()
    for i in wrong_labels:
        plane[i] = rng.choice([name for name in names if name != plane[i]])
    frame["plane"] = plane
    ids = dataset.pose_ids
    injected = {
        "poses": set(ids[wrong_poses].tolist()),
        "labels": set(ids[wrong_labels].tolist()),
        "points": stray,
    }
    return replace(dataset, points=cloud, poses=frame), injected


def judged(effects: list[dict[str, Any]], name: str, target: dict[str, Any], slack: int = 6) -> bool:
    """Return whether the first effect is the right one: joint, order, target plane, and the moment nearly."""
    if not effects or effects[0]["name"] != name:
        return False
    found = effects[0]["target"]
    for key, value in target.items():
        if key == "order" and "at" in found:
            if abs(found["at"]["order"] - value) > slack:
                return False
        elif key == "order" and "orders" in found:
            if value not in found["orders"]:
                return False
        elif key == "depends_on":
            if not value <= set(effects[0]["depends_on"]):
                return False
        elif found.get(key) != value:
            return False
    return True


TRACKER_NOISE = 2e-5  # m
BUMP_WIDTH = 0.12  # rad
BUMP_SIZE = 4e-4  # rad
BUMPY_JOINTS = (2, 3)  # joints, from 1


def bumps(seed):
    """Return the error [rad] of a joint at angles [rad]: a landscape of bumps, periodic in nothing."""
    rng = np.random.default_rng(seed)
    centres = np.arange(-7.0, 7.0, BUMP_WIDTH)
    heights = BUMP_SIZE * rng.standard_normal(len(centres))
    return lambda x: np.exp(-(((x[:, None] - centres) / BUMP_WIDTH) ** 2)) @ heights


def bumpy(seed, poses_per_plane=700, erring=BUMPY_JOINTS, landscape=None):
    """Return a tracked arm of which some joints err: it stood at q, its encoders read e with ``e + error(e) = q``.

    Args:
        seed: Of the cell. poses_per_plane: A third of the poses.
        erring: Joints, from 1. landscape: Seed of the errors, that of the cell by default.
    """
    scene = make_scene(kind="tracker", seed=seed, poses_per_plane=poses_per_plane, noise=TRACKER_NOISE)
    read = scene.dataset.q.copy()
    for joint in erring:
        error, stood = (
            bumps(100 * (seed if landscape is None else landscape) + joint),
            read[:, joint - 1].copy(),
        )
        for _ in range(20):
            read[:, joint - 1] = stood - error(read[:, joint - 1])
    columns = {f"q{j}": read[:, j - 1] for j in erring}
    return replace(scene.dataset, poses=scene.dataset.poses.assign(**columns))
