"""Versions of the dataset's format: version 1 is still read; of version 2 nothing is ignored in silence."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from scalar.data.dataset import read_dataset, validate_dataset
from scalar.data.dataset_writer import write_dataset
from scalar.errors import InvalidInput
from tests import small_datasets

VERSION_1 = Path(__file__).parents[1] / "version_1"
"""Simulated datasets and a calibration, as the release before version 2 wrote them."""

LATER = ("qc1", "qc6", "tau1", "tau6", "payload", "payload_x", "payload_z")
N_JOINTS = 6


@pytest.mark.parametrize(
    ("folder", "points", "columns"), [("laser", 2, ()), ("tracker", 3, ("temperature",))]
)
def test_version_1_is_read(folder: str, points: int, columns: tuple[str, ...]) -> None:
    """A folder of version 1 gives the numbers that stand in its tables."""
    path = VERSION_1 / folder
    assert "format: scalar-dataset/1\n" in (path / "dataset.yaml").read_text(encoding="utf-8")
    dataset = read_dataset(path)
    poses = pd.read_csv(path / "poses.csv")
    np.testing.assert_array_equal(dataset.q, poses[[f"q{i}" for i in range(1, 7)]])
    for name in columns:
        np.testing.assert_array_equal(dataset.poses[name], poses[name])
    table = pd.read_csv(path / ("scans.csv" if folder == "laser" else "points.csv"))
    np.testing.assert_array_equal(dataset.points, table.iloc[:, 1:])
    assert dataset.points.shape[1] == points


def written(folder: Path, version: int, column: str) -> Path:
    """Write a small dataset of a version with a further column in poses.csv."""
    mapping = small_datasets.description("tracker") | {"format": f"scalar-dataset/{version}"}
    tables = small_datasets.tables("tracker")
    poses = tables["poses"].assign(**{column: np.linspace(0.0, 1.0, small_datasets.N_POSES)})
    write_dataset(folder, mapping=mapping, **tables | {"poses": poses})
    return folder


@pytest.mark.parametrize("stem", ["qc", "tau"])
def test_columns_of_version_2_come_for_all_joints_or_for_none(tmp_path: Path, stem: str) -> None:
    """One column alone is refused, every missing one by its name, and so is one of a joint that the robot lacks."""
    faults = validate_dataset(written(tmp_path / "d", 2, f"{stem}1"))
    assert [fault.column for fault in faults] == [f"{stem}{i}" for i in range(2, N_JOINTS + 1)]
    (fault,) = validate_dataset(written(tmp_path / "e", 2, f"{stem}7"))
    assert fault.column == f"{stem}7" and "joints 1 to 6" in fault.message


def test_commanded_positions_torques_and_payload_are_read(tmp_path: Path) -> None:
    """Commanded positions may take the place of those logged, and are no covariates; torques and the payload are."""
    mapping, tables = small_datasets.description("tracker"), small_datasets.tables("tracker")
    rng = np.random.default_rng(1)
    torques = {f"tau{i}": rng.normal(size=small_datasets.N_POSES) for i in range(1, N_JOINTS + 1)}
    commanded = {f"qc{i}": tables["poses"][f"q{i}"] + 1e-3 for i in range(1, N_JOINTS + 1)}
    load = {
        "payload": np.linspace(0, 5, small_datasets.N_POSES),
        "payload_z": np.full(small_datasets.N_POSES, 0.1),
    }
    write_dataset(
        tmp_path / "d",
        mapping=mapping,
        **tables | {"poses": tables["poses"].assign(**commanded, **torques, **load)},
    )
    dataset = read_dataset(tmp_path / "d")
    assert set(dataset.covariates) == {*torques, *load}
    np.testing.assert_allclose(dataset.commanded().q, dataset.q + 1e-3, atol=1e-15)
    write_dataset(tmp_path / "e", mapping=mapping, **tables)
    with pytest.raises(InvalidInput, match="leave out --commanded"):
        read_dataset(tmp_path / "e").commanded()
    heavy = tables["poses"].assign(payload=-1.0)
    write_dataset(tmp_path / "f", mapping=mapping, **tables | {"poses": heavy})
    assert all(fault.column == "payload" for fault in validate_dataset(tmp_path / "f"))
    assert validate_dataset(tmp_path / "f")


@pytest.mark.parametrize("column", LATER)
def test_in_version_1_the_same_columns_are_covariates(tmp_path: Path, column: str) -> None:
    """Version 1 gives these names no meaning: the column is kept, and offered as a covariate."""
    assert read_dataset(written(tmp_path / "d", 1, column)).covariates == (column,)


@pytest.mark.parametrize(("version", "kind", "files"), [(1, "tracker", []), (2, "probe", ["nests.csv"])])
def test_nests_belong_to_a_tracker_of_version_2(
    tmp_path: Path, version: int, kind: str, files: list[str]
) -> None:
    """``nests.csv`` has no meaning in version 1, and is refused by name with a sensor that measures none."""
    mapping = small_datasets.description(kind) | {"format": f"scalar-dataset/{version}"}
    write_dataset(tmp_path / "d", mapping=mapping, **small_datasets.tables(kind))
    small_datasets.write_text(tmp_path / "d", "nests.csv", "pose,nest,x,y,z", "10,1,0,0,0")
    assert [fault.file for fault in validate_dataset(tmp_path / "d")] == files


@pytest.mark.parametrize("column", ["target", "rx", "noise"])
def test_version_1_has_no_further_columns_of_points(tmp_path: Path, column: str) -> None:
    """A tracker's points of version 1 have their position alone; columns of version 2 are refused by name."""
    mapping = small_datasets.description("tracker") | {"format": "scalar-dataset/1"}
    tables = small_datasets.tables("tracker")
    tables["points"][column] = 1.0
    write_dataset(tmp_path / "d", mapping=mapping, **tables)
    (fault,) = validate_dataset(tmp_path / "d")
    assert (fault.file, fault.column) == ("points.csv", column)


