"""On one path, a change in time may be an error that depends on the place."""

from dataclasses import replace

import numpy as np
import pytest

from scalar.diagnosis.naming.most_confidence import ONE_OF_TWO
from scalar.diagnosis.naming.one_path import TIME_OR_PLACE, limited_by_path
from scalar.effects.joint_scale import JointScale
from scalar.effects.target_drift import TargetDrift
from tests.diagnosis.stand_ins import finding_of
from tests.random_scene import make_scene

LEAST = 0.6


def dataset(on_path: bool):
    """Return 90 tracked poses, along a path or in random order."""
    data = make_scene(kind="tracker", seed=3, poses_per_plane=30).dataset
    s = np.linspace(0.0, 1.0, data.n_poses)
    q = np.stack([np.sin((1.5 + 0.2 * j) * s + j) for j in range(6)], axis=1)
    if not on_path:
        q = np.random.default_rng(3).permutation(q)
    return replace(data, poses=data.poses.assign(**{f"q{j + 1}": q[:, j] for j in range(6)}))


@pytest.mark.parametrize("on_path", [True, False])
def test_only_changes_in_time_lose_their_sureness_on_a_path(on_path):
    """A drift of the tracker has at most 0.5 on a path, for a stated reason; an error of a joint keeps what it has."""
    data = dataset(on_path)
    drift = next(e for e in TargetDrift.candidates(data) if e.is_change_in_time)
    found = [finding_of(drift, 0.99), finding_of(JointScale(4), 0.99)]
    first, second = limited_by_path(found, data, LEAST)
    assert second == found[1]
    assert (first.confidence, first.limit) == (
        (ONE_OF_TWO, TIME_OR_PLACE) if on_path else (0.99, found[0].limit)
    )
