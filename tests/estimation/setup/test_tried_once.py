"""Other readings of a set-up take seconds to try, and are tried once, however a dataset that none explains is refused."""

from dataclasses import replace

import numpy as np
import pytest

from scalar.data.moves import moves
from scalar.errors import Undetermined
from scalar.estimation import calibrate as module
from tests.random_scene import make_scene


@pytest.fixture(scope="module")
def scene():
    """Return a scene before a tracker."""
    return make_scene("vs060", "tracker", poses_per_plane=12, seed=4)


def test_readings_are_tried_once(scene, monkeypatch):
    """Measurements that are three rows late fit no pose; the search among other readings finds nothing, and is not repeated."""
    dataset = scene.dataset.subset(np.arange(scene.dataset.n_poses - 3))
    late = scene.dataset.subset(np.arange(3, scene.dataset.n_poses))
    tried = []
    monkeypatch.setattr(module, "refuse_wrong_setup", tried.append)
    columns = {name: late.poses[name].to_numpy() for name in late.poses if name.startswith("q")}
    shifted = replace(dataset, poses=dataset.poses.assign(**columns))
    with pytest.raises(Undetermined, match="row by row"):
        module.calibrate(shifted)
    assert len(tried) == 1


def test_poses_taken_out_keep_their_columns_and_moves(scene):
    """A subset has the rows of the table with the moves of the whole table, with the types of its columns; a subset of a subset keeps them."""
    dataset, rows = scene.dataset, np.array([9, 2, 5, 5])
    once = dataset.subset(rows)
    whole = dataset.poses.assign(**moves(dataset.poses, dataset.robot.slides))
    expected = whole.iloc[np.sort(rows)].reset_index(drop=True)
    assert once.poses.equals(expected) and (once.poses.dtypes == expected.dtypes).all()
    assert once.subset(np.array([0, 3])).poses.equals(expected.iloc[[0, 3]].reset_index(drop=True))
