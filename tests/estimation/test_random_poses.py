"""Random poses within joint limits are the same for the same arm, and those with joint angles alone are those of the poses with all columns."""

from dataclasses import replace

import numpy as np
import pytest

from scalar.estimation.prepare import prepare
from scalar.estimation.random_poses import joints_within, random_joints, random_poses
from tests.random_scene import make_scene


def test_joint_angles_alone_are_those_of_the_poses_with_all_columns():
    """To rounding, for an arm with limits of its own for each joint; another arm has other poses."""
    model = prepare(make_scene(seed=2, poses_per_plane=20).dataset).coarse
    limits = np.array([[-1.0 - k, 0.5 * k] for k in range(model.nominal.n_joints)])
    own = replace(model, nominal=replace(model.nominal, limits=limits))
    found = random_joints(own, 50)
    np.testing.assert_allclose(found.q, random_poses(own, 50).q, rtol=1e-14, atol=1e-14)
    assert np.all((found.q >= limits[:, 0]) & (found.q <= limits[:, 1]))
    assert not np.array_equal(found.q, random_joints(model, 50).q)


def test_poses_that_are_kept_cannot_be_changed():
    """Who asks again gets the same poses, so nobody may write into them; another seed or number gives others."""
    limits = np.array([[-2.0, 1.0], [0.0, 3.0]])
    found = joints_within(limits, 30, seed=0)
    assert joints_within(limits.copy(), 30, seed=0) is found
    with pytest.raises(ValueError, match="read-only"):
        found.q[0] = 0.0
    assert not np.array_equal(joints_within(limits, 30, seed=1).q, found.q)
    assert len(joints_within(limits, 31, seed=0)) == 31
