"""The truth of a scene, against which a calibration is judged: it is never written inside the dataset folder."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from scalar.simulation.arm import Arm, pose_mapping
from scalar.simulation.effects import Effects
from scalar.simulation.load import held_torques
from scalar.simulation.noise import Noise
from scalar.simulation.optics.imperfect import is_imperfect
from scalar.simulation.records import SIDES
from scalar.simulation.streams import TRUTH_POSES_SEED
from scalar.simulation.surfaces import is_flat
from scalar.simulation.target_planes import TargetPlane
from scalar.simulation.transforms import Array, vector_from_rotation
from scalar.simulation.world import World

NOTE = "arrays by joint; beta is the angle about y; t and r: sensor on the flange"


def truth_mapping(
    arm: Arm,
    target_planes: Sequence[TargetPlane],
    noise: Noise,
    effects: Effects,
    poses: pd.DataFrame,
    config: Mapping[str, Any],
) -> dict[str, Any]:
    """Return the content of truth.json: SI units, arrays by joint; t [m] and r [rad] are the sensor's pose on the flange.

    Args:
        arm: the true arm. The parameters written are those of the first pose, before anything drifts or slips.
        target_planes: the true target planes.
        noise: the noise that was added.
        effects: the injected effects.
        poses: the table of poses in acquisition order.
        config: the complete config; its blocks `scanner` and `surface` are included if they add errors.
    """
    faults = {"scanner": config["scanner"]} if is_imperfect(config["scanner"]) else {}
    faults |= {} if is_flat(config["surface"]) else {"surface": config["surface"]}
    arm = effects.arms(arm, poses.iloc[:1], False)[0][1]
    sensor = pose_mapping(arm.T_flange_sensor)
    return {
        "robot": arm.name,
        "parameters": {
            **{name: getattr(arm, name).tolist() for name in ("a", "alpha", "d", "theta", "beta")},
            "t": sensor["translation"],
            "r": sensor["rotation_vector"],
        },
        "base": pose_mapping(arm.T_base_0),
        "flange": pose_mapping(arm.T_n_flange),
        "planes": {
            "names": [target_plane.name for target_plane in target_planes],
            "normals": [target_plane.normal.tolist() for target_plane in target_planes],
            "distances": [target_plane.distance for target_plane in target_planes],
        },
        "effects": effects.record(),
        "noise_m": noise.range_std,
        "scan_bias_std_m": noise.scan_bias_std,
        "joint_noise_std_rad": noise.joint_std,
        "range_quantum_m": noise.range_quantum,
        **faults,
        "seed": config["seed"],
        "note": NOTE,
    }


def arm_frames(arm: Arm, effects: Effects, q: Array, poses: pd.DataFrame, evaluating: bool) -> Array:
    """Return where the sensor truly is, T_base_sensor (N, 4, 4), by pybullet.

    Args:
        arm: the arm without effects.
        effects: the effects on it.
        q: (N, n) [rad], encoders plus noise of the joints.
        poses: the table of these poses.
        evaluating: whether these are evaluation poses.
    """
    T = np.empty((len(q), 4, 4))
    with World() as world:
        for rows, arm_then in effects.arms(arm, poses, evaluating):
            world.place_arm(arm_then)
            dq = effects.joint_errors(world, q[rows], poses.iloc[rows])
            T[rows] = world.sensor_frames(q[rows] + dq)
            T[rows] = effects.motions(world, q[rows], poses.iloc[rows]) @ T[rows]
    return T


def evaluation_poses(
    arm: Arm,
    effects: Effects,
    count: int,
    recorded: pd.DataFrame | None = None,
    progress: Callable[[str, int, int], None] | None = None,
) -> pd.DataFrame:
    """Return truth_poses.csv: pose, q1..qn [rad]; x, y, z [m] and rx, ry, rz [rad] of the sensor.

    q is uniform within the joint limits, without a collision filter, from one seed for all scenes, and without noise.

    Args:
        arm: the true arm without effects.
        effects: the effects on it.
        count: number of poses.
        recorded: the poses of the scene, or None. The table gets their other columns too: directions of approach are drawn,
            torques are those that hold the arm at each pose, and all others have the value of the last pose.
        progress: called with (stage, done, of).
    """
    rng = np.random.default_rng(TRUTH_POSES_SEED)
    q = rng.uniform(arm.limits[:, 0], arm.limits[:, 1], (count, arm.n))
    table = pd.DataFrame(q, columns=[f"q{i + 1}" for i in range(arm.n)])
    table.insert(0, "pose", np.arange(count))
    if recorded is not None:
        for name in recorded.columns.difference(["plane", *table.columns], sort=False):
            approaches = name.startswith("approach")
            table[name] = rng.choice(SIDES, count) if approaches else recorded[name].to_numpy()[-1]
    if "tau1" in table:
        with World() as world:
            world.place_arm(arm)
            for name, column in held_torques(world, arm.T_flange_sensor, q, table).items():
                table[name] = column
    T = arm_frames(arm, effects.at_rest(), q, table, evaluating=True)
    table[["x", "y", "z"]] = T[:, :3, 3]
    table[["rx", "ry", "rz"]] = vector_from_rotation(T[:, :3, :3])
    if progress is not None:
        progress("evaluation poses", count, count)
    return table
