"""A folder with a table of poses, and the mapping with which profiles of a scanner are imported together with it."""

import numpy as np
import pandas as pd
from click.testing import CliRunner

from scalar.cli import cli
from scalar.data.dataset import read_dataset

RNG = np.random.default_rng(3)
POSES = 6
PLANES = ["floor", "wall_x", "wall_y"] * 2
X = np.round(np.linspace(-30.0, 30.0, 25), 4)
Z = np.round(200.0 + 5.0 * RNG.random((POSES, 25)), 4)  # mm
Q = np.round(RNG.uniform(-90, 90, (POSES, 2)), 4)  # deg

DESCRIPTION = """
dataset_units: {length: mm, angle: deg}
dataset:
  name: cell
  robot:
    name: two
    convention: modified-dh
    joints: [{a: 0, alpha: 0, d: 300, theta: 0}, {a: 400, alpha: 90, d: 0, theta: 0}]
  sensor: {kind: line-laser, nominal_pose: {translation: [0, 0, 10], rotation_euler: {axes: ZYX, angles: [90, 0, 180]}}}
  planes:
    - {name: floor, normal: [0, 0, 1], distance: 0}
    - {name: wall_x, normal: [1, 0, 0], distance: 800}
    - {name: wall_y, normal: [0, 1, 0], distance: 800}
"""
POSES_BLOCK = """
format: scalar-mapping/1
poses:
  columns:
    pose: {column: id}
    plane: {column: target}
    q1: {column: A1, unit: deg}
    q2: {column: A2, unit: deg}
  files: [{name: poses.csv}]
"""


def folder_of_poses(tmp_path):
    """Return a folder with the table of poses, whose ids begin at 11."""
    table = {"id": np.arange(11, 11 + POSES), "target": PLANES, "A1": Q[:, 0], "A2": Q[:, 1]}
    pd.DataFrame(table).to_csv(tmp_path / "poses.csv", index=False)
    return tmp_path


def imported(folder, mapping, *sources):
    """Return status and output of an import, and the dataset where there is one."""
    (folder / "m.yaml").write_text(mapping, encoding="utf-8")
    arguments = ["import", str(folder / "m.yaml"), *map(str, sources or [folder]), "-o", str(folder / "d")]
    result = CliRunner().invoke(cli, arguments)
    return result.exit_code, result.output, read_dataset(folder / "d") if result.exit_code == 0 else None


def points_block(files, columns="pose: {column: '@file_number'}"):
    """Return a mapping whose points are in separate files."""
    return POSES_BLOCK + (
        f"points:\n  columns:\n    {columns}\n    x: {{column: x, unit: mm}}\n    z: {{column: z, unit: mm}}\n"
        f"  drop_without: [z]\n  files: [{{name: '{files}'}}]\n" + DESCRIPTION
    )


def check(dataset, lost=0):
    """Compare a dataset with the numbers written, in radians and metres, without the first ``lost`` points of each scan."""
    np.testing.assert_allclose(dataset.q, np.deg2rad(Q), atol=1e-12)
    for k in range(POSES):
        mine = dataset.points[dataset.starts[k] : dataset.starts[k + 1]]
        np.testing.assert_allclose(mine, np.column_stack([X, Z[k]])[lost:] / 1e3, atol=1e-12)
