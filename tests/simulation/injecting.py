"""Scenes with something injected, and the same scenes without."""

from functools import cache
from typing import Any

import numpy as np

from scalar.simulation import PosePlan, SimulatedScene, plan_poses, simulate
from tests.simulation.conftest import scene_config

RECORD = ["time", "temperature", "approach", "payload", "torque"]
KINDS = (
    "angle_bump", "angle_product", "angle_step", "angle_sum", "base_sway", "belt", "encoder_drift", "late_jump",
    "sensor_oscillation", "worn_teeth",
)  # fmt: skip
ENTRIES: dict[str, dict[str, Any]] = {
    name: {"effect": name}
    for name in (
        "joint_compliance", "joint_harmonic", "joint_scale", "joint_coupling", "joint_backlash", "joint_hysteresis", "pose_lag", "axis_nonparallel",
        "base_compliance", "thermal_drift", "restarted_warm_up", "target_drift", "torque_compliance", "payload_deflection",
        "sensor_slip", "range_scale", "range_offset", "range_distortion",
        "plane_bow", "plane_moved", "pose_jitter", "scan_bias",
    )
} | {
    "harmonics": {"effect": "joint_harmonic", "target": {"joint": 2, "orders": [1, 2, 7]}},
    "backlash_by_moves": {"effect": "joint_backlash", "by_moves": True},
    "backlash_by_weight": {"effect": "joint_backlash", "recorded": False},
    "warm_up": {"effect": "thermal_drift", "by": "time", "profile": "warm_up", "lengths": ["a_3", "d_1"]},
    "creep": {"effect": "plane_moved", "creep": 0.7},
} | {kind: {"effect": "unknown", "kind": kind} for kind in KINDS}  # fmt: skip
"""Every effect once, by a name for the test's report."""


def config_with(*entries: dict[str, Any], scene: str = "ur10e", **changes: Any) -> dict[str, Any]:
    """Return the config of a small scene with these effects, everything recorded, evenly spread points."""
    config = scene_config(scene, **{"injected": list(entries), "record": RECORD} | changes)
    config["sensor"] |= {"selection": "even", "points_per_scan": 21}
    return config


@cache
def plan_of(scene: str) -> PosePlan:
    """Return the postures of a scene, which no effect changes."""
    return plan_poses(config_with(scene=scene))


def injected(*entries: dict[str, Any], scene: str = "ur10e", **changes: Any) -> SimulatedScene:
    """Return a scene with these effects; without noise unless `noise` says so."""
    config = config_with(*entries, scene=scene, **{"noise": {}} | changes)
    return simulate(config, plan=plan_of(scene) if "seed" not in changes else None)


def angles_in(table: Any, n: int) -> np.ndarray:
    """Return q (N, n) [rad] of a table of poses."""
    return table[[f"q{i + 1}" for i in range(n)]].to_numpy()
