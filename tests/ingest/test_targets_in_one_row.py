"""Tables whose rows measure several targets on the flange: each target becomes a row of points.csv, and a target that was not seen is left out."""

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from tests.ingest.foreign_tables import imported, joints, refused, run
from tests.small_datasets import description


def table(folder: Path, without: int | None = None) -> tuple[Path, np.ndarray]:
    """Write six poses with two targets each, the second one of row ``without`` empty; return the file and the positions ``(6, 2, 3)`` [mm]."""
    rng = np.random.default_rng(5)
    angles, points = np.round(rng.uniform(-2, 2, (6, 6)), 4), np.round(rng.uniform(-3000, 3000, (6, 2, 3)), 3)
    lines = [",".join([*(f"J{i}" for i in range(1, 7)), *(f"{c}{k}" for k in (1, 2) for c in "XYZ")])]
    for row, (q, at) in enumerate(zip(angles, points, strict=True)):
        cells = [f"{value}" for value in (*q, *at.ravel())]
        lines.append(",".join([*cells[:9], *(["", "", ""] if row == without else cells[9:])]))
    path = folder / "campaign.csv"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path, points


def mapping(**points: Any) -> dict[str, Any]:
    """Return the mapping of that table, with further keys of the block ``points``."""
    targets = {
        name: {c: {"column": f"{c.upper()}{k}", "unit": "mm"} for c in "xyz"}
        for k, name in ((1, "left"), (2, "right"))
    }
    return {
        "format": "scalar-mapping/1",
        "poses": {"files": [{"name": "campaign.csv"}], "columns": {"pose": {"column": "@row"}, **joints()}},
        "points": {
            "files": [{"name": "campaign.csv"}],
            "columns": {"pose": {"column": "@row"}},
            "targets": targets,
            **points,
        },
        "dataset": description("tracker"),
    }


def test_each_target_of_a_row_is_a_point(tmp_path):
    """The points of a row follow one another in the order of the mapping, all with the row's pose."""
    path, points = table(tmp_path)
    data = imported(tmp_path, mapping(), path)
    assert data.n_poses == 6 and data.targets == ("left", "right")
    written = pd.read_csv(tmp_path / "out/points.csv")
    assert list(written["pose"]) == [pose for pose in range(1, 7) for _ in range(2)]
    assert list(written["target"]) == ["left", "right"] * 6
    np.testing.assert_allclose(written[["x", "y", "z"]], points.reshape(12, 3) * 1e-3, atol=1e-12)


def test_a_target_that_was_not_seen_is_left_out(tmp_path):
    """An empty target is a fault of its row and columns unless the mapping leaves such targets out; the other target of the row is kept."""
    path, points = table(tmp_path, without=3)
    refused(tmp_path, run(tmp_path, mapping(), path), "campaign.csv, row 5, column X2", "empty")
    imported(tmp_path, mapping(drop_without=["x", "y", "z"]), path)
    kept = np.delete(points.reshape(12, 3), 7, axis=0)
    written = pd.read_csv(tmp_path / "out/points.csv")
    np.testing.assert_allclose(written[["x", "y", "z"]], kept * 1e-3, atol=1e-12)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda m: m["points"]["targets"]["left"].pop("y"), ("points.targets.left.y", "missing")),
        (
            lambda m: m["points"]["targets"]["left"].update(w={"column": "W"}),
            ("points.targets.left.w", "unknown"),
        ),
        (
            lambda m: m["points"]["columns"].update(x={"column": "X1", "unit": "mm"}),
            ("points.targets.left.x", "keep one"),
        ),
        (
            lambda m: m["points"]["columns"].update(target={"column": "X1"}),
            ("points.columns.target", "unknown"),
        ),
        (lambda m: m["points"]["targets"]["left"]["x"].pop("unit"), ("points.targets.left.x.unit", "mm")),
        (
            lambda m: m.update(dataset=description("line-laser")),
            ("points.targets", "only a tracker"),
        ),
    ],
)
def test_a_faulty_mapping_of_targets_is_refused(tmp_path, change, words):
    """The message names the key of the mapping."""
    path, _ = table(tmp_path)
    faulty = mapping()
    change(faulty)
    refused(tmp_path, run(tmp_path, faulty, path), *words)
