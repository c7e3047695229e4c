"""Well-formed datasets that cannot determine the model, or that contradict themselves, are refused."""

from dataclasses import replace

import numpy as np
import pytest

from scalar.data.dataset_writer import write_dataset
from tests.cli.running import INPUT_AT_FAULT, UNDETERMINED, refused, run
from tests.random_scene import make_scene
from tests.workcell import Scene

FLOOR, WALL = np.array([0.0, 0, 1]), np.array([1.0, 0, 0])


def in_cell(**settings) -> Scene:
    """Return a small workcell that is calibrated quickly."""
    return make_scene(**{"points_per_scan": 12, "seed": 3, **settings})


def only(scene: Scene, rows: np.ndarray) -> Scene:
    """Return the scene with some of its poses, each with an id of its own."""
    data = scene.dataset.subset(rows)
    poses = data.poses.assign(pose=np.arange(1, data.n_poses + 1))
    return replace(scene, dataset=replace(data, poses=poses))


def line_on_a_wall() -> Scene:
    """Return a cell in which one wall is scanned from a single pose, again and again."""
    scene = in_cell()
    index = scene.dataset.plane_index
    return only(
        scene, np.sort(np.r_[np.flatnonzero(index != 2), np.repeat(np.flatnonzero(index == 2)[0], 20)])
    )


def contacts_on_a_line() -> Scene:
    """Return a probe's cell in which one wall is touched in two places only."""
    scene = in_cell(kind="probe")
    index = scene.dataset.plane_index
    return only(
        scene, np.sort(np.r_[np.flatnonzero(index != 2), np.repeat(np.flatnonzero(index == 2)[:2], 20)])
    )


def declared_parallel() -> Scene:
    """Return a cell whose dataset.yaml says that two walls are parallel, while the scans say otherwise."""
    scene = in_cell()
    floor, wall_x, wall_y = scene.dataset.planes
    planes = (floor, wall_x, replace(wall_y, normal=wall_x.normal))
    return replace(scene, dataset=replace(scene.dataset, planes=planes))


def swapped_names() -> Scene:
    """Return a cell whose two walls have each other's name in poses.csv."""
    scene = in_cell()
    other = scene.dataset.poses["plane"].map({"floor": "floor", "wall_x": "wall_y", "wall_y": "wall_x"})
    return replace(scene, dataset=replace(scene.dataset, poses=scene.dataset.poses.assign(plane=other)))


PARALLEL = (np.array([FLOOR, WALL, WALL]), np.array([0.0, 0.48, 0.40]))
NEARLY = (np.array([FLOOR, WALL, [np.cos(0.1), np.sin(0.1), 0.0]]), np.array([0.0, 0.48, 0.40]))


@pytest.mark.parametrize(("make", "status", "words"), [
    (lambda: in_cell(target_planes=PARALLEL), UNDETERMINED, ["wall_x and wall_y", "parallel", "third", "few_planes: true"]),
    pytest.param(lambda: in_cell(target_planes=NEARLY), UNDETERMINED, ["wall_x and wall_y", "degrees from parallel"], marks=pytest.mark.slow),
    pytest.param(lambda: in_cell(target_planes=PARALLEL, nominal_pose=False), UNDETERMINED, ["parallel"], marks=pytest.mark.slow),
    pytest.param(declared_parallel, INPUT_AT_FAULT, ["dataset.yaml", "planes.wall_y.normal", "correct the normal"], marks=pytest.mark.slow),
    pytest.param(swapped_names, INPUT_AT_FAULT, ["'wall_x'", "'wall_y'", "exchanged in poses.csv"], marks=pytest.mark.slow),
    pytest.param(line_on_a_wall, UNDETERMINED, ["plane 'wall_y'", "lie on a line"], marks=pytest.mark.slow),
    (contacts_on_a_line, UNDETERMINED, ["plane 'wall_y'", "lie on a line"]),
    pytest.param(lambda: in_cell(poses_per_plane=5), UNDETERMINED, ["30 equations for 32 unknowns", "1 more"], marks=pytest.mark.slow),
    (lambda: in_cell(poses_per_plane=1), UNDETERMINED, ["3 poses give 6 equations", "more"]),
    (lambda: in_cell(poses_per_plane=1, nominal_pose=False), UNDETERMINED, ["3 poses give 6 equations"]),
    (lambda: in_cell(kind="probe", poses_per_plane=3), UNDETERMINED, ["9 poses give 9 equations", "more"]),
    (lambda: only(in_cell(kind="tracker"), np.arange(1)), UNDETERMINED, ["1 pose gives 3 equations", "more"]),
    (lambda: only(in_cell(kind="tracker"), np.arange(4)), UNDETERMINED, ["4 poses give 12 equations"]),
])  # fmt: skip
def test_what_cannot_be_determined_is_refused(make, status, words, tmp_path):
    """A well-formed dataset that does not determine the model is refused with its status and with words that say what to do."""
    make().write(tmp_path / "dataset")
    assert run("validate", tmp_path / "dataset").exit_code == 0
    result = run("calibrate", tmp_path / "dataset", "-o", tmp_path / "out")
    refused(result, status, *words, output=tmp_path / "out")


def test_fewer_than_three_planes_are_refused(tmp_path):
    """Two planes in dataset.yaml, or three of which one was never measured, are refused before any fit."""
    scene = in_cell()
    two = only(scene, scene.dataset.plane_index != 2)
    mapping = two.mapping()
    for case, planes in (("measured", mapping["planes"]), ("declared", mapping["planes"][:2])):
        write_dataset(tmp_path / case, mapping={**mapping, "planes": planes}, **two.tables())
        result = run("calibrate", tmp_path / case, "-o", tmp_path / "out")
        refused(result, INPUT_AT_FAULT, "three", "few_planes: true", output=tmp_path / "out")
