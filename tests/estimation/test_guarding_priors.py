"""Thresholds of priors, of repeated weighting and of the noise within scans: half or double each of them changes its decision."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from scalar.errors import Undetermined
from scalar.estimation import data_sheet_priors, joint_fit
from scalar.estimation.data_sheet_priors import fit_near_data_sheet, misfit_ratio, with_reasons
from scalar.estimation.geometry_fit import geometry_fit
from scalar.estimation.joint_fit import fit_from, unobservable_coefficients
from scalar.estimation.learned_prior_std import most_likely_prior_stds, typical_prior_stds
from scalar.estimation.least_squares import covariance_and_step
from scalar.estimation.misfit import misfit
from scalar.estimation.model import ParameterPrior
from scalar.estimation.settings import DEFAULTS
from scalar.estimation.sufficiency import check_setup
from scalar.units import MM
from tests.random_scene import make_scene


@pytest.fixture(scope="module")
def prepared() -> Any:
    """Return what a small set gives: its residuals, the model to start from, what is free, and the fit."""
    dataset = make_scene(seed=5, poses_per_plane=7, points_per_scan=10).dataset
    found, start = geometry_fit(dataset)
    return start.residuals, start.initial.model, start.free, found


@pytest.mark.parametrize(("equations", "enough"), [(18, False), (36, True)])
def test_sensor_and_target_need_twice_as_many_equations(equations, enough):
    """For twelve unknowns of sensor and planes, 18 equations are too few even with the maker's tolerance, and 36 are enough."""
    measurement: Any = SimpleNamespace(
        equations=np.ones(equations), observes_orientation=True, target_words="planes", scans=True
    )
    given: Any = SimpleNamespace(n_poses=equations), measurement, SimpleNamespace(vector=np.zeros(6))
    if enough:
        check_setup(*given)
    else:
        with pytest.raises(Undetermined, match="12 unknowns"):
            check_setup(*given)


@pytest.mark.parametrize(("known", "has_priors"), [(7.0, True), (14.0, False)])
def test_priors_that_hardly_matter_are_left_out(prepared, known, has_priors, monkeypatch):
    """Priors that lower a variance by 2 %, with directions known seven times as well as by them, are kept.

    Those that lower it by half a per cent are not.
    """
    residuals, model, free, _ = prepared
    monkeypatch.setattr(
        data_sheet_priors, "_determined", lambda residuals, model, free, scale, least: known > least
    )
    monkeypatch.setattr(data_sheet_priors, "misfit_ratio", lambda *_: 1.0)
    assert bool(fit_near_data_sheet(residuals, model, free).priors) == has_priors


@pytest.mark.parametrize(("share", "is_told"), [(0.4, False), (0.6, True)])
def test_a_parameter_of_which_the_data_sheet_says_much_is_told(prepared, share, is_told):
    """A parameter is listed if its standard error is six tenths of its prior's standard deviation, and not if it is four tenths."""
    residuals, _, free, found = prepared
    residual, J = residuals.linearise(found)
    name = found.names[int(np.flatnonzero(free)[0])]
    alone = np.sqrt(covariance_and_step(J[:, free], residual)[0][0, 0])
    # One prior of width t beside data of standard error s leaves st / sqrt(s^2 + t^2): the wanted share of t for t as follows.
    prior = ParameterPrior(name, float(found.vector[0]), float(alone * np.sqrt(1 / share**2 - 1)), "")
    told = with_reasons(residuals, replace(found, priors=(prior,), misfit_ratio=1.0), free)
    assert bool(told.priors[0].reason) == is_told


@pytest.mark.parametrize(("chance", "is_misfit"), [(0.7e-3, True), (1.5e-3, False)])
def test_a_residual_is_larger_than_the_noise_only_beyond_chance(prepared, chance, is_misfit):
    """A residual with a p-value of seven in ten thousand is a misfit, and one with fifteen in ten thousand is not."""
    residuals, _, free, found = prepared

    def stated(log_factor: float) -> Any:
        sigma = np.exp(log_factor) * residuals.measurement.sigma
        return replace(residuals, measurement=replace(residuals.measurement, sigma=sigma)).reweighted(found)

    def excess(log_factor: float) -> float:
        p_value = misfit(stated(log_factor), found, free).p_value
        assert p_value is not None
        return float(np.log(max(p_value, 1e-300) / chance))

    assert (misfit_ratio(stated(brentq(excess, -3.0, 3.0)), found, free) > 1.0) == is_misfit


