"""The workcell of a config, and a plan of the poses from which its target planes are scanned.

Planning poses is most of a scene's work. The plan does not depend on the noise, the number of points in a scan or the
declared model, so a sweep plans once.
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
"""Called as progress(stage, done, of)."""

WORKCELL_KEYS = ("seed", "robot", "true_robot_errors", "planes", "body", "edge_margin_m")
WORKCELL_SENSOR_KEYS = ("pose", "fan_half_angle_deg", "range_m", "incidence_max_deg")


@dataclass(frozen=True, eq=False)
class Workcell:
    """The true workcell.

    Attributes:
        arm: the true arm, with its weights.
        nominal: the arm as the config states it.
        target_planes: the true ones.
        scanner: its geometry.
    """

    arm: Arm
    nominal: Arm
    target_planes: tuple[TargetPlane, ...]
    scanner: Scanner


@dataclass(frozen=True, eq=False)
class PosePlan:
    """Postures for each plane.

    Attributes:
        q: for each plane (k, n) [rad], in the order in which they were found.
        searches: counts of each search.
        workcell: what the plan depends on, as text; a plan holds for all configs with the same text.
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
    """Return everything that true scans depend on except their postures, as text that can be compared."""
    surface = "" if is_flat(config["surface"]) else json.dumps(config["surface"], sort_keys=True)
    return workcell_text(config) + surface


def plan_poses(
    config: Mapping[str, Any], base_dir: Path | None = None, *, progress: Progress | None = None
) -> PosePlan:
    """Return postures for each plane of a config, as many as it asks for.

    Raises:
        InvalidInput: the config is at fault.
        SimulationError: too few postures see a target plane; the message says which limit refused most.
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
