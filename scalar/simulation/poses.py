"""Postures from which the scanner sees one target plane well, found by drawing at random.

q is uniform within the joint limits. A posture is kept if its whole fan falls on the intended target plane, within
the range and incidence limits, if nothing stands in the beam, and if arm and sensor touch neither target planes nor
themselves. Plane geometry in NumPy refuses most candidates, thousands at a time; pybullet then tests each remaining
one on the true arm.

Each plane has its own random generator, and its candidates are drawn one after the other, so the first k postures
are the same however many are asked for.
"""

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from scalar.simulation.arm import Arm
from scalar.simulation.errors import SimulationError
from scalar.simulation.scanner import BEYOND, Scanner, cast_fan, directions
from scalar.simulation.target_planes import TargetPlane
from scalar.simulation.transforms import Array
from scalar.simulation.world import World

BATCH = 8192  # candidates that are drawn at once
FAN_RAYS = 41  # rays across the fan that all have to hit the target plane: 6 mm apart at 0.45 m in a fan of +-15 degrees
SIDE_RAYS = 13  # rays of each of the two fans at its sides
FAR_BEYOND = 1.5  # ratio of the length of the side fans' rays to the far limit: these fans are wider, so their outer rays are longer
SLACK = 1e-9  # m and rad; rounding errors of the test in NumPy are smaller, so it refuses no posture that pybullet would keep

REMEDIES = {
    "the beam misses the target plane": "make the target plane larger or place it where the scanner can look at it",
    "out of range": "widen sensor.range_m or move the target plane",
    "incidence too steep": "raise sensor.incidence_max_deg",
    "the arm touches a target plane": "move the target planes away from the arm or raise the near end of sensor.range_m",
    "the arm touches itself": "check body and the joint limits",
    "something stands in the beam": "check sensor.pose, body, and where target planes meet",
}


@dataclass
class Search:
    """How the search for one plane went: how many candidates were drawn, and why the others were refused."""

    plane: str
    drawn: int = 0
    kept: int = 0
    refused: Counter[str] = field(default_factory=Counter)

    def complaint(self, wanted: int) -> str:
        """Return a sentence that says how many candidates each reason refused, and what to do about the most frequent one."""
        parts = [f"{reason} {count / max(self.drawn, 1):.1%}" for reason, count in self.refused.most_common()]
        worst = self.refused.most_common(1)[0][0] if self.refused else None
        advice = f"; {REMEDIES[worst]}" if worst else ""
        return (
            f"plane {self.plane}: {self.kept} of {wanted} poses found among {self.drawn} candidates "
            f"({', '.join(parts)}){advice}, or raise candidates_max"
        )


def sees_target_plane(
    arm: Arm, scanner: Scanner, target_plane: TargetPlane, q: Array, edge: float
) -> tuple[Array, Counter[str]]:
    """Return the indices of candidates whose whole fan falls on a target plane within the limits, and counts of the refused by reason.

    Along the fan the range is h / cos(phi - phi_0). Range and incidence are largest at an end of the fan; the range is
    smallest at an end too, or at phi_0 if the fan contains it. A target plane is convex, so if both ends of the scan
    line are on it, the whole line is.

    Args:
        arm, scanner, target_plane: the true ones.
        q: (N, n) [rad].
        edge: distance [m] to keep from the target plane's edge.
    """
    R, origin = arm.sensor_frames(q)
    w = target_plane.axes[:, 2]
    height = (origin - target_plane.centre) @ w
    ends = directions(np.array([-scanner.fan, scanner.fan]))
    refused: Counter[str] = Counter()
    alive = np.arange(len(q))

    def keep(good: Any, reason: str) -> None:
        nonlocal alive
        refused[reason] += int(len(good) - good.sum())
        alive = alive[good]

    toward = -(R @ ends.T).transpose(0, 2, 1) @ w  # (N, 2) cosines of incidence at the ends
    keep((height > 0) & (toward > SLACK).all(1), "the beam misses the target plane")
    reach = height[alive, None] / toward[alive]
    far = reach.max(1)
    near = reach.min(1)
    # The foot of the perpendicular: along -w projected into the sensor's XZ plane.
    across, ahead = -(R[alive, :, 0] @ w), -(R[alive, :, 2] @ w)
    foot_inside = np.abs(np.arctan2(across, ahead)) < scanner.fan
    near = np.where(foot_inside, height[alive] / np.hypot(across, ahead), near)
    keep((near >= scanner.range_near - SLACK) & (far <= scanner.range_far + SLACK), "out of range")
    keep(toward[alive].min(1) >= np.cos(scanner.incidence) - SLACK, "incidence too steep")
    spot = origin[alive, None] + (height[alive, None] / toward[alive])[..., None] * (
        (R[alive] @ ends.T).transpose(0, 2, 1)
    )
    offset = np.abs((spot - target_plane.centre) @ target_plane.axes[:, :2])
    keep((offset <= target_plane.size / 2 - edge + SLACK).all((1, 2)), "the beam misses the target plane")
    return alive, refused


