"""Files that ``scalar`` imports: good ones to damage, and functions that read them and return what was read."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import numpy as np

from scalar.data.io.plain_yaml import dump_yaml
from tests.random_scene import make_scene
from tests.robot_descriptions import random_description
from tests.small_datasets import description, tables


def write_mapping_files(folder: Path) -> None:
    both = tables("tracker")
    mapping = {
        "format": "scalar-mapping/1",
        "poses": {
            "files": [{"name": "table.csv"}],
            "columns": {
                **{f"q{i}": {"column": f"q{i}", "unit": "deg", "sign": -1} for i in range(1, 7)},
                **{c: {"column": c, "unit": "mm"} for c in "xyz"},
            },
        },
        "dataset": description("tracker"),
    }
    dump_yaml(mapping, folder / "mapping.yaml")
    both["poses"].merge(both["points"]).to_csv(folder / "table.csv", index=False)


def read_mapping_files(folder: Path) -> Any:
    from scalar.ingest.convert import import_dataset

    target = folder.with_name(folder.name + "-imported")
    try:
        import_dataset(folder / "mapping.yaml", [folder / "table.csv"], target)
        return {path.name: path.read_text() for path in sorted(target.iterdir())}
    finally:
        shutil.rmtree(target, ignore_errors=True)


def write_urdf_file(folder: Path) -> None:
    (folder / "arm.urdf").write_text(random_description(np.random.default_rng(3), 5))


def read_urdf_file(folder: Path) -> Any:
    from scalar.ingest.urdf import robot_from_urdf

    robot, T = robot_from_urdf(folder / "arm.urdf", tip="tip")
    return robot.to_mapping(), T.tolist()


def write_dh_file(folder: Path) -> None:
    rows = [
        "a_m,alpha_rad,d_m,theta_rad,lower_rad,upper_rad",
        *(f"0.1,{k % 2},0.2,0.0,-2.5,2.5" for k in range(1, 7)),
    ]
    (folder / "dh.csv").write_text("\n".join(rows) + "\n")


def read_dh_file(folder: Path) -> Any:
    from scalar.ingest.dh_table import robot_from_dh_table

    return robot_from_dh_table(folder / "dh.csv", "modified-dh", "arm")


def write_bag_file(folder: Path) -> None:
    from tests.ingest.bags import write_bag

    scene = make_scene("vs060", "line-laser", poses_per_plane=1, points_per_scan=20)
    write_bag(scene.dataset, folder / "campaign.bag", 1, "LaserScan")


def read_bag_file(folder: Path) -> Any:
    from scalar.ingest.bag.messages import read_bag

    recording = read_bag(folder / "campaign.bag")
    return recording.positions.tolist(), len(recording.scans)
