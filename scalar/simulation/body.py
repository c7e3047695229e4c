"""The solids of an arm: capsules along its skeleton, for collision tests and for pictures.

Only the kinematics of an arm are known, not its housings. So each link is a capsule along its a and another along its d (these
lines are the skeleton). The radius is a share of the arm's reach, which falls linearly from `THICK_BASE` at the base to
`THICK_WRIST` at the flange. For an arm with a reach of 0.68 m this gives radii of 51 to 27 mm, and for one of
1.6 m 120 to 64 mm, which is about what such arms have. The sensor is a box behind its origin, with a rod from
the flange. A config may state all of these sizes.

Housings beside the skeleton, cables and the exact shapes are left out. This makes poses a little
easier or harder to find; it cannot change a measured number.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from scalar.simulation.arm import Arm
from scalar.simulation.transforms import Array

THICK_BASE = 0.075  # radius over reach
THICK_WRIST = 0.04
# A shorter piece of the skeleton [m], such as a nominal length of zero with an error, gets no capsule.
NEGLIGIBLE = 1e-3
SENSOR_GAP = 2e-3  # m; the box stands this far behind the sensor's origin, so that no ray begins inside it


@dataclass(frozen=True, eq=False)
class Capsule:
    """A capsule from `start` to `end`, (3,) [m] in the frame of link `link`, of the given radius [m].

    Links count as pybullet does: -1 the base, 0..n-1 behind each joint, n the flange, n + 1 the sensor.
    """

    link: int
    start: Array
    end: Array
    radius: float

    @property
    def length(self) -> float:
        """Return the distance of its two ends [m]."""
        return float(np.linalg.norm(self.end - self.start))


@dataclass(frozen=True, eq=False)
class Box:
    """A box about `centre` (3,) [m] in the frame of link `link`, along that frame's axes; size (3,) [m]."""

    link: int
    centre: Array
    size: Array


@dataclass(frozen=True, eq=False)
class Body:
    """All solids of an arm, and the pairs of links that must not touch each other.

    Attributes:
        solids: capsules and boxes.
        pairs: (link, link) that are tested for self collision. Left out are links that always touch because they are
            joined directly, or by a piece of skeleton that is shorter than both are thick.
        clearance: distance [m] below which things count as touching.
    """

    solids: tuple[Capsule | Box, ...]
    pairs: tuple[tuple[int, int], ...]
    clearance: float


def reach(arm: Arm) -> float:
    """Return the length [m] of the stretched arm from its second joint to the flange."""
    inner = np.abs(arm.a[1:]).sum() + np.abs(arm.d[1:]).sum()
    return float(inner + np.linalg.norm(arm.T_n_flange[:3, 3]))


def body_of(arm: Arm, options: Mapping[str, Any]) -> Body:
    """Return the body of an arm.

    Args:
        arm: the nominal geometry; millimetres of error make no difference here.
        options: the config's `body` block: `base_radius_m`, `wrist_radius_m` (None: from the reach),
            `pedestal_m` (a column of that length below the base), `bracket_radius_m`, `sensor_size_m` (3,),
            `clearance_m`.
    """
    thick = options["base_radius_m"] or THICK_BASE * reach(arm)
    thin = options["wrist_radius_m"] or THICK_WRIST * reach(arm)
    clearance = options["clearance_m"]
    capsules: list[Capsule] = []
    between = np.zeros(arm.n + 2)  # length of the skeleton on the base and on each link

    def add(link: int, points: list[Array], radius: float) -> None:
        for start, end in pairwise(points):
            capsule = Capsule(link, start, end, radius)
            between[link + 1] += capsule.length
            if capsule.length > NEGLIGIBLE:
                capsules.append(capsule)

    for i in range(arm.n):
        T_origin = arm.T_base_0 if i == 0 else np.eye(4)
        T_joint = arm.joint_origin(i)
        elbow = np.array([arm.a[i], 0.0, 0.0])
        points = [T_origin[:3, :3] @ p + T_origin[:3, 3] for p in (np.zeros(3), elbow, T_joint[:3, 3])]
        add(i - 1, points, thick + (thin - thick) * i / arm.n)
    add(arm.n - 1, [np.zeros(3), arm.T_n_flange[:3, 3]], thin)
    if options["pedestal_m"] > 0:
        capsules.append(Capsule(-1, np.zeros(3), np.array([0.0, 0.0, -options["pedestal_m"]]), thick))

    size = np.array(options["sensor_size_m"], float)
    centre = np.array([0.0, 0.0, -SENSOR_GAP - size[2] / 2])
    T = arm.T_flange_sensor
    bracket = Capsule(arm.n, np.zeros(3), T[:3, :3] @ centre + T[:3, 3], options["bracket_radius_m"])
    if bracket.length > NEGLIGIBLE:
        capsules.append(bracket)
    solids = (*capsules, Box(arm.n + 1, centre, size))

    widest = {solid.link: 0.0 for solid in solids}
    for capsule in capsules:
        widest[capsule.link] = max(widest[capsule.link], capsule.radius)
    links = sorted(widest)
    pairs = []
    for k, first in enumerate(links):
        for second in links[k + 1 :]:
            path = between[first + 2 : min(second, arm.n) + 1].sum()  # on the links strictly between
            both_on_tool = first >= arm.n - 1  # rigidly joined
            if not both_on_tool and path > widest[first] + widest[second] + clearance:
                pairs.append((first, second))
    return Body(solids, tuple(pairs), clearance)
