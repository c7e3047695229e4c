"""Thresholds of spectra, noise and the ends of iterations: each is tested with data on both sides of it, so that half or double the threshold changes
the decision.

``snakemake sensitivity`` names these tests for thresholds on which no blind set depends.
"""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from scalar.diagnosis import explained
from scalar.diagnosis.fit.fitted_state import FittedState, refit
from scalar.diagnosis.fit.variance_components import VarianceComponent, variance_components
from scalar.diagnosis.noise import autocorrelation
from scalar.diagnosis.noise.autocorrelation import _moving_angles, neighbours_in_order
from scalar.diagnosis.result import Diagnosis
from scalar.diagnosis.selection import forward_selection, harmonic_spectrum
from scalar.diagnosis.selection.harmonic_spectrum import LinearSystem, _series
from scalar.diagnosis.settings import DEFAULTS
from scalar.diagnosis.structure import unmodelled_structure
from scalar.effects.joint_harmonic import JointHarmonic
from scalar.estimation import gauss_newton
from scalar.estimation.gauss_newton import optimum_near
from scalar.estimation.geometry_fit import geometry_fit
from scalar.estimation.least_squares import covariance_and_step
from scalar.estimation.residuals import Residuals
from tests.diagnosis.stand_ins import doubled
from tests.effects.injected import Flaws, make_cell
from tests.random_scene import make_scene

SPECTRUM = DEFAULTS.spectrum


def system() -> LinearSystem:
    """Return rows with an error of orders 1 and 3 of one joint, and columns of all orders up to 12."""
    rng = np.random.default_rng(2)
    q = rng.uniform(-3.0, 3.0, 600)
    orders = np.arange(1, 13)
    E = np.column_stack([f(k * q) for k in orders for f in (np.sin, np.cos)]) / 1e-4
    residual = 3e-4 / 1e-4 * np.sin(q) + 2e-4 / 1e-4 * np.cos(3 * q) + rng.standard_normal(600)
    band = np.repeat([0, 0, 1, 1, 1, 1, *[2] * 6], 2)
    return LinearSystem(np.ones((600, 1)) / np.sqrt(600), E, residual, band)


def test_the_sizes_of_greatest_evidence_do_not_depend_on_where_the_search_starts(monkeypatch):
    """From half, twice and a hundred times the first size the search finds the same sizes; with fewer rounds, a band without error keeps a size."""
    usual = system().sizes_of_greatest_evidence()[0]
    for factor in (0.5, 2.0, 100.0):
        with monkeypatch.context() as patch:
            patch.setattr(harmonic_spectrum, "FIRST_SIZE", factor * harmonic_spectrum.FIRST_SIZE)
            np.testing.assert_allclose(system().sizes_of_greatest_evidence()[0][:2], usual[:2], rtol=0.01)
    for name, value in (("ROUNDS", 1), ("CONVERGED", 3.0)):
        with monkeypatch.context() as patch:
            patch.setattr(harmonic_spectrum, name, value)
            assert system().sizes_of_greatest_evidence()[0][2] > 1.5 * usual[2]


def test_an_order_that_is_not_there_has_the_least_size():
    """A band without an error gets the smallest size that the search allows."""
    assert system().sizes_of_greatest_evidence()[0][-1] == harmonic_spectrum.LEAST_SIZE


def test_the_ridge_fixes_a_parameter_that_only_one_part_determines(monkeypatch):
    """Without that part the parameter is undetermined: the ridge makes its step zero, whatever the size of the ridge."""
    given = system()
    q = np.linspace(-3.0, 3.0, 600)
    A = np.column_stack([given.A, np.where(q > 2.0, 1.0, 0.0) / np.sqrt(100)])
    state: Any = SimpleNamespace(
        dataset=SimpleNamespace(q=q[:, None]),
        residuals=SimpleNamespace(measurement=SimpleNamespace(rows_per_pose=1)),
        settings=DEFAULTS,
    )
    sizes = given.sizes_of_greatest_evidence()[0]
    found = []
    for factor in (1.0, 2.0):
        monkeypatch.setattr(harmonic_spectrum, "_RIDGE", factor * harmonic_spectrum._RIDGE)
        found.append(replace(given, A=A).unseen_error(sizes, state, [1]))
    assert np.isfinite(found).all()
    assert found[1] == pytest.approx(found[0], rel=1e-4)


