"""The effects that are shipped: those whose correction is expected to bring predictions at other poses nearer to the truth."""

import numpy as np
import pytest

from scalar.diagnosis.fit.fitted_state import FittedState, refit
from scalar.diagnosis.shipping.focused_choice import focused_choice
from scalar.diagnosis.shipping.jackknife import prediction_changes
from scalar.diagnosis.shipping.nested_models import LIMITS, RANGES, NestedModels
from scalar.effects import Effect
from scalar.effects.joint_harmonic import JointHarmonic
from scalar.effects.joint_scale import JointScale
from scalar.effects.plane_bow import PlaneBow
from scalar.effects.range_distortion import RangeDistortion
from scalar.estimation.geometry_fit import geometry_fit
from tests.effects.injected import Flaws, make_cell, on_joint
from tests.effects.test_sensor_map import crooked, mean_error


def fitted(dataset, *effects: Effect) -> FittedState:
    """Return a workcell's state with some effects."""
    model, prepared = geometry_fit(dataset)
    return refit(dataset, model, prepared.free, effects)


@pytest.fixture(scope="module")
def scaled():
    """Return the state of a workcell whose joint 3 has a scale error of 1e-3, with that effect and with one that was not injected."""
    flaws = Flaws(joints=on_joint(3, lambda at: 1e-3 * at.q[:, 2]))
    return fitted(
        make_cell(flaws, seed=81, poses_per_plane=30).dataset, JointScale(3), JointHarmonic(5, (7,))
    )


def test_with_all_effects_the_expected_error_is_the_standard_error(scaled):
    """The wide model has no bias against itself: its expected error is that of the jackknife, and of priors that err by their standard deviations."""
    _, J = scaled.linearised()
    n = len(scaled.model.priors)
    rows = J[len(J) - n :] * scaled.model.misfit_ratio
    steps = rows @ np.linalg.inv(
        J.T @ J
    )  # to the optimum if one datum of the data sheet errs by a standard deviation
    wide = NestedModels(scaled)
    moved = steps @ (wide.linear.columns * wide.linear.scale).T
    by_data_sheet = np.sum(moved**2) / (moved.shape[1] / 3)
    by_chance = prediction_changes(scaled, None).std
    assert n > 0 and by_data_sheet > 0
    assert wide.errors((0, 1))[0] == pytest.approx(np.sqrt(by_chance**2 + by_data_sheet), rel=1e-6)


def test_the_f_statistic_compares_two_fits(scaled):
    """It is that of least squares with the tested columns and with their coefficients zero; a scale that was injected has a large one."""
    wide = NestedModels(scaled)
    n_rows = scaled.dataset.n_poses * scaled.residuals.measurement.rows_per_pose
    residual, J = scaled.linearised()
    out = wide.effect_index == 1
    moved = residual - J[:, out] @ scaled.model.vector[scaled.free][out]
    squares = []
    for columns, start in ((J, residual), (J[:, ~out], moved)):
        step = np.linalg.lstsq(columns, -start, rcond=None)[0]
        squares.append(float(np.sum((start + columns @ step)[:n_rows] ** 2)))
    equations = int(scaled.residuals.measurement.equations.sum())
    expected = (squares[1] - squares[0]) / out.sum() / (squares[0] / (equations - J.shape[1]))
    assert wide.f_statistic((1,), (0, 1)) == pytest.approx(expected, rel=1e-5)
    assert wide.f_statistic((0,), (0, 1)) > 100 * wide.f_statistic((1,), (0, 1))


