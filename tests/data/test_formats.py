"""Versions of the dataset's format: version 1 is still read; of version 2 nothing is ignored in silence."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from scalar.data.dataset import read_dataset, validate_dataset
from scalar.data.dataset_writer import write_dataset
from tests import small_datasets

VERSION_1 = Path(__file__).parents[1] / "version_1"
"""Simulated datasets and a calibration, as the release before version 2 wrote them."""

LATER = ("qc1", "qc6", "tau1", "tau6", "payload", "payload_x", "payload_z")


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


@pytest.mark.parametrize("column", LATER)
def test_columns_of_version_2_that_are_not_supported_are_refused_by_name(tmp_path: Path, column: str) -> None:
    """In version 2 the column has a meaning; a release that does not act upon it refuses the dataset, and names it."""
    (fault,) = validate_dataset(written(tmp_path / "d", 2, column))
    assert (fault.file, fault.column) == ("poses.csv", column)
    assert "does not support" in fault.message


@pytest.mark.parametrize("column", LATER)
def test_in_version_1_the_same_columns_are_covariates(tmp_path: Path, column: str) -> None:
    """Version 1 gives these names no meaning: the column is kept, and offered as a covariate."""
    assert read_dataset(written(tmp_path / "d", 1, column)).covariates == (column,)


@pytest.mark.parametrize(("version", "refused"), [(1, False), (2, True)])
def test_nests_are_refused_in_version_2(tmp_path: Path, version: int, refused: bool) -> None:
    """``nests.csv`` belongs to version 2 and is not read yet: refused there, of no meaning in version 1."""
    folder = written(tmp_path / "d", version, "humidity")
    small_datasets.write_text(folder, "nests.csv", "pose,nest,x,y,z", "10,1,0,0,0")
    assert [fault.file for fault in validate_dataset(folder)] == (["nests.csv"] if refused else [])


@pytest.mark.parametrize("column", ["target", "rx", "noise"])
def test_columns_of_points_that_are_not_supported_are_refused_by_name(tmp_path: Path, column: str) -> None:
    """A tracker's points have their position alone; further columns of version 2 are refused by name."""
    tables = small_datasets.tables("tracker")
    tables["points"][column] = 1.0
    write_dataset(tmp_path / "d", mapping=small_datasets.description("tracker"), **tables)
    (fault,) = validate_dataset(tmp_path / "d")
    assert (fault.file, fault.column) == ("points.csv", column)