def test_neighbours_need_enough_poses():
    """Twenty poses of a plane have neighbours if twelve are enough, and none if twenty-four are needed."""
    settings = DEFAULTS.autocorrelation
    order = np.random.default_rng(3).random(20)
    assert len(neighbours_in_order(np.zeros(20), order, settings.least_poses))
    assert not len(neighbours_in_order(np.zeros(20), order, 2 * settings.least_poses))


def test_a_joint_that_yields_under_its_brake_does_not_move():
    """A joint whose angle varies by 1.3 milliradians does not count as moving, and one whose angle varies by three does."""
    q = np.linspace(0.0, 1.0, 9)[:, None] * [1.3e-3, 3e-3]
    state: Any = SimpleNamespace(residuals=SimpleNamespace(poses=SimpleNamespace(q=q)), settings=DEFAULTS)
    assert list(_moving_angles(state)) == ["q2"]


def test_a_selection_ends_however_many_effects_are_found(monkeypatch):
    """If one more effect is always found, the selection ends after dozens of effects, far more than an arm has."""
    found: list[Any] = []
    state: Any = SimpleNamespace(is_rounding=False, settings=DEFAULTS, effects=())
    monkeypatch.setattr(forward_selection, "CandidateColumns", SimpleNamespace(of=lambda *_: None))
    monkeypatch.setattr(
        forward_selection, "_with_best_candidate", lambda *_: found.append(state) or (state, "one more")
    )
    monkeypatch.setattr(forward_selection, "reconsidered", lambda better, candidates: (better, None))
    forward_selection.select_forward(state, None)  # type: ignore[arg-type]
    assert 40 < len(found) < 80


def test_unmodelled_structure_has_three_terms_at_most(monkeypatch):
    """If one more flexible term is always found, the model gets three."""
    found: list[Any] = []
    state: Any = SimpleNamespace(is_rounding=False, settings=DEFAULTS, dataset=None, effects=())
    for name in ("without_effects_of_same_curve", "without_minor_effects"):
        monkeypatch.setattr(unmodelled_structure, name, lambda state: state)
    monkeypatch.setattr(unmodelled_structure, "with_replacement", lambda *_: found.append(state) or state)
    monkeypatch.setattr(unmodelled_structure, "reconsidered", lambda state, named: (state, None))
    monkeypatch.setattr(unmodelled_structure, "select_forward", lambda state, named: state)
    unmodelled_structure.with_flexible_terms(state, None, [])  # type: ignore[arg-type]
    assert len(found) == 3


def test_cleaning_and_selecting_in_turn_ends(monkeypatch):
    """If further poses always stand out given the effects, cleaning ends after three rounds."""
    rounds: list[Any] = []
    after = SimpleNamespace(dataset=None, is_plausible=True)
    start = explained.Explained(None, None, None, after, None)  # type: ignore[arg-type]
    monkeypatch.setattr(explained, "cleaned_or_refused", lambda *_: object())
    monkeypatch.setattr(explained, "cleaned_given", lambda *_: rounds.append(object()) or rounds[-1])
    monkeypatch.setattr(explained, "_with_named_effects", lambda *_: start)
    monkeypatch.setattr(explained, "flexible_candidate_sets", lambda _: [])
    monkeypatch.setattr(explained, "with_error_of_instrument", lambda *_: None)
    for name in ("with_flexible_terms", "with_spectrum", "near_data_sheet"):
        monkeypatch.setattr(explained, name, lambda state, *_: state)
    monkeypatch.setattr(explained, "refuse_gross_errors_left", lambda *_: None)
    monkeypatch.setattr(explained, "without_far_poses", lambda _, cleaned, state: cleaned)
    explained.explained(None, DEFAULTS, lambda stage: None)  # type: ignore[arg-type]
    assert len(rounds) == 3


