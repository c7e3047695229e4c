"""One or two planes, and parallel ones, are calibrated if dataset.yaml says that there are no more, with errors as large as is stated."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from scalar.data.dataset import Dataset, read_dataset
from scalar.data.dataset_writer import write_dataset
from scalar.errors import Undetermined
from scalar.estimation.calibrate import calibrate
from scalar.estimation.result import load_calibration
from scalar.geometry.robot import Tolerance
from scalar.report.unseen_directions_words import unseen_directions_in_words
from tests.cli.running import UNDETERMINED, refused, run
from tests.random_scene import make_scene
from tests.workcell import Scene

FLOOR, WALL = np.array([0.0, 0, 1]), np.array([1.0, 0, 0])
PARALLEL = (np.array([FLOOR, WALL, WALL]), np.array([0.0, 0.48, 0.40]))
LENGTH, ANGLE = 5e-4, 1e-3
"""Errors of the simulated tables [m, rad], one standard deviation; the tolerance that is stated."""


def scene_before(planes: tuple[str, ...], seed: int = 3, **settings: object) -> Scene:
    """Return a cell whose dataset has the poses on some of its planes alone and says that there are no more."""
    scene = make_scene(
        **{
            "points_per_scan": 12,
            "poses_per_plane": 60,
            "seed": seed,
            "length_error": LENGTH,
            "angle_error": ANGLE,
            **settings,
        }
    )
    data = scene.dataset
    data = data.subset(np.isin(data.poses["plane"].to_numpy(), planes))
    robot = replace(data.robot, tolerance=Tolerance(LENGTH, ANGLE))
    kept = tuple(plane for plane in data.planes if plane.name in planes)
    return replace(scene, dataset=replace(data, robot=robot, planes=kept, few_planes=True))


CASES = [
    (("floor", "wall_x"), {}),
    (("floor",), {}),
    (("floor", "wall_x", "wall_y"), {"target_planes": PARALLEL}),
    (("floor", "wall_x"), {"kind": "probe", "poses_per_plane": 120}),
]


@pytest.mark.parametrize(("planes", "settings"), CASES)
def test_errors_are_as_large_as_is_stated(planes, settings):
    """Over the workspace of several arms, no position error (RMS) is above 2.5 times what is stated, and half of them are below 1.3 times."""
    ratios = []
    for seed in range(7):
        scene = scene_before(planes, seed, **settings)
        calibration = calibrate(scene.dataset)
        truth = scene.truth.poses(60, np.random.default_rng(seed))
        q = truth[[f"q{i + 1}" for i in range(scene.dataset.robot.n_joints)]].to_numpy()
        error = truth[["x", "y", "z"]].to_numpy() - calibration.predict(q)[:, :3, 3]
        stated = np.trace(calibration.predict_covariance(q)[:, :3, :3], axis1=1, axis2=2)
        ratios.append(np.sqrt(np.mean(np.sum(error**2, axis=1)) / np.mean(stated)))
    assert max(ratios) < 2.5
    assert np.median(ratios) < 1.3


def written(data: Dataset, folder: Path, *, few: bool) -> Path:
    """Write a dataset that does or does not say that there are no more planes."""
    replace(data, few_planes=few).write(folder)
    return folder


def test_the_summary_says_which_directions_the_planes_do_not_show(tmp_path):
    """With two planes the direction of their common line is named; it comes back from the saved calibration, and the page says it too."""
    scene = scene_before(("floor", "wall_x"))
    folder = written(scene.dataset, tmp_path / "cell", few=True)
    assert read_dataset(folder).few_planes
    assert run("validate", folder).exit_code == 0
    result = run("calibrate", folder, "-o", tmp_path / "out", "--report")
    assert result.exit_code == 0, result.output
    assert "the planes do not show a shift of the sensor along [" in result.stdout
    calibration = load_calibration(tmp_path / "out" / "calibration.json")
    (along,) = calibration.summary["unseen_directions"]["directions"]
    normals = scene.truth.normals[:2]
    line = np.cross(*normals) / np.linalg.norm(np.cross(*normals))
    assert abs(np.dot(along, line)) > np.cos(np.radians(1.0))
    assert calibration.summary["few_planes"] is True
    assert unseen_directions_in_words(calibration) in result.stdout
    assert "planes do not show a shift" in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")


def test_spanning_planes_say_nothing(tmp_path):
    """Three planes at right angles show every direction, and nothing is said or saved."""
    calibration = calibrate(make_scene(points_per_scan=12, poses_per_plane=20, seed=3).dataset)
    assert unseen_directions_in_words(calibration) == ""
    assert not {"few_planes", "unseen_directions"} & calibration.summary.keys()


def test_arrays_need_the_same_statement():
    """Without it, a dataset in memory with parallel planes is refused, and the message ends with the way out."""
    scene = scene_before(("floor", "wall_x", "wall_y"), target_planes=PARALLEL)
    with pytest.raises(Undetermined, match=r"parallel.*few_planes: true"):
        calibrate(replace(scene.dataset, few_planes=False))


def test_one_plane_with_few_poses_needs_a_tolerance(tmp_path):
    """Where one plane leaves parameters to the data sheet, and nobody states how exact that is, the calibration is refused with what to state."""
    scene = scene_before(("floor",), poses_per_plane=20)
    robot = replace(scene.dataset.robot, tolerance=None)
    folder = written(replace(scene.dataset, robot=robot), tmp_path / "cell", few=True)
    result = run("calibrate", folder, "-o", tmp_path / "out")
    refused(result, UNDETERMINED, "robot.tolerance", "faces another way", output=tmp_path / "out")
    calibrate(scene.dataset)


def test_a_batch_reads_the_statement_of_each_dataset(tmp_path):
    """Of two datasets before the same two planes, the one that says that there are no more is diagnosed, and the other refused."""
    data = scene_before(("floor", "wall_x"), poses_per_plane=25).dataset
    written(data, tmp_path / "cells" / "said", few=True)
    tables = {"poses": data.poses, "scans": scans_of(data)}
    mapping = json.loads(json.dumps(scene_before(("floor", "wall_x"), poses_per_plane=25).mapping()))
    write_dataset(tmp_path / "cells" / "unsaid", mapping=mapping, **tables)
    result = run("diagnose", "--batch", tmp_path / "cells", "-o", tmp_path / "out", "--quick")
    assert result.exit_code == 2, result.output
    assert (tmp_path / "out" / "said" / "after.json").exists()
    assert not (tmp_path / "out" / "unsaid" / "after.json").exists()
    assert "few_planes: true" in (tmp_path / "out" / "fleet.csv").read_text(encoding="utf-8")


def scans_of(data: Dataset):
    """Return the rows of scans.csv."""
    scene = Scene(data, None, data.points, 1e-4)  # type: ignore[arg-type]
    return scene.tables()["scans"]
