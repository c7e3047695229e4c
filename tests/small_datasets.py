"""Small valid datasets for the tests of the reader: numbers without meaning, in the right form."""

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

N_POSES = 9
POINTS_PER_SCAN = 4
PLANES = ("floor", "wall_x", "wall_y")


def description(kind: str = "line-laser") -> dict[str, Any]:
    """Return the content of a valid dataset.yaml for a 6-joint arm."""
    half = 1.5707963267948966
    joints = [{"a": 0.1 * i, "alpha": half * (i % 2), "d": 0.2, "theta": 0.0} for i in range(6)]
    mapping: dict[str, Any] = {
        "format": "scalar-dataset/2",
        "name": "small",
        "robot": {"name": "arm", "convention": "modified-dh", "joints": joints},
        "sensor": {
            "kind": kind,
            "nominal_pose": {"translation": [0.05, 0.02, 0.1], "rotation_vector": [0.1, 0.0, 0.0]},
            "noise": 1e-4,
        },
    }
    if kind != "tracker":
        mapping["planes"] = [
            {"name": name, "normal": list(row), "distance": 0.5}
            for name, row in zip(PLANES, np.eye(3).tolist(), strict=True)
        ]
    return mapping


def tables(kind: str = "line-laser") -> dict[str, pd.DataFrame]:
    """Return the tables that go with `description`, as keywords of `write_dataset`."""
    rng = np.random.default_rng(1)
    ids = np.arange(10, 10 + N_POSES)
    poses = pd.DataFrame({"pose": ids})
    if kind != "tracker":
        poses["plane"] = np.resize(np.array(PLANES, dtype=object), N_POSES)
    for i in range(6):
        poses[f"q{i + 1}"] = rng.uniform(-3.0, 3.0, N_POSES)
    if kind == "line-laser":
        x, z = rng.uniform(-0.05, 0.3, (2, N_POSES * POINTS_PER_SCAN))
        return {
            "poses": poses,
            "scans": pd.DataFrame({"pose": np.repeat(ids, POINTS_PER_SCAN), "x": x, "z": z}),
        }
    if kind == "tracker":
        x, y, z = rng.uniform(-3.0, 3.0, (3, N_POSES))
        return {"poses": poses, "points": pd.DataFrame({"pose": ids, "x": x, "y": y, "z": z})}
    return {"poses": poses}


def write_text(folder: Path, file: str, *lines: str) -> None:
    """Write lines of text to a file of a dataset."""
    (folder / file).write_text("\n".join(lines) + "\n", encoding="utf-8")


def edit_lines(folder: Path, file: str, edit: Any) -> None:
    """Replace the list of a file's lines by what `edit` returns for it."""
    lines = (folder / file).read_text(encoding="utf-8").splitlines()
    write_text(folder, file, *edit(lines))


def edit_cell(folder: Path, file: str, row: int, column: str, text: str) -> None:
    """Write `text` into one cell of a CSV file; row as an editor counts, the header is row 1."""

    def edit(lines: list[str]) -> list[str]:
        cells = lines[row - 1].split(",")
        cells[lines[0].split(",").index(column)] = text
        return [*lines[: row - 1], ",".join(cells), *lines[row:]]

    edit_lines(folder, file, edit)
