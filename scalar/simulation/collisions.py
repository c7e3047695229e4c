"""Test whether an arm, as a dataset.yaml declares it, touches itself or a plane: for `scalar plan`.

The arm's solids are the simulator's defaults: capsules along the arm's a and d, and a box for the sensor. The planes are taken to extend beyond
the arm's reach.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np

from scalar.simulation.arm import arm_from_mapping
from scalar.simulation.body import body_of, reach
from scalar.simulation.config import scene_schema
from scalar.simulation.target_planes import target_plane_from_mapping
from scalar.simulation.transforms import Array
from scalar.simulation.world import World

_THICKNESS = 0.05  # of a target plane [m]


@contextmanager
def collision_test(
    robot: Mapping[str, Any], sensor_pose: Mapping[str, Any] | None, planes: Sequence[Mapping[str, Any]]
) -> Iterator[Callable[[Array], Array]]:
    """Yield a function of joint angles ``(N, n)`` [rad] that returns which of them touch nothing, ``(N,)`` bool.

    Args:
        robot: The ``robot:`` block of a dataset.yaml.
        sensor_pose: The sensor's pose on the flange, as dataset.yaml has it.
        planes: Name, normal and distance [m] of each, as dataset.yaml has them.
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
                "centre_m": None,
                "size_m": [size, size],
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

        yield free