def test_poses_that_repeat_worse_than_any_arm_are_no_noise():
    """A standard deviation of 6e-4 rad is above four times, and below eight times, the worst repeatability of an industrial arm."""
    for settings, exceeds in (
        (DEFAULTS.variance_components, True),
        (doubled(DEFAULTS.variance_components, "worst_repeatability"), False),
    ):
        after = SimpleNamespace(settings=SimpleNamespace(variance_components=settings))
        found: Any = SimpleNamespace(
            noise=[VarianceComponent("pose_jitter", 6e-4, 1e-5, 50.0, 1e-12, np.zeros((0, 1, 1)))],
            after=after,
        )
        assert bool(Diagnosis.exceeds_any_repeatability.fget(found)) == exceeds  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    "way",
    [
        {},
        {"_STEPS": 1},
        {"_LEAST_EIGENVALUE": 1.0},
        {"_LEAST_DROP": 1e-3},
        {"_LEAST_EIGENVALUE": 1.0, "_TOLERANCE": 1e-6},
    ],
)
def test_every_way_to_the_optimum_ends_there(way, monkeypatch):
    """Steps by normal equations, the slower fit after one of them or from the start, and looser tolerances all end within a hundredth of a standard
    error of the optimum.
    """
    for name, value in way.items():
        monkeypatch.setattr(gauss_newton, name, value)
    dataset = make_scene(seed=4, poses_per_plane=15, points_per_scan=8).dataset
    model, prepared = geometry_fit(dataset)
    residuals = Residuals.of(dataset, model)
    found = optimum_near(residuals, model.rebased(), prepared.free)
    residual, jacobian = residuals.linearise(found)
    assert covariance_and_step(jacobian[:, prepared.free], residual)[1] < 0.01


def test_a_residual_of_rounding_errors_is_not_searched(monkeypatch):
    """A variance of 1.5e-4 of the noise's is searched for effects with a threshold of 1e-4, and not with 2e-4."""
    searched: list[Any] = []
    monkeypatch.setattr(forward_selection, "CandidateColumns", SimpleNamespace(of=lambda *_: None))
    monkeypatch.setattr(
        forward_selection, "_with_best_candidate", lambda state, columns, refused: searched.append(state)
    )
    for settings, times in ((DEFAULTS.selection, 1), (doubled(DEFAULTS.selection, "rounding_variance"), 1)):
        state: Any = SimpleNamespace(
            background=lambda: SimpleNamespace(variance=1.5e-4),
            settings=SimpleNamespace(selection=settings),
            effects=(),
        )
        state.is_rounding = FittedState.is_rounding.fget(state)  # type: ignore[attr-defined]
        assert forward_selection.select_forward(state, None) is state  # type: ignore[arg-type]
        assert len(searched) == times


def test_many_orders_of_a_joint_make_a_spectrum():
    """Six orders of joint 3 are a spectrum if four are many, and none if eight are."""
    for settings, joints in ((SPECTRUM, [3]), (doubled(SPECTRUM, "many_orders"), [])):
        state: Any = SimpleNamespace(
            effects=(JointHarmonic(3, (1, 2, 4)), JointHarmonic(3, (5, 7, 8))),
            settings=SimpleNamespace(spectrum=settings),
        )
        assert list(_series(state)) == joints


def test_a_variance_component_has_to_be_beyond_chance():
    """A component is found at twice its own p-value as significance level, and not at half of it."""
    dataset = make_cell(Flaws(jitter=3e-5), seed=1, poses_per_plane=30, points_per_scan=20).dataset
    model, prepared = geometry_fit(dataset)
    state = refit(dataset, model, prepared.free, ())
    given = state.background_within_scans(), state.residuals, state.model
    chance = min(found.p_value for found in variance_components(*given, 1.0))
    assert variance_components(*given, 2.0 * chance)
    assert not variance_components(*given, 0.5 * chance)


@pytest.mark.parametrize(("chance", "is_pattern"), [(0.7e-3, True), (1.5e-3, False)])
def test_residuals_are_autocorrelated_only_beyond_chance(chance, is_pattern, monkeypatch):
    """A p-value of seven in ten thousand is significant, and one of fifteen in ten thousand is not."""
    state: Any = SimpleNamespace(settings=DEFAULTS, background=lambda: SimpleNamespace(residual=None))
    monkeypatch.setattr(
        autocorrelation, "autocorrelation_p_values", lambda *_: {("q1",): 0.5, ("time",): chance}
    )
    assert autocorrelation.depends_on(state) == (["time"] if is_pattern else [])
