"""Three matrices in MATLAB files, one for each plane, with several rows for each pose, and their mapping."""

from pathlib import Path
from typing import Any

import numpy as np
from scipy.io import savemat

from tests.small_datasets import description


def matrix(seed: int, first: int) -> np.ndarray:
    """Return several rows for each pose: id, camera, six angles [rad]."""
    rng = np.random.default_rng(seed)
    ids = np.repeat(np.arange(first, first + 5), [3, 1, 2, 4, 2])
    q = rng.uniform(-2, 2, (5, 6))
    return np.column_stack([ids, rng.uniform(0, 1, len(ids)), q[ids - first]])


def mat_mapping() -> dict[str, Any]:
    """Return the mapping of three matrices, one for each plane."""
    names = {"floor": "one.mat", "wall_x": "two.mat", "wall_y": "three.mat"}
    files = [
        {"name": f, "plane": p, "covariates": {"repetition": i}} for i, (p, f) in enumerate(names.items())
    ]
    columns = {f"q{i}": {"column": i + 2, "unit": "rad"} for i in range(1, 7)}
    return {
        "format": "scalar-mapping/1",
        "matrix": {"variable": "dataset"},
        "poses": {"files": files, "first_of_each": 1, "columns": columns},
        "dataset": description("probe"),
    }


def write_matrices(folder: Path) -> list[np.ndarray]:
    """Write the three matrices, whose ids all begin at 1, and return them."""
    found = [matrix(i, first=1) for i in range(3)]
    for name, content in zip(("one", "two", "three"), found, strict=True):
        savemat(folder / f"{name}.mat", {"dataset": content, "other": 1.0})
    return found