def refusal(
    world: World, scanner: Scanner, index: int, target_plane: TargetPlane, q: Array, edge: float
) -> str | None:
    """Return the reason for which pybullet's rays or collisions refuse the posture q (n,) [rad], or None if they do not.

    Two more fans, at the distance `edge` on either side of the scanner's fan and wider by as much, have to fall on the
    target plane too, so that noise and effects on the arm throw no ray onto another target plane.

    Args:
        world: with all target planes, and the true arm with its body.
        scanner: the true one.
        index, target_plane: the intended target plane.
        q: joint angles (n,) [rad].
        edge: distance [m] of the two fans from the scanner's.
    """
    touched = world.touching(q.tolist())
    if touched is not None:
        return "the arm touches a target plane" if touched == "target_plane" else "the arm touches itself"
    T = world.sensor_frames(q[None])
    world.refresh()
    angles = np.linspace(-scanner.fan, scanner.fan, FAN_RAYS)
    hit, reach = cast_fan(world, T, angles, scanner.range_far * BEYOND)
    if not (hit == world.target_plane_ids[index]).all():
        return "the beam misses the target plane" if (hit < 0).any() else "something stands in the beam"
    if reach.min() < scanner.range_near or reach.max() > scanner.range_far:
        return "out of range"
    cosines = -(directions(angles) @ T[0, :3, :3].T) @ target_plane.axes[:, 2]
    if cosines.min() < np.cos(scanner.incidence):
        return "incidence too steep"
    aside = np.repeat(T, 2, axis=0)
    aside[:, :3, 3] += edge * np.array([[-1.0], [1.0]]) * T[0, :3, 1]
    wider = np.linspace(-scanner.fan - edge / reach[0, 0], scanner.fan + edge / reach[0, -1], SIDE_RAYS)
    hit, _ = cast_fan(world, aside, wider, scanner.range_far * FAR_BEYOND)
    return "something stands in the beam" if (hit != world.target_plane_ids[index]).any() else None


def find_poses(
    world: World,
    arm: Arm,
    scanner: Scanner,
    target_planes: tuple[TargetPlane, ...],
    index: int,
    wanted: int,
    rng: np.random.Generator,
    *,
    edge: float,
    candidates_max: int,
    progress: Callable[[str, int, int], None] | None = None,
) -> tuple[Array, Search]:
    """Return `wanted` postures (wanted, n) [rad] that scan target plane `index`, and how the search went.

    Args:
        world: contains `target_planes` and `arm` with its body.
        edge: distance [m] of each scan from the target plane's edge and from all else.
        candidates_max: how many are drawn before giving up.
        progress: called with (stage, done, of).

    Raises:
        SimulationError: `candidates_max` gave too few postures; the message says which limit refused most.
    """
    target_plane = target_planes[index]
    search = Search(target_plane.name)
    found: list[Array] = []
    low, high = arm.limits[:, 0], arm.limits[:, 1]
    while len(found) < wanted:
        if search.drawn >= candidates_max:
            raise SimulationError(search.complaint(wanted))
        q = rng.uniform(low, high, (BATCH, arm.n))
        candidates, refused = sees_target_plane(arm, scanner, target_plane, q, edge)
        search.drawn += BATCH
        search.refused += refused
        for k in candidates:
            reason = refusal(world, scanner, index, target_plane, q[k], edge)
            if reason is not None:
                search.refused[reason] += 1
                continue
            found.append(q[k])
            search.kept = len(found)
            if progress is not None:
                progress(f"poses {target_plane.name}", len(found), wanted)
            if len(found) == wanted:
                break
    return np.array(found).reshape(wanted, arm.n), search
