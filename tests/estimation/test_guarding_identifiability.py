"""Thresholds of identifiability and of data-sheet priors: each is tested with data on both sides, so that half or double changes the decision."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from scalar.estimation.data_sheet_priors import fit_near_data_sheet, misfit_ratio, prior_std, with_reasons
from scalar.estimation.geometry_fit import geometry_fit
from scalar.estimation.identifiability import _null_space_of_scaled
from scalar.estimation.settings import DEFAULTS, changed
from scalar.units import DEG, MM
from tests.random_scene import make_scene


def test_a_direction_that_only_rounding_shows_is_none():
    """Two of three columns differ by 1.5e-8 of their length, which is a direction with a threshold of 1e-8 and none with 2e-8."""
    first, other, third = np.linalg.qr(np.random.default_rng(0).standard_normal((30, 3)))[0].T
    J = np.column_stack([first, first + 3e-8 * other, third])
    tolerance = DEFAULTS.identifiability.null_tolerance
    assert _null_space_of_scaled(J, tolerance)[1].shape[1] == 0
    assert _null_space_of_scaled(J, 2 * tolerance)[1].shape[1] == 1


PRIORS = {
    "plausible_length": 5 * MM,
    "plausible_angle": 1 * DEG,
    "plausible_sensor_place": 50 * MM,
    "plausible_sensor_turn": 11.5 * DEG,
    "plausible_target": 10.0,
}
"""What is known of an arm before it is measured: its data sheet, a ruler, the eye; and of the target nothing."""


@pytest.fixture(scope="module")
def prepared() -> Any:
    """Return what a small set gives: its residuals, the model to start from, what is free, and the fit."""
    dataset = make_scene(seed=5, poses_per_plane=7, points_per_scan=10).dataset
    found, start = geometry_fit(dataset)
    return start.residuals, start.initial.model, start.free, found


@pytest.mark.parametrize("name", PRIORS)
def test_how_far_a_data_sheet_may_be_off_is_the_prior_of_its_kind(prepared, name):
    """Each setting is the prior standard deviation of its own kind of parameters and of no others."""
    model = prepared[1]
    settings = DEFAULTS.identifiability
    before = prior_std(model, settings)
    after = prior_std(model, replace(settings, **{name: 2 * getattr(settings, name)}))
    changed_names = {model.names[i] for i in np.flatnonzero(after != before)}
    np.testing.assert_array_equal(after[after != before], 2 * before[after != before])
    np.testing.assert_allclose(before[after != before], PRIORS[name], rtol=0.01)
    kinds = {
        "plausible_length": lambda n: n.startswith(("a_", "d_")),
        "plausible_angle": lambda n: n.startswith(("alpha_", "theta_", "beta_")),
        "plausible_sensor_place": lambda n: n in ("sensor_x", "sensor_y", "sensor_z"),
        "plausible_sensor_turn": lambda n: n.startswith("sensor_r"),
        "plausible_target": lambda n: model.names.index(n) >= model.blocks["target"].start,
    }
    assert changed_names == {n for n in model.names if kinds[name](n)}


def test_few_equations_do_not_say_how_large_the_noise_is(prepared):
    """Twenty-one poses leave between ten and twenty degrees of freedom: a residual above the stated noise counts if ten are enough."""
    residuals, _, free, found = prepared
    few = DEFAULTS.identifiability.enough_to_judge
    freedom = int(residuals.measurement.equations.sum()) - int(free.sum())
    assert few <= freedom < 2 * few
    louder = replace(
        residuals, measurement=replace(residuals.measurement, sigma=residuals.measurement.sigma / 50)
    ).reweighted(found)
    assert misfit_ratio(louder, found, free) > 10
    asked_for_more = changed(DEFAULTS, {"identifiability.enough_to_judge": 2 * few})
    assert misfit_ratio(louder, found, free, asked_for_more) == 1.0


def test_priors_are_kept_where_a_direction_is_known_no_better_than_asked(prepared):
    """Priors are kept while some standard error is above the stated share of its prior, and are left out once none is."""
    residuals, model, free, _ = prepared
    kept = fit_near_data_sheet(
        residuals, model, free, changed(DEFAULTS, {"identifiability.prior_matters": 1e6})
    )
    left_out = fit_near_data_sheet(
        residuals, model, free, changed(DEFAULTS, {"identifiability.prior_matters": 1e-6})
    )
    assert len(kept.priors) > 0 and not left_out.priors
    told = [
        sum(
            bool(p.reason)
            for p in with_reasons(
                residuals, kept, free, replace(DEFAULTS.identifiability, prior_decides=share)
            ).priors
        )
        for share in (1e-6, 0.999999)
    ]
    assert told[0] > told[1]
