"""Make the true workcell of a config, and plan the postures from which its target planes are scanned.

Planning takes most of the time of a simulation. A plan does not depend on the noise, the number of points in a scan or the declared model, so that
all cases of a sweep can share one plan.
"""

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from scalar.simulation.arm import Arm, arm_from_mapping
from scalar.simulation.body import body_of
from scalar.simulation.config import complete_config, poses_wanted
from scalar.simulation.declared import draw_errors
from scalar.simulation.poses import Search, find_poses
from scalar.simulation.scanner import Scanner, scanner_from_mapping
from scalar.simulation.streams import POSES, TRUE_ARM, WEIGHTS, stream
from scalar.simulation.surfaces import is_flat
from scalar.simulation.target_planes import TargetPlane, target_plane_from_mapping
from scalar.simulation.transforms import Array
from scalar.simulation.weight_guess import draw_weights
from scalar.simulation.world import World
from scalar.units import DEG

Progress = Callable[[str, int, int], None]
"""A function that is called as ``progress(stage, done, total)``, to report how much of a stage is done."""

WORKCELL_KEYS = ("seed", "robot", "true_robot_errors", "planes", "body", "edge_margin_m")
"""Keys of a config on which a plan depends."""
WORKCELL_SENSOR_KEYS = ("pose", "fan_half_angle_deg", "range_m", "incidence_max_deg")
"""Keys of its block ``sensor`` on which a plan depends."""


@dataclass(frozen=True, eq=False)
class Workcell:
    """The true workcell.

    Attributes:
        arm: The true arm, with the weights of its links.
        nominal: The arm as the config states it.
        target_planes: The true target planes.
        scanner: The geometry of the scanner.
    """

    arm: Arm
    nominal: Arm
    target_planes: tuple[TargetPlane, ...]
    scanner: Scanner


@dataclass(frozen=True, eq=False)
class PosePlan:
    """Postures from which each target plane is scanned.

    Attributes:
        q: For each plane an array ``(k, n)`` [rad], the joint angles of k postures in the order in which they were found.
        searches: For each plane how many postures the search tried, and which limits refused them.
        workcell: What the plan depends on, as text; the plan is valid for all configs with the same text (``workcell_text``).
    """

    q: tuple[Array, ...]
    searches: tuple[Search, ...]
    workcell: str


def workcell_of(config: Mapping[str, Any]) -> Workcell:
    """Return the workcell of a complete config."""
    nominal = arm_from_mapping(config["robot"], config["sensor"]["pose"])
    arm = nominal
    if "true_robot_errors" in config:
        errors = draw_errors(config["true_robot_errors"], nominal.n, stream(config["seed"], TRUE_ARM))
        arm = nominal.shifted(errors)
    weights = draw_weights(nominal, config["masses"], stream(config["seed"], WEIGHTS))
    arm = replace(arm, weights=weights)
    shoulder = (nominal.T_base_0 @ nominal.joint_origin(0))[:3, 3]
    target_planes = tuple(target_plane_from_mapping(plane, shoulder) for plane in config["planes"])
    return Workcell(arm, nominal, target_planes, scanner_from_mapping(config["sensor"], DEG))


def workcell_text(config: Mapping[str, Any]) -> str:
    """Return what a plan of poses depends on, as text that can be compared."""
    parts = {key: config.get(key) for key in WORKCELL_KEYS}
    parts["sensor"] = {key: config["sensor"][key] for key in WORKCELL_SENSOR_KEYS}
    return json.dumps(parts, sort_keys=True)


def scans_text(config: Mapping[str, Any]) -> str:
    """Return everything on which true scans depend, except their postures, as text that can be compared."""
    surface = "" if is_flat(config["surface"]) else json.dumps(config["surface"], sort_keys=True)
    return workcell_text(config) + surface


def plan_poses(
    config: Mapping[str, Any], base_dir: Path | None = None, *, progress: Progress | None = None
) -> PosePlan:
    """Return postures for each plane of a config, as many as it asks for.

    Args:
        config: Config of a scene; keys that it lacks are completed with defaults.
        base_dir: Folder from which the path of the scene's robot starts; None: the working directory.
        progress: Called while postures are searched.

    Raises:
        InvalidInput: The config is at fault.
        SimulationError: Too few postures see a target plane; the message says which limit refused most.
    """
    config = complete_config(config, base_dir=base_dir)
    workcell = workcell_of(config)
    q, searches = [], []
    with World(workcell.target_planes) as world:
        world.place_arm(workcell.arm, body_of(workcell.nominal, config["body"]))
        for k, wanted in enumerate(poses_wanted(config)):
            found, search = find_poses(
                world,
                workcell.arm,
                workcell.scanner,
                workcell.target_planes,
                k,
                wanted,
                stream(config["seed"], POSES, k),
                edge=config["edge_margin_m"],
                candidates_max=config["candidates_max"],
                progress=progress,
            )
            q.append(found)
            searches.append(search)
    return PosePlan(tuple(q), tuple(searches), workcell_text(config))
