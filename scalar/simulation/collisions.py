"""Test whether an arm, as a dataset.yaml declares it, touches itself or a plane, or stands in its scanner's beam: for `scalar plan`.

The arm's solids are the simulator's defaults: capsules along the arm's a and d, and a box for the sensor. A plane without a stated extent is taken to
go on beyond the arm's reach; one with an extent is the square about its circle.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np

from scalar.simulation.arm import arm_from_mapping
from scalar.simulation.body import body_of, reach
from scalar.simulation.config import scene_schema
from scalar.simulation.scanner import cast_fan
from scalar.simulation.target_planes import target_plane_from_mapping
from scalar.simulation.transforms import Array
from scalar.simulation.world import World

_THICKNESS = 0.05  # of a target plane [m]
# Number of rays across the fan: 8 mm apart at 0.45 m in a fan of +-15 degrees, where an arm is at least 5 cm thick.
_RAYS = 31


@dataclass(frozen=True, eq=False)
class ArmTests:
    """What is tested of joint angles ``(N, n)`` [rad].

    Attributes:
        free: Returns in which of them the arm touches nothing, ``(N,)`` bool.
        sees_past_itself: Returns in which of them no part of the arm stands in the beam of its scanner, ``(N,)`` bool. It takes half of
            the fan's opening angle [rad] and the length of its rays [m] as well.
    """

    free: Callable[[Array], Array]
    sees_past_itself: Callable[[Array, float, float], Array]


@contextmanager
def collision_test(
    robot: Mapping[str, Any], sensor_pose: Mapping[str, Any] | None, planes: Sequence[Mapping[str, Any]]
) -> Iterator[ArmTests]:
    """Yield the tests of joint angles.

    Args:
        robot: The ``robot:`` block of a dataset.yaml.
        sensor_pose: The sensor's pose on the flange, as dataset.yaml has it.
        planes: Name, normal and distance [m] of each, and ``extent`` [m] of those that end, as dataset.yaml has them.
    """
    arm = arm_from_mapping(robot, sensor_pose)
    shoulder = (arm.T_base_0 @ arm.joint_origin(0))[:3, 3]
    size = 4.0 * reach(arm)
    walls = [
        target_plane_from_mapping(
            {
                "name": plane["name"],
                "normal": plane["normal"],
                "distance_m": plane["distance"],
                "centre_m": plane.get("extent", {}).get("centre"),
                "size_m": [2.0 * plane["extent"]["radius"]] * 2 if "extent" in plane else [size, size],
                "thickness_m": _THICKNESS,
            },
            shoulder,
        )
        for plane in planes
    ]
    options = {
        key: value.get("default") for key, value in scene_schema()["properties"]["body"]["properties"].items()
    }
    with World(walls) as world:
        world.place_arm(arm, body_of(arm, options))

        def free(q: Array) -> Array:
            return np.array([world.touching(row.tolist()) is None for row in q], dtype=bool)

        def sees_past_itself(q: Array, fan: float, length: float) -> Array:
            angles = np.linspace(-fan, fan, _RAYS)
            seen = np.empty(len(q), dtype=bool)
            for k in range(len(q)):
                T = world.sensor_frames(q[k : k + 1])
                world.refresh()
                seen[k] = not np.any(cast_fan(world, T, angles, length)[0] == world.arm_id)
            return seen

        yield ArmTests(free, sees_past_itself)
