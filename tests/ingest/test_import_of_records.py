"""Campaigns with several rows for each pose and no column that says so, records in YAML, and order by the recorded time."""

import numpy as np
import pytest
from scipy.io import savemat

from scalar.data.io.plain_yaml import load_yaml
from tests.ingest.foreign_tables import imported, refused, run
from tests.small_datasets import description

JOINTS = {f"q{i}": {"column": i, "unit": "deg"} for i in range(1, 7)}


def counted(rows_per_pose):
    """Return the mapping of two matrices: joint angles, and points of which each pose has some, in the order of the poses."""
    xyz = {name: {"column": k, "unit": "mm"} for k, name in enumerate("xyz", 1)}
    points = {"pose": {"column": "@pose"}, "target": {"column": "@row_of_pose"}, **xyz}
    return {
        "format": "scalar-mapping/1",
        "poses": {"files": [{"name": "q.mat"}], "columns": {"pose": {"column": "@row"}, **JOINTS}},
        "points": {"files": [{"name": "p.mat"}], "columns": points, **rows_per_pose},
        "dataset": description("tracker"),
    }


def write_matrices(folder, n_points):
    """Write five poses [deg] and so many points [mm], and return the points."""
    rng = np.random.default_rng(4)
    points = rng.uniform(-900, 900, (n_points, 3))
    savemat(folder / "q.mat", {"q": rng.uniform(-90, 90, (5, 6))})
    savemat(folder / "p.mat", {"p": points})
    return points


def test_rows_are_counted_by_pose(tmp_path):
    """Row 3 i + k is that of target k at pose i."""
    points = write_matrices(tmp_path, 15)
    imported(tmp_path, counted({"rows_per_pose": 3}), tmp_path)
    table = np.genfromtxt(tmp_path / "out/points.csv", delimiter=",", names=True)
    np.testing.assert_array_equal(table["pose"], np.repeat(np.arange(1, 6), 3))
    np.testing.assert_array_equal(table["target"], np.tile([1, 2, 3], 5))
    np.testing.assert_allclose(np.column_stack([table[c] for c in "xyz"]), points / 1e3)


@pytest.mark.parametrize(
    ("given", "words"), [({"rows_per_pose": 4}, "no multiple"), ({}, "needs points.rows_per_pose")]
)
def test_rows_that_cannot_be_counted_are_refused(tmp_path, given, words):
    """The message names the file and the key of the mapping."""
    write_matrices(tmp_path, 15)
    refused(tmp_path, run(tmp_path, counted(given), tmp_path), "p.mat", words)


def records_mapping():
    """Return the mapping of records with a list of joint angles and a list of coordinates."""
    columns = {f"q{i}": {"column": f"joints[{i}]", "unit": "rad"} for i in range(1, 7)}
    columns |= {name: {"column": f"prism[{k}]", "unit": "m"} for k, name in enumerate("xyz", 1)}
    columns |= {"pose": {"column": "id"}, "time": {"column": "time", "unit": "s"}}
    return {
        "format": "scalar-mapping/1",
        "poses": {"columns": columns},
        "dataset": description("tracker"),
    }


def write_records(path, times=(30.0, 10.0, 20.0)):
    """Write three records below keys that are numbers, and return their joint angles [rad]."""
    q = np.random.default_rng(5).uniform(-1, 1, (3, 6))
    heights = (1.5, 1.5, 2)
    lines = ["names: [a, b]", "heights:"]
    for i, height in enumerate(heights):
        if not i or height != heights[i - 1]:
            lines += [f"  {height}:", "    points:"]
        lines += [f"    - id: {i}", f"      time: {times[i]}", f"      joints: {q[i].tolist()}"]
        lines += [f"      prism: [0.{i + 1}, 0.5, 1.5]"]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return q


def test_records_of_yaml_are_rows_in_the_order_of_their_time(tmp_path):
    """Lists become numbered columns, records under all keys are taken, and the time orders the poses of a file."""
    q = write_records(tmp_path / "campaign.yaml")
    data = imported(tmp_path, records_mapping(), tmp_path / "campaign.yaml")
    table = np.genfromtxt(tmp_path / "out/poses.csv", delimiter=",", names=True)
    np.testing.assert_array_equal(table["order"], [2, 0, 1])
    np.testing.assert_allclose(np.column_stack([table[f"q{i}"] for i in range(1, 7)]), q)
    assert data.n_poses == 3


@pytest.mark.parametrize("content", ["a: 1\n", "- 1\n- 2\n"])
def test_a_document_without_records_is_refused(tmp_path, content):
    """The message says what a record looks like."""
    (tmp_path / "campaign.yaml").write_text(content, encoding="utf-8")
    refused(
        tmp_path, run(tmp_path, records_mapping(), tmp_path / "campaign.yaml"), "campaign.yaml", "records"
    )


def test_a_stated_tolerance_is_in_the_units_of_the_dataset(tmp_path):
    """A tolerance is converted from the mapping's units; it was once taken for metres and radians in any case."""
    write_records(tmp_path / "campaign.yaml")
    mapping = records_mapping()
    mapping["dataset"]["robot"]["tolerance"] = {"length": 0.5, "angle": 0.03}
    mapping["dataset_units"] = {"length": "mm", "angle": "deg"}
    for joint in mapping["dataset"]["robot"]["joints"]:
        joint.update(a=1e3 * joint["a"], d=1e3 * joint["d"])
        joint.update({key: float(np.rad2deg(joint[key])) for key in ("alpha", "theta")})
    imported(tmp_path, mapping, tmp_path / "campaign.yaml")
    tolerance = load_yaml(tmp_path / "out/dataset.yaml")["robot"]["tolerance"]
    assert tolerance["length"] == pytest.approx(5e-4)
    assert tolerance["angle"] == pytest.approx(np.deg2rad(0.03))
