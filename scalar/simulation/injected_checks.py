"""Faults of `injected` that a schema cannot find: joints, planes, poses and lengths that the workcell does not have."""

from collections.abc import Mapping, Sequence
from typing import Any


def injected_faults(
    entries: Sequence[Mapping[str, Any]], n_joints: int, wanted: Mapping[str, int], known_lengths: list[str]
) -> list[tuple[str, str]]:
    """Return the faults of `injected` that a schema cannot find, as (path of the key, message).

    Args:
        entries: the entries, valid by the schema.
        n_joints: number of joints of the robot.
        wanted: number of poses of each plane, by its name.
        known_lengths: names of the arm's lengths.
    """
    found: list[tuple[str, str]] = []
    n_poses = sum(wanted.values())
    for k, entry in enumerate(entries):
        target, place = entry["target"], f"injected[{k}].target"
        for key in ("joint", "source", "joints"):
            named = target.get(key, [])
            for joint in named if isinstance(named, list) else [named]:
                if not 1 <= joint <= n_joints:
                    found.append((f"{place}.{key}", f"there is no joint {joint}; joints 1 to {n_joints}"))
        if "source" in target and target["source"] == target.get("joint"):
            found.append((f"{place}.source", "is the joint itself; name another joint"))
        if {"order", "orders"} <= set(target):
            found.append((f"{place}.orders", "is given together with order; give one of them"))
        if target.get("plane", next(iter(wanted))) not in wanted:
            names = ", ".join(wanted)
            found.append((f"{place}.plane", f"no plane {target['plane']!r}; there are {names}"))
        if not 1 <= target.get("at", {}).get("order", 1) < n_poses:
            found.append((f"{place}.at.order", f"the run has poses 0 to {n_poses - 1}; give 1 or later"))
        for name in entry.get("lengths") or ():
            if name not in known_lengths:
                found.append((f"injected[{k}].lengths", f"{name!r} is no length; {', '.join(known_lengths)}"))
    return found
