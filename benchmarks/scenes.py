"""The datasets that are timed: the paper's scene, simulated once for each size."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

from scalar.data.dataset import Dataset, read_dataset
from scalar.simulation import load_config, simulate, write_scene

CONFIG = Path(__file__).parents[1] / "configs" / "scenes" / "paper.yaml"
GUESS = {"tilt_std_deg": 3.0, "offset_std_m": 0.01}  # initial guesses of the planes as a user knows them


def paper_scene(points_per_scan: int = 100, poses_per_plane: int = 40) -> Dataset:
    """Return the headline scene (3N = 120, M = 100, 0.1 mm along the ray), or the same with other numbers."""
    with tempfile.TemporaryDirectory() as folder:
        return read_dataset(write_paper_scene(Path(folder), points_per_scan, poses_per_plane))


def write_paper_scene(folder: Path, points_per_scan: int = 100, poses_per_plane: int = 40) -> Path:
    """Write the scene of `paper_scene` and return the folder of its dataset."""
    config = load_config(CONFIG)
    config["sensor"]["points_per_scan"] = points_per_scan
    config["sensor"]["rays"] = max(config["sensor"]["rays"], points_per_scan)
    config["poses_per_plane"] = poses_per_plane
    config["plane_guess"].update(GUESS)
    config["truth_poses"] = 1
    write_scene(simulate(config), folder)
    return folder / "dataset"


def repeated(dataset: Dataset, times: int) -> Dataset:
    """Return a dataset with every pose ``times`` over: as much work as that many poses, and quickly made."""
    return dataset.subset(np.repeat(np.arange(dataset.n_poses), times))
