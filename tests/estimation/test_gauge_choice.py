"""Which parameters are fixed: as many as there are null directions, such that the rest is determined, conventions first."""

from dataclasses import replace

import numpy as np
import pytest

from scalar.estimation.gauge_choice import choose_fixed, preference
from scalar.estimation.settings import IdentifiabilitySettings
from tests import helpers

SETTINGS = IdentifiabilitySettings()


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
    """One column for each null direction, and without them the Jacobian has full rank."""
    rng = np.random.default_rng(seed)
    J, null = deficient(rng, 15, rng.standard_normal((15, r)))
    chosen = choose_fixed(null, list(rng.permutation(15)), J, SETTINGS)
    assert len(set(chosen)) == len(chosen) == r
    s = np.linalg.svd(np.delete(J, chosen, axis=1), compute_uv=False)
    assert s[-1] > 1e-4 * s[0]


@pytest.mark.parametrize("preferred", [2, 7])
def test_of_two_that_serve_alike_the_preferred_is_fixed(preferred):
    """Two parameters of which only the sum is observed: the one that comes first in the order is fixed."""
    null = np.zeros((10, 1))
    null[2], null[7] = 1.0, -1.0
    J, null = deficient(np.random.default_rng(0), 10, null)
    order = [preferred, *(i for i in range(10) if i != preferred)]
    assert choose_fixed(null, order, J, SETTINGS) == [preferred]


def test_a_preferred_parameter_that_hardly_helps_is_not_fixed():
    """A parameter with a share of a thousandth in the null direction would leave the rest badly conditioned: another is taken."""
    null = np.zeros((10, 1))
    null[0], null[4], null[8] = 1e-3, 1.0, -1.0
    J, null = deficient(np.random.default_rng(0), 10, null)
    assert choose_fixed(null, list(range(10)), J, SETTINGS) == [4]


@pytest.mark.parametrize(
    ("name", "share", "others"),
    [("span_tolerance", 0.1, {}), ("condition_slack", 0.03, {"span_tolerance": 1e-3})],
)
def test_how_little_a_preferred_parameter_may_help_is_a_threshold(name, share, others):
    """With that share in the null direction it is fixed under the looser of two thresholds and not under the stricter, twice as strict."""
    null = np.zeros((10, 1))
    null[0], null[4], null[8] = share, 1.0, -1.0
    J, null = deficient(np.random.default_rng(0), 10, null)
    base = replace(SETTINGS, **others)
    chosen = [
        choose_fixed(null, list(range(10)), J, replace(base, **{name: factor * getattr(base, name)}))
        for factor in (0.5, 1, 2)
    ]
    assert [0] in chosen and any(0 not in fixed for fixed in chosen), chosen


def test_nothing_is_fixed_where_everything_is_observed():
    """Without a null direction there is nothing to choose."""
    J = np.linalg.qr(np.random.default_rng(0).standard_normal((20, 5)))[0]
    assert choose_fixed(np.zeros((5, 0)), [0, 1, 2, 3, 4], J, SETTINGS) == []


def test_conventions_come_before_what_was_measured():
    """The base comes first, then the flange, and sensor and planes last: their values are what a user wants to know."""
    robot = helpers.make_scene(poses_per_plane=3).dataset.robot
    names = ("distance_floor", "sensor_x", "a_3", "theta_6", "a_1", "alpha_4")
    order = [names[i] for i in preference(robot, names)]
    assert order == ["a_1", "theta_6", "a_3", "alpha_4", "sensor_x", "distance_floor"]
