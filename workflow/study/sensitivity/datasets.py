"""Simulate a blind set as a dataset, with a table of true frames at other poses.

The simulator has only a line laser; the measurements of a tracker or a probe on the same arm are computed here.

A tracker follows the sensor's origin at the postures of the scans. A probe has a stylus along the sensor's z axis; the joint angles of each posture
are changed as little as possible, in the sense of least squares, until the tip is on the target plane, but for the noise. For both, the physics
engine computes where the arm stands, with the effects that are injected into the arm. What is injected into the scanner or the target planes is left
out.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from scalar.data.dataset import Dataset, Sensor
from study.blind_trials.gross_errors import with_gross_errors
from study.common.in_memory import dataset_in_memory
from study.common.scene_config import scene_config
from study.sensitivity.sets import BlindSet, Sets

if TYPE_CHECKING:
    from scalar.simulation.scene import SimulatedScene

Array = np.ndarray
STYLUS = 0.2  # m: about the scanner's stand-off, so that a scan's posture is nearly a contact
STREAM = 51_423  # with the seed of the set, the seed of what this module draws
_STEP = 1e-5  # rad; step of central differences
_CONTACTS = 8  # most steps of the least squares towards a contact; three reach a nanometre


def make_dataset(wanted: BlindSet, sets: Sets, root: Path) -> tuple[Dataset, pd.DataFrame]:
    """Return a blind set and the table of true frames at its evaluation poses.

    Args:
        wanted: The set.
        sets: The config of all sets.
        root: Folder to which the paths of scenes are relative.

    Raises:
        SimulationError: Too few postures see a target plane.
    """
    # Imported here: the simulator needs pybullet, an optional dependency.
    from scalar.simulation.scene import simulate

    workcell = sets.workcells[wanted.workcell]
    scene = root / workcell["scene"]
    overrides = (sets.scene, workcell["overrides"], wanted.overrides)
    injected = [dict(entry) for entry in wanted.injected]
    config = scene_config(scene, overrides, seed=wanted.seed, name=wanted.workcell, injected=injected)
    simulated = simulate(config, base_dir=scene.parent)
    rng = np.random.default_rng([wanted.seed, STREAM])
    dataset = dataset_in_memory(simulated)
    if wanted.sensor == "tracker":
        return _tracker(simulated, dataset, rng), simulated.truth_poses
    if wanted.sensor == "probe":
        return _probe(simulated, dataset, rng)
    return with_gross_errors(dataset, wanted.gross_errors, rng)[0], simulated.truth_poses


def _tracker(simulated: SimulatedScene, dataset: Dataset, rng: np.random.Generator) -> Dataset:
    """Return the dataset of a tracker that measures the sensor's origin, from a place and in an orientation drawn at random."""
    noise = simulated.config["noise"]["range_noise_std_m"]
    R, _ = np.linalg.qr(rng.standard_normal((3, 3)))
    R = R * np.sign(np.linalg.det(R))
    origins = simulated.T_base_sensor[:, :3, 3]
    points = origins @ R.T + rng.uniform(-3.0, 3.0, 3) + noise * rng.standard_normal(origins.shape)
    return _measured(dataset, Sensor("tracker", dataset.sensor.T_flange_sensor, noise), dataset.q, points)


def _probe(
    simulated: SimulatedScene, dataset: Dataset, rng: np.random.Generator
) -> tuple[Dataset, pd.DataFrame]:
    """Return contacts of a stylus with the target planes, and the true poses of its tip."""
    noise = simulated.config["noise"]["range_noise_std_m"]
    planes = simulated.workcell.target_planes
    normals = np.array([planes[k].normal for k in simulated.plane_index])
    distances = np.array([planes[k].distance for k in simulated.plane_index])
    wanted = distances + noise * rng.standard_normal(len(distances))
    q = simulated.q.copy()
    for _ in range(_CONTACTS):
        height = np.sum(normals * _tips(simulated, q), axis=1) - wanted
        if np.abs(height).max() < 1e-9:
            break
        slope = np.empty(q.shape)
        for j in range(q.shape[1]):
            step = _STEP * (np.arange(q.shape[1]) == j)
            moved = _tips(simulated, q + step) - _tips(simulated, q - step)
            slope[:, j] = np.sum(normals * moved, axis=1) / (2 * _STEP)
        q -= slope * (height / np.sum(slope**2, axis=1))[:, None]
    nominal = dataset.sensor.T_flange_sensor
    assert nominal is not None
    truth = simulated.truth_poses.copy()
    truth[["x", "y", "z"]] += STYLUS * _z_axes(truth[["rx", "ry", "rz"]].to_numpy())
    return _measured(dataset, Sensor("probe", nominal @ _along_z(), noise), q, None), truth


def _tips(simulated: SimulatedScene, q: Array) -> Array:
    """Return where the stylus ends ``(N, 3)`` [m] with the encoders at ``q`` ``(N, n)`` [rad], by the physics engine."""
    from scalar.simulation.truth import arm_frames

    T = arm_frames(simulated.workcell.arm, simulated.effects, q, simulated.poses, evaluating=False)
    return T[:, :3, 3] + STYLUS * T[:, :3, 2]


def _z_axes(rotation_vectors: Array) -> Array:
    """Return the third columns ``(N, 3)`` of rotations, by Rodrigues' formula."""
    angle = np.linalg.norm(rotation_vectors, axis=1, keepdims=True)
    k = rotation_vectors / np.where(angle > 0, angle, 1.0)
    z = np.array([0.0, 0.0, 1.0])
    return z * np.cos(angle) + np.cross(k, z) * np.sin(angle) + k * k[:, 2:] * (1 - np.cos(angle))


def _along_z() -> Array:
    """Return the tip of the stylus in the sensor's frame ``(4, 4)``."""
    T = np.eye(4)
    T[2, 3] = STYLUS
    return T


def _measured(dataset: Dataset, sensor: Sensor, q: Array, points: Array | None) -> Dataset:
    """Return a dataset of the same arm, measured by another sensor at joint angles ``(N, n)`` [rad]; without points, one of contacts with planes."""
    own = {"pose", "plane", *(f"q{j + 1}" for j in range(q.shape[1]))}
    columns: dict[str, Any] = {
        str(name): dataset.poses[name].to_numpy() for name in dataset.poses.columns if name not in own
    }
    touching = points is None
    return Dataset.from_arrays(
        robot=dataset.robot,
        sensor=sensor,
        q=q,
        points=points,
        planes=dataset.planes if touching else (),
        plane=list(dataset.poses["plane"]) if touching else None,
        columns=columns,
        pose_ids=dataset.pose_ids,
        name=dataset.name,
        source=dataset.source,
    )
