"""The batched baseline equals the baseline: same derivatives and same steps; and the same end and the same number of evaluations
where these do not depend on the last bit of the arithmetic, and so on the processor.
"""

import functools
from dataclasses import replace

import lmfit
import numpy as np
import pytest

from scalar import kernels
from scalar.baseline import batched
from scalar.baseline.batched import BaselineEnd, Distances, fit_baseline
from scalar.baseline.fit import DEFAULTS, calibrate_baseline, first_guess
from scalar.baseline.parameterisation import READINGS, Parameterisation
from scalar.sensors import measure
from tests.baseline.scenes import scene_with_guesses
from tests.robot_configs import PUBLISHED_FIXED

STEP = 1e-5


@functools.cache
def dataset(upright=False):
    """Return a dataset whose walls stand upright, where the root is undefined next to the solution, or lean."""
    return scene_with_guesses("vs060", upright, poses_per_plane=20).dataset


def distances_of(data, reading):
    """Return the distances as functions of the varying parameters, and a place away from the start."""
    measurement = measure(data)
    how = Parameterisation(data.robot, measurement.initial_target(data))
    start = how.values(first_guess(data, measurement, how.planes)[0])
    distances = Distances(how, data.q, measurement, start, PUBLISHED_FIXED, reading, 10_000, STEP)
    rng = np.random.default_rng(1)
    return distances, start[distances.free] * (1 + 1e-3 * rng.standard_normal(len(distances.free)))


@pytest.mark.parametrize("reading", ["clip", "abs"])
@pytest.mark.parametrize("upright", [False, True])
def test_the_columns_are_forward_differences_of_the_residual(reading, upright):
    """Each column is the change of the rows by a step of one parameter, as MINPACK steps it, with the constraint applied."""
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


@pytest.mark.skipif(kernels.LIBRARY is None, reason="no compiled kernels here: no C compiler")
@pytest.mark.parametrize("reading", READINGS)
@pytest.mark.parametrize("upright", [False, True])
def test_rows_and_columns_of_the_compiled_library_are_those_of_numpy(reading, upright, monkeypatch):
    """In every reading, also where the root's argument is negative, rows and changes agree to rounding, or are NaN in both."""
    compiled, x = distances_of(dataset(upright), reading)
    monkeypatch.setattr(batched, "LIBRARY", None)
    by_numpy, _ = distances_of(dataset(upright), reading)
    with np.errstate(invalid="ignore"):
        values = compiled.values(x)
        steps = np.where(values == 0, STEP, STEP * np.abs(values))
        rows = [way.rows(values) for way in (compiled, by_numpy)]
        changes = [way._changes(values, steps) for way in (compiled, by_numpy)]
    assert reading == "raise" or not np.isnan(rows[1]).any()
    np.testing.assert_allclose(*rows, rtol=0, atol=1e-13)
    np.testing.assert_allclose(*changes, rtol=1e-10, atol=1e-14)


@functools.cache
def ends(upright, reading, defaults, nudge=0):
    """Return where the batched baseline and lmfit's end; each `nudge` but zero changes the data in their last bit."""
    data = dataset(upright)
    if nudge:
        rng = np.random.default_rng(nudge)
        last_bit = np.spacing(data.points) * rng.choice([-1.0, 0.0, 1.0], size=data.points.shape)
        data = replace(data, points=data.points + last_bit)
    held = PUBLISHED_FIXED
    theirs = calibrate_baseline(data, reading=reading, points="compressed", fixed=held, defaults=defaults)
    return fit_baseline(data, reading, held, 5000, defaults), theirs


REPRODUCIBLE = [
    (upright, reading, defaults)
    for upright in (False, True)
    for reading in READINGS
    for defaults in DEFAULTS
    if defaults == "now" or (upright and reading == "raise")
]
"""Runs whose path does not depend on the last bit: the step of today's lmfit is far above rounding; and a run that
stops at its first step has no path."""
SAME_END = [(False, reading, "2018") for reading in READINGS] + [(True, "clip", "2018")]
"""Runs whose path depends on the last bit, since the differences of 2018 are those of rounding, and whose end does not."""
CHAOTIC = (True, "abs", "2018")
"""The run whose end depends on the last bit as well: it stops somewhere on the far side of the kink of ``sqrt(abs(.))``."""


@pytest.mark.parametrize("nudge", [0, 1])
@pytest.mark.parametrize(("upright", "reading", "defaults"), REPRODUCIBLE)
def test_it_takes_the_steps_of_lmfit(upright, reading, defaults, nudge):
    """Where the path does not depend on rounding, both computations have the same status, number of evaluations and end."""
    ours, theirs = ends(upright, reading, defaults, nudge)
    assert (
        ours.status
        == theirs.summary["status"]
        == ("raised" if upright and reading == "raise" else "converged")
    )
    assert ours.evaluations == theirs.summary["evaluations"]
    assert ours.model.vector == pytest.approx(theirs.model.vector, abs=1e-6)
    assert ours.rms == pytest.approx(theirs.residual_rms, rel=1e-4)


@pytest.mark.parametrize(("upright", "reading", "defaults"), REPRODUCIBLE)
def test_the_last_bit_leaves_a_reproducible_run_alone(upright, reading, defaults):
    """Changing the data in the last bit changes neither the number of evaluations nor the end."""
    for first, second in zip(
        ends(upright, reading, defaults), ends(upright, reading, defaults, 1), strict=True
    ):
        assert evaluations(first) == evaluations(second)
        assert first.model.vector == pytest.approx(second.model.vector, abs=1e-6)


