"""Which parameters are fixed: as many as there are null directions, such that the rest is determined, conventions first."""

from dataclasses import replace

import numpy as np
import pytest

from scalar.estimation.gauge_choice import choose_fixed, preference
from scalar.estimation.settings import DEFAULTS
from tests.random_scene import make_scene

SETTINGS = DEFAULTS.identifiability


def deficient(rng, columns, null):
    """Return a Jacobian of unit columns whose null space has a given basis ``(C, r)``, and an orthonormal basis of it."""
    basis = np.linalg.qr(null)[0]
    J = rng.standard_normal((3 * columns, columns))
    J -= J @ basis @ basis.T
    scale = np.linalg.norm(J, axis=0)
    return J / scale, np.linalg.qr(basis * scale[:, None])[0]


@pytest.mark.parametrize("r", [1, 3, 6])
@pytest.mark.parametrize("seed", range(5))
def test_what_remains_free_is_determined(r, seed):
    """One column is fixed for each null direction, and without these columns the Jacobian has full rank."""
    rng = np.random.default_rng(seed)
    J, null = deficient(rng, 15, rng.standard_normal((15, r)))
    chosen = choose_fixed(null, list(rng.permutation(15)), J, SETTINGS)
    assert len(set(chosen)) == len(chosen) == r
    s = np.linalg.svd(np.delete(J, chosen, axis=1), compute_uv=False)
    assert s[-1] > 1e-4 * s[0]


@pytest.mark.parametrize("preferred", [2, 7])
def test_of_two_that_serve_alike_the_preferred_is_fixed(preferred):
    """Of two parameters whose sum alone is observed, the one that comes first in the order of preference is fixed."""
    null = np.zeros((10, 1))
    null[2], null[7] = 1.0, -1.0
    J, null = deficient(np.random.default_rng(0), 10, null)
    order = [preferred, *(i for i in range(10) if i != preferred)]
    assert choose_fixed(null, order, J, SETTINGS) == [preferred]


def test_a_preferred_parameter_that_hardly_helps_is_not_fixed():
    """A parameter with a thousandth of the null direction would leave the rest badly conditioned, so another is fixed."""
    null = np.zeros((10, 1))
    null[0], null[4], null[8] = 1e-3, 1.0, -1.0
    J, null = deficient(np.random.default_rng(0), 10, null)
    assert choose_fixed(null, list(range(10)), J, SETTINGS) == [4]


@pytest.mark.parametrize(("share", "is_fixed"), [(0.1, True), (0.05, False)])
def test_a_preferred_parameter_has_to_be_in_the_null_direction(share, is_fixed):
    """A parameter with a fifteenth of the null direction's length is fixed, and one with a thirtieth is not."""
    assert (choose_fixed(*hardly_there(share), SETTINGS) == [0]) == is_fixed


@pytest.mark.parametrize(("share", "is_fixed"), [(0.045, True), (0.02, False)])
def test_a_preferred_parameter_may_cost_one_digit_and_a_half(share, is_fixed):
    """A preferred parameter is fixed if the rest is conditioned 20 times worse than with the best choice, and not if 46 times."""
    settings = replace(SETTINGS, span_tolerance=1e-3)
    assert (choose_fixed(*hardly_there(share), settings) == [0]) == is_fixed


def hardly_there(share):
    """Return null space, order and Jacobian of a case in which the preferred parameter has a small share of the null direction."""
    null = np.zeros((10, 1))
    null[0], null[4], null[8] = share, 1.0, -1.0
    J, null = deficient(np.random.default_rng(0), 10, null)
    return null, list(range(10)), J


def test_nothing_is_fixed_where_everything_is_observed():
    """Without a null direction no parameter is fixed."""
    J = np.linalg.qr(np.random.default_rng(0).standard_normal((20, 5)))[0]
    assert choose_fixed(np.zeros((5, 0)), [0, 1, 2, 3, 4], J, SETTINGS) == []


def test_conventions_come_before_what_was_measured():
    """Parameters of the base are fixed first, then those of the flange, and those of sensor and planes, which users want to know, last."""
    robot = make_scene(poses_per_plane=3).dataset.robot
    names = ("distance_floor", "sensor_x", "a_3", "theta_6", "a_1", "alpha_4")
    order = [names[i] for i in preference(robot, names)]
    assert order == ["a_1", "theta_6", "a_3", "alpha_4", "sensor_x", "distance_floor"]