def with_points(folder: Path, **columns: object) -> Path:
    """Write a small dataset of a tracker with further columns in points.csv."""
    tables = small_datasets.tables("tracker")
    tables["points"] = tables["points"].assign(**columns)
    write_dataset(folder, mapping=small_datasets.description("tracker"), **tables)
    return folder


@pytest.mark.parametrize(
    ("columns", "row", "column", "said"),
    [
        ({"noise": [1e-4] * 8 + [0.0]}, 10, "noise", "greater than 0"),
        ({"noise": [0.1] * 9}, 2, "noise", "millimetres"),
        ({"rx": 0.1, "ry": 0.1}, 1, "rz", "come together"),
        ({"rx": 90.0, "ry": 0.1, "rz": 0.1}, 2, "rx", "degrees"),
        ({"target": ["A"] * 8 + ["B C"]}, 10, "target", "letters"),
        ({"target": ["A"] * 8 + [""]}, 10, "target", "empty"),
        ({"pose": [10, 10, *range(12, 19)]}, 3, "pose", "in a column 'target'"),
        ({"pose": [10, 10, *range(12, 19)], "target": "A"}, 3, "target", "already in row 2"),
        ({"wobble": 1.0}, 1, "wobble", "unknown column"),
    ],
)
def test_faults_of_points_are_named(
    tmp_path: Path, columns: dict[str, object], row: int, column: str, said: str
) -> None:
    """Every wrong cell or column of points.csv is refused by its row and column, with what to do."""
    faults = validate_dataset(with_points(tmp_path / "d", **columns))
    found = [fault for fault in faults if fault.file == "points.csv"]
    assert [(fault.row, fault.column) for fault in found] == [(row, column)]
    assert said in found[0].message


@pytest.mark.parametrize("table_format", ["csv", "parquet"])
def test_further_columns_of_points_come_back_as_they_were(tmp_path: Path, table_format: str) -> None:
    """Targets, orientations and noises are read as they were written; a part of the poses keeps its own; rows may stand in any order."""
    rng = np.random.default_rng(1)
    tables = small_datasets.tables("tracker")
    ids = np.repeat(tables["poses"]["pose"].to_numpy(), 2)
    points = pd.DataFrame({"pose": ids, "target": ["B", "A"] * small_datasets.N_POSES})
    for name in ("x", "y", "z", "rx", "ry", "rz", "noise"):
        points[name] = rng.uniform(1e-4, 2e-4, len(points))
    shuffled = points.sample(frac=1.0, random_state=2)
    write_dataset(
        tmp_path / "d", mapping=small_datasets.description("tracker"), **tables | {"points": shuffled}
    )
    dataset = read_dataset(tmp_path / "d")
    dataset.write(tmp_path / "e", table_format=table_format)
    again = read_dataset(tmp_path / "e").subset(np.array([4, 2]))
    expected = points[points["pose"].isin(again.pose_ids)].set_index(["pose", "target"])
    for i, pose in enumerate(again.pose_ids):
        for k in range(*again.starts[i : i + 2]):
            name = again.targets[int(again.point_columns["target"][k])]
            row = expected.loc[(pose, name)]
            np.testing.assert_array_equal(again.points[k], row[["x", "y", "z"]])
            for column in ("rx", "ry", "rz", "noise"):
                assert again.point_columns[column][k] == row[column]