@pytest.mark.parametrize("nudge", [0, 1])
@pytest.mark.parametrize(("upright", "reading", "defaults"), SAME_END)
def test_another_path_has_the_same_end(upright, reading, defaults, nudge):
    """With the differences of 2018 both computations end at the optimum that today's lmfit finds, after differing numbers of evaluations."""
    optimum = ends(upright, reading, "now")[1]
    for found in ends(upright, reading, defaults, nudge):
        assert status(found) == "converged"
        assert evaluations(found) < 1000
        assert found.model.vector == pytest.approx(optimum.model.vector, abs=1e-5)
        assert rms(found) == pytest.approx(optimum.residual_rms, rel=1e-3)


@pytest.mark.parametrize("nudge", range(4))
def test_a_chaotic_run_ends_between_the_optimum_and_the_start(nudge):
    """A run of `abs` on upright walls with the differences of 2018 ends by MINPACK's own rule, whatever its path.

    It is then better than the start by a factor of ten, and worse than the optimum of the same dataset.
    """
    upright, reading, defaults = CHAOTIC
    optimum = ends(upright, "clip", "now")[1].residual_rms
    start = ends(upright, "raise", "now")[1].residual_rms
    for found in ends(upright, reading, defaults, nudge):
        assert status(found) == "converged"
        assert evaluations(found) < 1000
        assert optimum * (1 - 1e-6) < rms(found) < start / 10


@pytest.mark.parametrize("reading", ["clip", "abs"])
@pytest.mark.parametrize("upright", [False, True])
@pytest.mark.parametrize(("defaults", "agreement"), [("now", 1e-8), ("2018", 1e-6)])
def test_one_step_from_the_same_state_is_the_same(upright, reading, defaults, agreement):
    """If both computations are stopped at the first trial, they have the same parameters, to rounding divided by the step of the differences."""
    # The residual at the start, a column for each parameter, and the residual at the trial.
    first_trial = 1 + 32 + 1
    held = PUBLISHED_FIXED
    data = dataset(upright)
    ours = fit_baseline(data, reading, held, first_trial, defaults)
    theirs = calibrate_baseline(
        data, reading=reading, points="compressed", fixed=held, max_nfev=first_trial, defaults=defaults
    )
    start = fit_baseline(data, "raise", held, 1, defaults).model.vector
    assert ours.status == theirs.summary["status"] == "capped"
    assert np.abs(ours.model.vector - start).max() > 1e-3, "the trial is not the start"
    assert ours.model.vector == pytest.approx(theirs.model.vector, abs=agreement)


def status(found):
    """Return the status of a run of either computation."""
    return found.status if isinstance(found, BaselineEnd) else found.summary["status"]


def evaluations(found):
    """Return the number of evaluations of a run of either computation."""
    return found.evaluations if isinstance(found, BaselineEnd) else found.summary["evaluations"]


def rms(found):
    """Return the root mean square distance [m] at which a run of either computation ended."""
    return found.rms if isinstance(found, BaselineEnd) else found.residual_rms


def test_the_defaults_of_now_are_those_of_the_lmfit_that_is_installed():
    """The written defaults give as many evaluations as lmfit called without any; a release of lmfit with others would fail here."""
    held = PUBLISHED_FIXED
    data = dataset()
    ours = fit_baseline(data, "clip", held, 5000)
    measurement = measure(data)
    how = Parameterisation(data.robot, measurement.initial_target(data))
    start = how.values(first_guess(data, measurement, how.planes)[0])
    distances = Distances(how, data.q, measurement, start, held, "clip", 10_000, STEP)
    parameters = lmfit.Parameters()
    for k, value in enumerate(start[distances.free]):
        parameters.add(f"p{k}", value=value)
    found = lmfit.Minimizer(
        lambda p: distances.rows(distances.values(np.array([one.value for one in p.values()]))), parameters
    ).leastsq()
    assert found.nfev == ours.evaluations


def test_a_fit_that_runs_on_is_capped_and_keeps_its_last_trial():
    """A fit makes no more evaluations than allowed, where each column counts as one, and keeps the parameters of its last trial."""
    ended = fit_baseline(dataset(), "clip", PUBLISHED_FIXED, 40)
    assert ended.status == "capped"
    assert ended.evaluations <= 40
    assert np.all(np.isfinite(ended.model.vector))


def test_what_is_no_number_is_handed_on_if_asked_for():
    """Beside an upright wall lmfit's default ends the fit at the start; MINPACK instead rejects a trial that is no number and goes on."""
    held, data = PUBLISHED_FIXED, dataset(upright=True)
    refused = fit_baseline(data, "raise", held, 5000)
    handed_on = fit_baseline(data, "raise", held, 5000, nan_policy="propagate")
    assert refused.status == "raised"
    assert handed_on.status != "raised"
    assert np.all(np.isfinite(handed_on.model.vector))
    assert handed_on.rms < refused.rms
    with pytest.raises(ValueError, match="nan_policy"):
        fit_baseline(data, "raise", held, 5000, nan_policy="omit")


def test_a_root_that_is_never_negative_is_the_same_either_way():
    """If the walls lean enough, no root is undefined, and the treatment of what is no number changes nothing."""
    held, data = PUBLISHED_FIXED, dataset(upright=False)
    ended = [fit_baseline(data, "raise", held, 5000, nan_policy=policy) for policy in batched.NAN_POLICIES]
    assert ended[0].status == "converged"
    assert ended[0].evaluations == ended[1].evaluations
    assert np.array_equal(ended[0].model.vector, ended[1].model.vector)
