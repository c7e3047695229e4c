"""Near-parallel axes: which joints of known robots have one, and what making them parallel changes."""

import numpy as np
import pytest

from scalar.geometry.parallel_axes import NEAR_PARALLEL, near_parallel_joints, with_parallel_axes
from scalar.geometry.robot import GEOMETRY
from tests.random_scene import make_scene

ALPHA = GEOMETRY.index("alpha")


def robot_of(name):
    """Return the nominal robot of a scene without errors."""
    return make_scene(name, poses_per_plane=3, length_error=0.0, angle_error=0.0).dataset.robot


@pytest.mark.parametrize(("name", "joints"), [("vs060", [3]), ("ur10e", [3, 4]), ("panda", [])])
def test_joints_whose_axes_run_parallel_to_the_one_before(name, joints):
    """The VS060 has one such joint, the UR10e two in a row, the Panda none, as the drawings in their data sheets show."""
    assert near_parallel_joints(robot_of(name)) == joints


@pytest.mark.parametrize("turn", [0.0, np.pi, -np.pi])
def test_the_limit_counts_from_either_sense_of_the_axis(turn):
    """An axis just within the limit is near-parallel and one just beyond is not, whichever way it points."""
    robot = robot_of("panda")
    for share, expected in ((0.99, [4]), (1.01, [])):
        geometry = robot.geometry.copy()
        geometry[ALPHA, 3] = turn + np.arcsin(share * NEAR_PARALLEL)
        assert near_parallel_joints(robot.with_geometry(geometry)) == expected


def test_making_axes_parallel_aligns_the_near_ones_and_leaves_the_others():
    """Successive axes become exactly parallel where they were nearly so; every other parameter stays as it was."""
    robot = robot_of("ur10e")
    rng = np.random.default_rng(0)
    tilted = robot.with_geometry(robot.geometry + 0.01 * rng.standard_normal(robot.geometry.shape))
    made = with_parallel_axes(tilted)
    z = made.frames(rng.standard_normal((5, 6)))[:, :, :3, 2]
    for joint in (3, 4):
        np.testing.assert_allclose(np.cross(z[:, joint - 1], z[:, joint]), 0.0, atol=1e-15)
    rest = np.ones_like(robot.geometry, dtype=bool)
    rest[[[ALPHA], [GEOMETRY.index("beta")]], [2, 3]] = False
    np.testing.assert_array_equal(made.geometry[rest], tilted.geometry[rest])
