"""Poses planned in addition to measured ones: what both are expected to show together, and what is needed of the planned ones."""

from dataclasses import replace

import numpy as np
import pytest

from scalar.planning.candidates import draw_candidates
from scalar.planning.information import information
from scalar.planning.plan import choose_poses, error_of, least_poses, poses_for_error
from scalar.planning.workcell import Workcell
from scalar.units import MM
from tests.random_scene import make_scene

REPEATABILITY = 0.02 * MM


@pytest.fixture(scope="module")
def scene():
    """Return measured scans of three planes, their workcell, and candidates of further poses."""
    dataset = make_scene(seed=4, poses_per_plane=20, points_per_scan=10).dataset
    workcell = Workcell.of(
        dataset.robot, replace(dataset.sensor, noise=1e-4), dataset.planes, repeatability=REPEATABILITY
    )
    return dataset, workcell, draw_candidates(workcell, 200, np.random.default_rng(0))


def test_both_together_are_one_campaign(scene):
    """The error that is expected of measured and planned poses is that of one campaign with the poses of both."""
    dataset, workcell, found = scene
    measured = workcell.dataset(dataset.q, dataset.plane_index)
    info = information(
        workcell.model, workcell.dataset(found.q, found.plane), REPEATABILITY, measured=measured
    )
    chosen = list(range(25))
    both = workcell.dataset(
        np.vstack([dataset.q, found.q[chosen]]), np.r_[dataset.plane_index, found.plane[chosen]]
    )
    one = information(workcell.model, both, REPEATABILITY)
    assert one.free == info.free
    assert error_of(info, chosen) == pytest.approx(error_of(one, list(range(both.n_poses))), rel=1e-3)
    assert error_of(info, chosen) < min(error_of(info, []), error_of(info.alone(), chosen))


def test_few_poses_suffice_beside_measured_ones(scene):
    """Alone, a plan needs as many equations as there are parameters; beside measured poses one pose is enough, and the poses that are chosen gain
    more than poses drawn at random."""
    dataset, workcell, found = scene
    info = information(
        workcell.model, workcell.dataset(found.q, found.plane), REPEATABILITY, measured=dataset
    )
    assert info.measured == 60 and info.shared == len(info.free)
    assert least_poses(info, workcell.equations_per_pose) == 1
    assert least_poses(info.alone(), workcell.equations_per_pose) > 10
    plan = choose_poses(info, 6, "error", np.random.default_rng(0))
    assert plan.error < plan.random_error < error_of(info, [])


def test_planes_of_another_session_share_the_arm_alone(scene):
    """If the planes were set up anew after half of the measured poses, those of the first half have planes of their own: they are eliminated, and all
    poses together show less than with planes that stood still."""
    dataset, workcell, found = scene
    candidates = workcell.dataset(found.q, found.plane)
    second = dataset.known_poses.order >= 30
    moved = replace(dataset, poses=dataset.poses.assign(session=np.where(second, 2, 1)))
    errors = [
        error_of(information(workcell.model, candidates, REPEATABILITY, measured=poses), [0, 1, 2])
        for poses in (dataset, moved)
    ]
    assert np.isfinite(errors).all() and errors[0] < errors[1]


def test_an_error_that_no_plan_reaches_comes_with_the_best_that_is_considered(scene):
    """The number of poses is None, and the most poses that are considered are given with the error that is expected of them."""
    _, workcell, found = scene
    info = information(workcell.model, workcell.dataset(found.q, found.plane), REPEATABILITY)
    enough, (most, left) = poses_for_error(info, 1e-6, 10, "error")
    assert enough is None and most == len(found.q)
    assert left == pytest.approx(error_of(info, list(range(most))))
