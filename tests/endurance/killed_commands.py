"""The commands that are killed, and the files that they read."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

import numpy as np

SCALAR = (sys.executable, "-m", "scalar.cli")
COMMANDS = {
    "calibrate": ("calibrate", "{data}", "-o", "{out}", "--report"),
    "diagnose --quick": ("diagnose", "{data}", "-o", "{out}", "--quick"),
    "diagnose": ("diagnose", "{data}", "-o", "{out}"),
    "diagnose --batch": ("diagnose", "--batch", "{data}/../fleet", "-o", "{out}", "--quick"),
    "simulate": ("simulate", "{data}/../scene.yaml", "-o", "{out}"),
    "plan": ("plan", "{data}", "--poses", "24", "--no-collisions", "--candidates", "200", "-o", "{out}"),
    "predict": ("predict", "{data}/../calibration.json", "{data}/poses.csv", "-o", "{out}/frames.csv"),
    "correct": (
        "correct",
        "{data}/../calibration.json",
        "{data}/poses.csv",
        "--leave-out",
        "-o",
        "{out}/corrected.csv",
    ),
    "compare": (
        "compare",
        "{data}/../calibration.json",
        "{data}/../later.json",
        "-o",
        "{out}/changes.json",
    ),
    "evaluate": ("evaluate", "{data}/../calibration.json", "{data}/../truth", "-o", "{out}"),
    "import": ("import", "{data}/../mapping.yaml", "{data}/../table.csv", "-o", "{out}/imported"),
    "import-bag": (
        *("import-bag", "{data}/../bag/cell", "{data}/../bag/campaign.bag"),
        *("--joint-names", ",".join(f"joint_{i}" for i in range(1, 7)), "-o", "{out}/recorded"),
    ),
    "init": ("init", "{out}/cell", "--robot", "vs060", "--sensor", "line-laser"),
    "demo": ("demo", "--seed", "7", "-o", "{out}/demo"),
    "validate": ("validate", "{data}"),
    "export": ("export", "{data}/../calibration.json", "-o", "{out}/arm.md"),
}
NEVER_REPLACE = ("init", "demo")
"""Commands that write over nothing, so that they start without an older result."""


def command(name: str, data: Path, out: Path) -> list[str]:
    """Return a command line.

    Args:
        name: Key of ``COMMANDS``.
        data: A dataset of ``write_datasets``.
        out: Folder to write to.
    """
    return [*SCALAR, *(part.format(data=data, out=out) for part in COMMANDS[name])]


def write_datasets(root: Path) -> tuple[Path, Path]:
    """Write two datasets of one workcell, each with a scene, a calibration, a foreign table and a recording."""
    from scalar.data.dataset import read_dataset
    from scalar.data.io.plain_yaml import dump_yaml, load_yaml
    from scalar.estimation.calibrate import calibrate
    from scalar.simulation import load_config, simulate, write_scene

    configs = Path(__file__).parents[2] / "configs"
    found = []
    for seed in (1, 2):
        folder = root / f"seed-{seed}"
        scene = load_yaml(configs / "scenes" / "paper.yaml") | {
            "seed": seed,
            "poses_per_plane": 14,
            "truth_poses": 1000,
        }
        folder.mkdir(parents=True)
        scene["robot"] = str((configs / "scenes" / scene["robot"]).resolve())
        dump_yaml(scene, folder / "scene.yaml")
        write_scene(simulate(load_config(folder / "scene.yaml"), base_dir=folder), folder)
        dataset = read_dataset(folder / "dataset")
        calibrate(dataset).save(folder / "calibration.json")
        calibrate(dataset.subset(np.arange(36))).save(folder / "later.json")  # of the same arm
        _write_foreign_files(folder, seed)
        for arm in ("first", "second"):
            shutil.copytree(folder / "dataset", folder / "fleet" / arm)
        found.append(folder / "dataset")
    return found[0], found[1]


def _write_foreign_files(folder: Path, seed: int) -> None:
    """Write a table with its mapping, and a recording with its workcell, which differ with the seed."""
    import pandas as pd

    from tests.endurance.foreign_files import write_mapping_files
    from tests.ingest.bags import write_bag
    from tests.random_scene import make_scene

    write_mapping_files(folder)
    table = pd.read_csv(folder / "table.csv")
    table.assign(x=table["x"] + seed).to_csv(folder / "table.csv", index=False)
    scene = make_scene("vs060", "line-laser", seed=seed, poses_per_plane=2, points_per_scan=60)
    (folder / "bag").mkdir()
    write_bag(scene.dataset, folder / "bag" / "campaign.bag", 1, "LaserScan")
    scene.dataset.write(folder / "bag" / "cell")
