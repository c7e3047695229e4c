"""Postures found once for each seed and shared by all cases of all sweeps: most of a simulation's work.

The first postures of a longer plan are those of a shorter one, so a case with fewer poses takes a subset.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from scalar.atomic import write_json

if TYPE_CHECKING:
    from scalar.simulation.plan import PosePlan


def write_plans(scene: str | Path, poses_per_plane: int, seeds: Sequence[int], path: str | Path) -> None:
    """Write the postures of a scene for every seed.

    Args:
        scene: Config file of the scene.
        poses_per_plane: At least so many for each plane; more where the scene itself asks for more.
        seeds: Each a plan of its own.
        path: JSON, ``{seed: {"cell": .., "q": [(k, n) rad, a list a plane]}}``.

    Raises:
        InvalidInput: The scene is at fault.
        SimulationError: Too few postures see a plate.
    """
    # The simulator is an extra; a study of one's own data does without.
    from scalar.simulation.config import load_config, poses_wanted
    from scalar.simulation.plan import plan_poses

    config = load_config(Path(scene))
    wanted = max(poses_per_plane, *poses_wanted(config))
    plans: dict[str, Any] = {}
    for seed in seeds:
        plan = plan_poses(config | {"seed": seed, "poses_per_plane": wanted}, base_dir=Path(scene).parent)
        plans[str(seed)] = {"cell": plan.cell, "q": [q.tolist() for q in plan.q]}
        print(f"seed {seed}: {wanted} postures a plane", flush=True)
    write_json(path, plans)


def read_plans(path: str | Path) -> dict[int, PosePlan]:
    """Return the postures that ``write_plans`` wrote, by seed."""
    from scalar.simulation.plan import PosePlan

    content = json.loads(Path(path).read_text(encoding="utf-8"))
    return {
        int(seed): PosePlan(tuple(np.array(q, dtype=float) for q in plan["q"]), (), plan["cell"])
        for seed, plan in content.items()
    }


def serves(plan: PosePlan, config: Mapping[str, Any]) -> bool:
    """Return whether a plan holds the postures that a config asks for: same cell, enough of them."""
    from scalar.simulation.config import complete_config, poses_wanted
    from scalar.simulation.plan import cell_text

    complete = complete_config(config)
    enough = all(len(q) >= k for q, k in zip(plan.q, poses_wanted(complete), strict=True))
    return enough and plan.cell == cell_text(complete)
