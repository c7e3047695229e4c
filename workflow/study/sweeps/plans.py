"""Compute postures and true scans once for each seed; all cases of all sweeps share them, since they take most of a simulation's time.

A shorter plan has the first postures of a longer one, and a scan with fewer points has some of the points of one with more, so that each case takes
from the plan what it needs. Noise and the declared model are added for each case.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from scalar.data.io.atomic import atomic_write

if TYPE_CHECKING:
    from scalar.simulation.plan import PosePlan
    from scalar.simulation.scans import Scans

_TABLES = ("T_base_sensor", "angles", "ranges")  # attributes of Scans that have an array for each plane


@dataclass(frozen=True, eq=False)
class Shared:
    """What all cases of a seed share: the plan of postures, and the true scans at them, without noise."""

    plan: PosePlan
    scans: Scans


def write_plans(scene: str | Path, poses_per_plane: int, seeds: Sequence[int], path: str | Path) -> None:
    """Write the postures and true scans of a scene for every seed.

    Args:
        scene: Config file of the scene.
        poses_per_plane: Least number of postures of each plane; there are more if the scene itself asks for more.
        seeds: The seeds; each has a plan of its own.
        path: The NumPy archive to write, with an array for each seed and plane.

    Raises:
        InvalidInput: The scene is at fault.
        SimulationError: Too few postures see a target plane.
    """
    # Imported here: the simulator needs pybullet, an optional dependency.
    from scalar.simulation.config import load_config, poses_wanted
    from scalar.simulation.plan import plan_poses
    from scalar.simulation.scene import simulate

    folder = Path(scene).parent
    config = load_config(Path(scene))
    wanted = max(poses_per_plane, *poses_wanted(config))
    content: dict[str, Any] = {}
    for seed in seeds:
        of_seed = config | {"seed": seed, "poses_per_plane": wanted}
        plan = plan_poses(of_seed, base_dir=folder)
        scans = simulate(of_seed, base_dir=folder, plan=plan).true_scans()
        content[f"{seed}/workcell"] = np.array(plan.workcell)
        for k, q in enumerate(plan.q):
            content[f"{seed}/q/{k}"] = q
            content |= {f"{seed}/{name}/{k}": getattr(scans, name)[k] for name in _TABLES}
        print(f"seed {seed}: {wanted} postures a plane", flush=True)
    with atomic_write(path) as temporary, temporary.open("wb") as file:
        np.savez(file, **content)


def read_plans(path: str | Path) -> dict[int, Shared]:
    """Return ``{seed: plan and scans}`` from a file that ``write_plans`` wrote."""
    from scalar.simulation.plan import PosePlan
    from scalar.simulation.scans import Scans

    shared: dict[int, Shared] = {}
    with np.load(path) as content:
        seeds = [int(name.split("/")[0]) for name in content.files if name.endswith("/workcell")]
        for seed in seeds:
            planes = range(sum(name.startswith(f"{seed}/q/") for name in content.files))
            workcell = str(content[f"{seed}/workcell"])
            q = tuple(content[f"{seed}/q/{k}"] for k in planes)
            tables = (tuple(content[f"{seed}/{name}/{k}"] for k in planes) for name in _TABLES)
            shared[seed] = Shared(PosePlan(q, (), workcell), Scans(workcell, *tables))
    return shared


def serves(plan: PosePlan, config: Mapping[str, Any]) -> bool:
    """Return whether a plan can be used for a complete config: it has the same workcell, and at least as many postures of each plane."""
    from scalar.simulation.config import poses_wanted
    from scalar.simulation.plan import workcell_text

    enough = all(len(q) >= k for q, k in zip(plan.q, poses_wanted(config), strict=True))
    return enough and plan.workcell == workcell_text(config)
