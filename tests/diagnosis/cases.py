"""Workcells with one named effect each, of the size that real arms have, and the answer that a diagnosis ought to give for each."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from tests import kinematics
from tests.effects.injected import BETA, A, Cell, D, Flaws, PoseData, make_cell, on_joint, sag
from tests.workcell import PLANE_NAMES

Case = Callable[[int], tuple[Cell, str, dict[str, Any]]]
"""From a seed: the workcell, the name of the effect, and what its target has to say."""

WARMING = 6.0  # K over a run

GROWTH = 5e-4  # of all lengths over a run


def approaches(rng: np.random.Generator, n_poses: int, n_joints: int) -> dict[str, np.ndarray]:
    """Return the directions from which the joints arrived, -1 or 1."""
    return {f"approach{j + 1}": rng.choice([-1.0, 1.0], n_poses) for j in range(n_joints)}


def warming(rng: np.random.Generator, n_poses: int, n_joints: int) -> dict[str, np.ndarray]:
    """Return columns with a time and a temperature that rises by ``WARMING``."""
    time = np.cumsum(rng.uniform(8.0, 12.0, n_poses))
    return {"time": time, "temperature": 20.0 + WARMING * time / time[-1]}


def in_order(rng: np.random.Generator, n_poses: int, n_joints: int) -> dict[str, np.ndarray]:
    """Return the column that states that the rows are in the order of acquisition."""
    return {"order": np.arange(float(n_poses))}


def draw(seed: int) -> np.random.Generator:
    """Return the random generator from which a case draws joints, orders and sizes."""
    return np.random.default_rng([seed, 4711])


def unit(rng: np.random.Generator) -> np.ndarray:
    """Return a random direction ``(3,)``."""
    v = rng.standard_normal(3)
    return v / np.linalg.norm(v)


def compliance(seed: int, **settings: Any) -> tuple[Cell, str, dict[str, Any]]:
    """Joints that are deflected by 1e-5 rad/(N m) under the arm's weight."""
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
    """A joint's angle whose scale is wrong by 1e-3, in any joint but the last."""
    j = int(draw(seed).integers(1, 6))
    error = on_joint(j, lambda at: 1e-3 * at.q[:, j - 1])
    return make_cell(Flaws(joints=error), seed=seed, **settings), "joint_scale", {"joint": j}


def coupling(seed: int, **settings: Any) -> tuple[Cell, str, dict[str, Any]]:
    """A coupling by which 1e-3 of one joint's angle adds to another's."""
    j, s = [(6, 5), (5, 4), (3, 2), (6, 4)][int(draw(seed).integers(4))]
    error = on_joint(j, lambda at: 1e-3 * at.q[:, s - 1])
    return make_cell(Flaws(joints=error), seed=seed, **settings), "joint_coupling", {"joint": j, "source": s}


def backlash(seed: int, **settings: Any) -> tuple[Cell, str, dict[str, Any]]:
    """A backlash of twice 3e-4 rad; the direction of approach is recorded."""
    j = int(draw(seed).integers(1, 6))
    error = on_joint(j, lambda at: 3e-4 * at.columns[f"approach{j}"])
    cell = make_cell(Flaws(joints=error), seed=seed, columns=approaches, **settings)
    return cell, "joint_backlash", {"joint": j}


def nonparallel(seed: int, **settings: Any) -> tuple[Cell, str, dict[str, Any]]:
    """An angle of 2e-3 rad between the near-parallel axes of joints 2 and 3."""
    geometry = np.zeros((5, 6))
    geometry[BETA, 2] = 2e-3
    flaws = Flaws(geometry=lambda at: np.broadcast_to(geometry, (len(at.q), 5, 6)))
    return make_cell(flaws, seed=seed, **settings), "axis_nonparallel", {"joint": 3}


def pedestal(seed: int, **settings: Any) -> tuple[Cell, str, dict[str, Any]]:
    """A base that tilts by 4e-6 rad/(N m) under masses at the ends of the links."""
    truth = make_cell(seed=seed, poses_per_plane=3, **settings).scene.truth
    masses = np.linspace(9.0, 1.0, truth.geometry.shape[1])

    def tilt(at: PoseData) -> np.ndarray:
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
    """Lengths that grow by a share of 5e-4 with the temperature, which is recorded."""
    truth = make_cell(seed=seed, poses_per_plane=3, **settings).scene.truth
    lengths = np.zeros_like(truth.geometry)
    lengths[[A, D]] = truth.geometry[[A, D]]

    def growth(at: PoseData) -> np.ndarray:
        return GROWTH / WARMING * (at.columns["temperature"] - 20.0)[:, None, None] * lengths

    return make_cell(Flaws(geometry=growth), seed=seed, columns=warming, **settings), "thermal_drift", {}


def slip(seed: int, **settings: Any) -> tuple[Cell, str, dict[str, Any]]:
    """A sensor that shifts by 0.5 mm in the middle of the acquisition."""
    rng = draw(seed)
    motion = np.eye(4)
    motion[:3, 3] = 5e-4 * unit(rng)
    n = 3 * settings.get("poses_per_plane", 60)
    first = float(rng.integers(n // 4, 3 * n // 4))
    cell = make_cell(Flaws(slip=(first, motion)), seed=seed, columns=in_order, **settings)
    return cell, "sensor_slip", {"order": first}


def distortion(seed: int, **settings: Any) -> tuple[Cell, str, dict[str, Any]]:
    """A range with a curvature of 0.01 /m, which makes an error of a third of a millimetre at its ends."""
    flaws = Flaws(measured=lambda r: r + 0.01 * (r - 0.25) ** 2)
    return make_cell(flaws, seed=seed, **settings), "range_distortion", {}


def bow(seed: int, **settings: Any) -> tuple[Cell, str, dict[str, Any]]:
    """A target plane that is 0.5 mm higher at half a metre from its middle."""
    target_plane = PLANE_NAMES[int(draw(seed).integers(3))]
    return (
        make_cell(Flaws(bent={target_plane: (2e-3, 0.0, 2e-3)}), seed=seed, **settings),
        "plane_bow",
        {"plane": target_plane},
    )


def knock(seed: int, **settings: Any) -> tuple[Cell, str, dict[str, Any]]:
    """A target plane that moves by 0.5 mm in the middle of the acquisition."""
    rng = draw(seed)
    target_plane = PLANE_NAMES[int(rng.integers(3))]
    n = 3 * settings.get("poses_per_plane", 60)
    first = float(rng.integers(n // 4, 3 * n // 4))
    flaws = Flaws(moved={target_plane: (first, 5e-4, (0.0, 0.0))})
    cell = make_cell(flaws, seed=seed, columns=in_order, **settings)
    return cell, "plane_moved", {"plane": target_plane, "order": first}


def jitter(seed: int, **settings: Any) -> tuple[Cell, str, dict[str, Any]]:
    """Joints that repeat with a standard deviation of 2e-4 rad."""
    return make_cell(Flaws(jitter=2e-4), seed=seed, **settings), "pose_jitter", {}


def bias(seed: int, **settings: Any) -> tuple[Cell, str, dict[str, Any]]:
    """Scans with an error of 0.2 mm (standard deviation) each, common to their points."""
    return make_cell(Flaws(bias=2e-4), seed=seed, **settings), "scan_bias", {}


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


def judged(effects: list[dict[str, Any]], name: str, target: dict[str, Any], slack: int = 6) -> bool:
    """Return whether the first effect is the right one: its name, joint, order and target plane, and its beginning to within ``slack`` poses."""
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
