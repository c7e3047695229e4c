"""The paper's way with all columns at once is the paper's way: same derivatives, same steps, same end, same count."""

import functools

import lmfit
import numpy as np
import pytest

from scalar.baseline.batched import Distances, fit_published
from scalar.baseline.fit import DEFAULTS, READINGS, Parameterisation, calibrate_published, first_guess
from scalar.sensors.line_laser import LineLaser
from tests import helpers

STEP = 1e-5


@functools.cache
def dataset(upright=False):
    """Return a cell whose walls stand upright, where the root is undefined beside the solution, or lean."""
    return helpers.make_scene(
        "vs060",
        seed=2,
        poses_per_plane=20,
        points_per_scan=20,
        noise=1e-5,
        upright=upright,
        plane_tilt=np.deg2rad(0.5),
        plane_offset=0.01,
        length_error=1e-3,
        angle_error=np.deg2rad(0.3),
    ).dataset


def distances_of(data, reading):
    """Return the distances as functions of the varying parameters, and a place away from the start."""
    measurement = LineLaser.of(data)
    how = Parameterisation(data.robot, measurement.initial_target(data))
    start = how.values(first_guess(data, measurement, how.planes)[0])
    distances = Distances(how, data.q, measurement, start, helpers.PUBLISHED_HELD, reading, 10_000, STEP)
    rng = np.random.default_rng(1)
    return distances, start[distances.free] * (1 + 1e-3 * rng.standard_normal(len(distances.free)))


@pytest.mark.parametrize("reading", ["clip", "abs"])
@pytest.mark.parametrize("upright", [False, True])
def test_the_columns_are_forward_differences_of_the_residual(reading, upright):
    """A parameter at a time, stepped as MINPACK steps it, constraint included."""
    distances, x = distances_of(dataset(upright), reading)
    base, J = distances.rows(distances.values(x)), distances.jacobian(x)
    assert J.shape == (len(base), 32)
    for j in range(len(x)):
        step = STEP * abs(x[j]) or STEP
        stepped = x.copy()
        stepped[j] += step
        column = (distances.rows(distances.values(stepped)) - base) / step
        rounding = 1e-14 / step
        assert np.abs(J[:, j] - column).max() < 1e-9 * max(1.0, np.abs(column).max()) + rounding


@pytest.mark.parametrize("reading", READINGS)
@pytest.mark.parametrize("upright", [False, True])
@pytest.mark.parametrize("defaults", DEFAULTS)
def test_it_ends_where_lmfit_ends(reading, upright, defaults):
    """Same status, evaluations within a step or two, same optimum; `abs` on upright walls follows the last bit."""
    held = helpers.PUBLISHED_HELD
    theirs = calibrate_published(
        dataset(upright), reading=reading, points="compressed", held=held, defaults=defaults
    )
    ours = fit_published(dataset(upright), reading, held, 5000, defaults)
    assert ours.status == theirs.summary["status"]
    if upright and reading == "abs":
        return
    assert abs(ours.evaluations - theirs.summary["evaluations"]) <= 34
    assert ours.model.vector == pytest.approx(theirs.model.vector, abs=3e-6)
    assert ours.rms == pytest.approx(theirs.residual_rms, rel=1e-3)


def test_the_defaults_of_now_are_those_of_the_lmfit_that_is_installed():
    """Written down, they change nothing; another lmfit would show here."""
    held = helpers.PUBLISHED_HELD
    data = dataset()
    ours = fit_published(data, "clip", held, 5000)
    measurement = LineLaser.of(data)
    how = Parameterisation(data.robot, measurement.initial_target(data))
    start = how.values(first_guess(data, measurement, how.planes)[0])
    distances = Distances(how, data.q, measurement, start, held, "clip", 10_000, STEP)
    parameters = lmfit.Parameters()
    for k, value in enumerate(start[distances.free]):
        parameters.add(f"p{k}", value=value)
    found = lmfit.Minimizer(
        lambda p: distances.rows(distances.values(np.array([one.value for one in p.values()]))), parameters
    ).leastsq()
    assert abs(found.nfev - ours.evaluations) <= 34


def test_a_fit_that_runs_on_is_capped_and_keeps_its_last_trial():
    """No more evaluations than allowed, columns counted one by one."""
    ended = fit_published(dataset(), "clip", helpers.PUBLISHED_HELD, 40)
    assert ended.status == "capped"
    assert ended.evaluations <= 40
    assert np.all(np.isfinite(ended.model.vector))
