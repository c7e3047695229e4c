"""Simulate the datasets of one case, a seed each, in folders as ``scalar simulate`` writes them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from study.common.grid import with_overrides
from study.common.seeds import seed_name


def simulate_seeds(
    scene: str | Path, overrides: Mapping[str, Any], seeds: Sequence[int], out_dir: str | Path
) -> None:
    """Write a dataset and its truth for every seed.

    Args:
        scene: Config file of the scene.
        overrides: ``{dotted key: value}`` of the case.
        seeds: Seeds of the datasets.
        out_dir: Folder in which each seed gets a folder, ``seed-001`` and so on.

    Raises:
        InvalidInput: The scene is at fault.
        SimulationError: Too few postures see a target plane.
    """
    # Imported here: the simulator needs pybullet, an optional dependency.
    from scalar.simulation.config import load_config
    from scalar.simulation.export import write_scene
    from scalar.simulation.scene import simulate

    scene = Path(scene)
    config = with_overrides(load_config(scene), overrides)
    for seed in seeds:
        found = simulate(config | {"seed": seed}, base_dir=scene.parent)
        write_scene(found, Path(out_dir) / seed_name(seed), table_format="parquet")
        print(f"seed {seed}: {len(found.poses)} poses, {len(found.scans)} points", flush=True)