@pytest.mark.parametrize(("change", "is_last"), [(0.035, True), (0.075, False)])
def test_weights_of_priors_that_hardly_change_are_the_last(prepared, change, is_last, monkeypatch):
    """Weights that change by three and a half per cent are the last, and weights that change by seven and a half are computed again."""
    residuals, model, free, _ = prepared
    fits: list[Any] = []
    fitted = data_sheet_priors.fit

    def counted(*given: Any, **options: Any) -> Any:
        fits.append(given)
        return fitted(*given, **options)

    monkeypatch.setattr(data_sheet_priors, "fit", counted)
    monkeypatch.setattr(data_sheet_priors, "_largest_change", lambda *_: change)
    fit_near_data_sheet(residuals, model, free)
    assert (len(fits) == 1) == is_last


@pytest.mark.parametrize(("moved", "fits"), [(0.014, 1), (0.03, 2)])
def test_a_whitening_that_hardly_moves_the_optimum_is_the_last(prepared, moved, fits, monkeypatch):
    """A whitening that moves the optimum by 0.014 standard deviations is the last, and after one that moves it by 0.03 the fit is repeated."""
    residuals, _, free, found = prepared
    steps, done = iter((moved, 0.0)), []
    fitted = joint_fit.fit
    monkeypatch.setattr(joint_fit, "remaining_step", lambda *_: next(steps))
    monkeypatch.setattr(joint_fit, "fit", lambda *given: done.append(given) or fitted(*given))
    fit_from(None, found, free, residuals)  # type: ignore[arg-type]
    assert len(done) == fits


@pytest.mark.parametrize(("left", "fixed"), [(2e-3, True), (4.5e-3, False)])
def test_a_coefficient_that_all_else_explains_is_fixed(left, fixed):
    """A coefficient is fixed if two thousandths of its column are left given everything else, and estimated if four and a half are."""
    first, other = np.linalg.qr(np.random.default_rng(0).standard_normal((30, 2)))[0].T
    J = np.column_stack([first, first + left * other])
    residuals: Any = SimpleNamespace(linearise=lambda model: (None, J))
    model: Any = SimpleNamespace(blocks={"effects": slice(1, 2)}, priors=())
    found = unobservable_coefficients(residuals, model, np.ones(2, dtype=bool), DEFAULTS.fit.unseen_share)
    assert list(found) == [False, fixed]


NOBODY_KNOWS = {"length": 0.3 * MM, "angle": 0.3e-3, "zero": 1e-3}
"""How far an arm of which nothing is known is from its data sheet: tenths of a millimetre over links of about a metre; zeros a milliradian."""


@pytest.mark.parametrize(("group", "counts_as"), [("length", 6.0), ("angle", 6.0), ("zero", 1.0)])
def test_what_is_usual_is_outweighed_by_the_arm_itself(group, counts_as):
    """Without data the priors are those of usual arms, and an arm's own corrections outweigh them.

    By ``t^2 = (sum m_i^2 + c t_0^2) / (4 + c)``, four exactly known corrections are pooled with the usual one, which counts as c = 6 for lengths and
    angles, and as 1 for zeros.
    """
    typical, usual = typical_prior_stds(DEFAULTS.identifiability), NOBODY_KNOWS[group]
    nothing = np.eye(1), np.zeros(1), np.zeros(1), np.ones(1)
    assert most_likely_prior_stds(*nothing, {g: np.zeros(1, dtype=bool) for g in typical}, typical)[
        group
    ] == pytest.approx(usual)
    exact = 1e15 * np.eye(4), np.zeros(4), np.full(4, 10 * usual), np.ones(4)
    found = most_likely_prior_stds(*exact, {g: np.full(4, g == group) for g in typical}, typical)[group]
    assert found == pytest.approx(usual * np.sqrt((4 * 100 + counts_as) / (4 + counts_as)), rel=1e-3)