def test_a_nested_model_is_a_fit_without_the_other_columns(scaled):
    """Its step is that of least squares on the remaining columns, from a model in which the coefficients that are left out are zero."""
    wide = NestedModels(scaled)
    residual, J = scaled.linearised()
    out = wide.effect_index == 0
    coefficients = scaled.model.vector[scaled.free][out]
    step = np.linalg.lstsq(J[:, ~out], -(residual - J[:, out] @ coefficients), rcond=None)[0]
    found, _ = wide.linear.fitted(~out)
    np.testing.assert_allclose(found[~out] / wide.linear.scale[~out], step, rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(found[out] / wide.linear.scale[out], -coefficients)


def test_an_injected_effect_is_shipped(scaled):
    """Without the scale error the expected error is many times larger, so that effect is kept; the effect that was not injected changes little either
    way.
    """
    choice = focused_choice(scaled)
    assert JointScale(3) not in [e.with_coefficients(np.zeros(1)) for e in choice.left_out]
    assert not any(effect.name == "joint_scale" for effect in choice.left_out)
    wide = NestedModels(scaled)
    assert wide.errors((1,))[0] > 10 * wide.errors((0, 1))[0] >= 0.9 * wide.errors((0,))[0] * 0.9


def test_nothing_found_is_nothing_to_choose():
    """A state without effects is returned unchanged; what its predictions are expected to err by is their standard error, and no zero."""
    state = fitted(make_cell(seed=82, poses_per_plane=20).dataset)
    choice = focused_choice(state)
    assert choice.state is state and choice.left_out == ()
    within_limits, within_ranges, _ = choice.expected_errors(without_effects=True)
    assert within_limits == pytest.approx(prediction_changes(state, None).std, rel=1e-6)
    assert 0 < within_ranges <= 1.1 * within_limits


def test_many_effects_that_are_not_there_are_left_out():
    """More than forty coefficients that only describe noise make predictions less certain, so the model without them is chosen."""
    state = fitted(
        make_cell(seed=83, poses_per_plane=25).dataset,
        *(JointHarmonic(j, tuple(range(2, 9))) for j in (2, 4, 6)),
    )
    choice = focused_choice(state)
    assert len(choice.left_out) >= 2
    assert choice.errors_as_chosen[LIMITS] < choice.error_with_all


def test_a_correction_within_the_measured_ranges_is_kept():
    """Orders fitted on a part of joint 2's range are undetermined beyond it, but they correct the poses within the range, and are kept."""
    flaws = Flaws(joints=on_joint(2, lambda at: 6e-4 * np.sin(9 * at.q[:, 1] + 0.3)))
    dataset = make_cell(flaws, seed=85, poses_per_plane=60).dataset
    q = dataset.q[:, 1]
    part = dataset.subset(np.flatnonzero(q < np.quantile(q, 0.4)))
    choice = focused_choice(fitted(part, JointHarmonic(2, (7, 8, 9, 10, 11))))
    assert choice.left_out == ()
    assert choice.errors_as_chosen[LIMITS] > 3 * choice.errors_as_chosen[RANGES]


def test_a_wrong_form_of_the_scanner_error_does_little_harm():
    """If a parabola over the range is fitted to the error of a crooked lens, it may bias the arm's lengths; it is shipped only where it does not."""
    harm, shipped = [], []
    for seed in range(4):
        cell = make_cell(seed=84 + seed, poses_per_plane=40, points_per_scan=60, noise=5e-5)
        dataset = crooked(cell.dataset, 20 + seed, 8e-5)
        without, state = fitted(dataset), fitted(dataset, *RangeDistortion.parsed(dataset, ()))
        chosen = focused_choice(state).state
        errors = [mean_error(Predicting(s), cell) for s in (without, state, chosen)]
        harm.append(errors[1] / errors[0])
        shipped.append(errors[2] / errors[0])
    assert max(harm) > 1.5
    assert max(shipped) < 1.2


class Predicting:
    """A state with the ``predict`` of a calibration."""

    def __init__(self, state: FittedState):
        """Keep the model of a state."""
        self.model = state.model

    def predict(self, table):
        """Return the sensor's poses ``(N, 4, 4)`` by the rigid model; errors of the scanner move none of them."""
        q = table[[f"q{i + 1}" for i in range(self.model.robot.n_joints)]].to_numpy()
        return self.model.robot.flange(q) @ self.model.T_flange_sensor


def test_a_correction_at_the_measured_poses_is_kept(scaled, monkeypatch):
    """Poses that press a tool on plates fill a small part of their joints' ranges, and a large expected error in the rest does not decide against a
    correction.
    """
    measured_without = 7e-3

    def errors(self, kept):
        return (23e-3, 12e-3, 4e-3) if kept else (14e-3, 11e-3, measured_without)

    monkeypatch.setattr(NestedModels, "errors", errors)
    assert focused_choice(scaled).left_out == ()
    measured_without = 3.5e-3
    assert len(focused_choice(scaled).left_out) == 2


def test_a_correction_as_large_as_its_own_error_is_not_made(scaled, monkeypatch):
    """If the expected error without effects is hardly larger, both within the joint limits and at the measured poses, nothing is corrected."""
    with_effects = (8e-3, 8e-3, 8e-3)
    monkeypatch.setattr(
        NestedModels, "errors", lambda self, kept: with_effects if kept else (10e-3, 10e-3, 10e-3)
    )
    assert len(focused_choice(scaled).left_out) == 2
    with_effects = (8e-3, 8e-3, 6e-3)
    assert focused_choice(scaled).left_out == ()
    with_effects = (6e-3, 8e-3, 8e-3)
    assert focused_choice(scaled).left_out == ()


def test_small_bows_of_other_planes_are_shipped_too():
    """If all target planes are bowed and one bow was found, the arm is nearer to the truth with the bows of the other planes in the model."""
    gains, added = [], 0
    for seed in range(3):
        rng = np.random.default_rng(90 + seed)
        bent = {name: tuple(rng.choice([-1, 1], 3) * 1e-3) for name in ("floor", "wall_x", "wall_y")}
        cell = make_cell(Flaws(bent=bent), seed=91 + seed, poses_per_plane=40)
        found = fitted(cell.dataset, PlaneBow.candidates(cell.dataset)[0])
        choice = focused_choice(found)
        added += len(choice.added)
        gains.append(mean_error(Predicting(choice.state), cell) / mean_error(Predicting(found), cell))
    assert added >= 3
    assert np.exp(np.mean(np.log(gains))) < 0.8


def test_a_bow_that_is_not_there_is_not_shipped(scaled, monkeypatch):
    """Even if the expected error were smaller with every further effect, no bow of a flat plane is shipped, and the one of a bent plane is."""
    monkeypatch.setattr(NestedModels, "errors", lambda self, kept: (1e-3 / (1 + len(kept)),) * 3)
    assert focused_choice(scaled).added == ()
    bent = Flaws(bent={"floor": (1e-3, 1e-3, -1e-3)}, joints=on_joint(3, lambda at: 1e-3 * at.q[:, 2]))
    choice = focused_choice(fitted(make_cell(bent, seed=82, poses_per_plane=30).dataset, JointScale(3)))
    assert [effect.target for effect in choice.added] == [{"plane": "floor"}]


def test_the_p_value_of_an_effect_in_the_wide_model():
    """The effect that is there has less than 1e-6. Of the 18 that are not, one in the mean has at most 0.05, and seven with a chance below 1e-5."""
    flaws = Flaws(joints=on_joint(3, lambda at: 1e-3 * at.q[:, 2]))
    absent = [JointHarmonic(joint, (order,)) for joint in (2, 4, 5) for order in (5, 7, 9, 11, 13, 17)]
    wide = NestedModels(fitted(make_cell(flaws, seed=83, poses_per_plane=60).dataset, JointScale(3), *absent))
    every = tuple(range(1 + len(absent)))
    assert wide.p_value(0, every) < 1e-6
    p_values = np.array([wide.p_value(1 + i, every) for i in range(len(absent))])
    assert np.sum(p_values <= 0.05) < 7 and np.sum(p_values > 0.5) > 2
