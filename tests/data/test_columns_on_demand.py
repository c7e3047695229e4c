"""Columns of poses that are computed when they are asked for."""

import pickle
from functools import partial

from scalar.data.columns_on_demand import ColumnsOnDemand
from tests.random_scene import make_scene


def test_columns_are_computed_once_and_only_when_asked_for():
    """Nothing is computed until a column, a name or the number of columns is asked for, and then once."""
    calls = []
    columns = ColumnsOnDemand(lambda: calls.append(1) or {"time": 1, "payload": 2})
    assert not calls
    assert (columns["time"], list(columns), len(columns), "payload" in columns, columns.get("q9")) == (
        1, ["time", "payload"], 2, True, None,
    )  # fmt: skip
    assert calls == [1]


def test_poses_of_a_dataset_can_be_sent_to_another_process():
    """The columns of a dataset's poses survive pickling."""
    poses = make_scene(seed=1, poses_per_plane=4).dataset.known_poses
    again = pickle.loads(pickle.dumps(poses))
    assert {*again.columns} == {*poses.columns}
    assert isinstance(poses.columns, ColumnsOnDemand) and isinstance(poses.columns._compute, partial)
