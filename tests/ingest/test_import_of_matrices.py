"""Imported MATLAB matrices: the first row of each pose is taken, and a matrix or source that does not fit is refused by name."""

import numpy as np
import pytest
from scipy.io import savemat

from tests.ingest.foreign_tables import cells, imported, refused, run, tracker_mapping, write_table
from tests.ingest.matrices import mat_mapping, write_matrices


def test_a_matrix_with_several_rows_for_each_pose(tmp_path):
    """The first row of each id is the pose; files follow one another as the mapping lists them."""
    given = write_matrices(tmp_path)
    data = imported(tmp_path, mat_mapping(), tmp_path)
    first = np.concatenate([content[np.unique(content[:, 0], return_index=True)[1]] for content in given])
    np.testing.assert_array_equal(data.q, first[:, 2:])
    assert list(data.poses["plane"]) == [name for name in ("floor", "wall_x", "wall_y") for _ in range(5)]
    np.testing.assert_array_equal(data.poses["repetition"], np.repeat([0, 1, 2], 5))
    np.testing.assert_array_equal(data.pose_ids, np.arange(15))
    shuffled = [tmp_path / name for name in ("three.mat", "one.mat", "two.mat")]
    np.testing.assert_array_equal(imported(tmp_path, mat_mapping(), *shuffled).q, data.q)


def test_first_of_each_does_not_join_poses_that_differ(tmp_path):
    """Rows with the same id and different angles are two poses: the row is refused, not dropped."""
    given = write_matrices(tmp_path)[1]
    given[2, 4] += 0.5
    savemat(tmp_path / "two.mat", {"dataset": given})
    refused(tmp_path, run(tmp_path, mat_mapping(), tmp_path), "two.mat, row 3, column 5", "q3", "row 1")


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ({"dataset": np.zeros((0, 8))}, ("no rows",)),
        ({"dataset": np.zeros((3, 4))}, ("no column 8", "4")),
        ({"data": np.zeros((3, 8))}, ("no variable 'dataset'",)),
        ({"dataset": "text"}, ("not a matrix",)),
        ({"dataset": {"a": 1.0}}, ("not a matrix",)),
        ({"dataset": np.full((1, 8), np.nan)}, ("row 1, column 3", "empty")),
        (b"MATLAB 7.3 MAT-file, or so", ("damaged",)),
        (b"", ("damaged",)),
    ],
)
def test_a_file_without_a_fitting_matrix_is_refused(tmp_path, content, words):
    """The message names the file, and the row and column if there are any."""
    write_matrices(tmp_path)
    if isinstance(content, bytes):
        (tmp_path / "two.mat").write_bytes(content)
    else:
        savemat(tmp_path / "two.mat", content)
    refused(tmp_path, run(tmp_path, mat_mapping(), tmp_path), "two.mat", *words)


def test_a_source_that_is_missing_or_not_meant_is_refused(tmp_path):
    """Refused are a missing file, a file that the mapping does not name, and a folder if the mapping names no files."""
    write_matrices(tmp_path)
    refused(tmp_path, run(tmp_path, tracker_mapping(), tmp_path / "none.csv"), "none.csv", "no such file")
    refused(tmp_path, run(tmp_path, tracker_mapping(), tmp_path), str(tmp_path), "names no files")
    other = write_table(tmp_path / "a.csv", cells())
    refused(tmp_path, run(tmp_path, mat_mapping(), tmp_path, other), "a.csv", "no such file, only one.mat")
    (tmp_path / "two.mat").unlink()
    refused(tmp_path, run(tmp_path, mat_mapping(), tmp_path), "two.mat", "not among the sources")
