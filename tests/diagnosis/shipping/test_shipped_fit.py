"""The fit that is shipped: chosen by its predictions, and everything that is reported is of that fit."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from scalar.data.dataset import Dataset
from scalar.diagnosis import diagnose
from scalar.diagnosis.fit.fitted_state import FittedState, refit, whitened
from scalar.diagnosis.fit.predicted_displacements import displacement_columns, random_poses
from scalar.diagnosis.fit.whitened_measurement import WhitenedMeasurement
from scalar.diagnosis.held_out.hold_out import held_out_errors
from scalar.diagnosis.shipping.focused_choice import focused_choice
from scalar.diagnosis.shipping.jackknife import N_POSES, prediction_changes
from scalar.diagnosis.shipping.shipped_fit import (
    BEFORE,
    BY_COMPONENT,
    EQUAL,
    shipped_fit,
    unconfirmed_effects_help,
)
from scalar.effects.joint_harmonic import JointHarmonic
from scalar.effects.joint_scale import JointScale
from scalar.estimation.geometry_fit import geometry_fit
from scalar.estimation.residuals import Residuals
from scalar.report.shipped_words import shipped_sentences
from tests.effects.injected import Flaws, make_cell, on_joint


def fitted(seed: int, flaws: Flaws | None = None, **settings) -> FittedState:
    """Return a workcell's fit without effects."""
    dataset = make_cell(flaws or Flaws(), seed=seed, points_per_scan=20, **settings).dataset
    model, prepared = geometry_fit(dataset)
    return refit(dataset, model, prepared.free, ())


@pytest.fixture(scope="module")
def jittering() -> FittedState:
    return fitted(71, Flaws(jitter=1.5e-4), poses_per_plane=40)


def false_weights(state: FittedState, rng: np.random.Generator) -> np.ndarray:
    """Return weights ``(N, m, m)`` between 0.1 and 10 that have nothing to do with the noise."""
    m = state.residuals.measurement.rows_per_pose
    return 10 ** rng.uniform(-1, 1, state.dataset.n_poses)[:, None, None] * np.eye(m)


def with_more_noise(dataset: Dataset, std: float, seed: int) -> Dataset:
    """Return a dataset with further errors of the range [m], which its stated noise does not include."""
    points = dataset.points
    e = std * np.random.default_rng([72, seed]).standard_normal(len(points))
    return replace(dataset, points=points * (1.0 + e / np.linalg.norm(points, axis=1))[:, None])


@pytest.mark.parametrize("weighted", [False, True])
def test_leaving_a_pose_out_is_a_fit_without_it(jittering, weighted):
    """The changes when single poses are left out are those of least squares on the other rows, to rounding errors."""
    state = jittering
    weights = state.whitening if weighted else None
    residual, J = (whitened(weights, rows) for rows in state.linearised())
    m = state.residuals.measurement.rows_per_pose
    columns = displacement_columns(state, random_poses(state, N_POSES))[:, state.free]
    found = prediction_changes(state, weights)
    all_rows = np.linalg.lstsq(J, -residual, rcond=None)[0]
    np.testing.assert_allclose(found.to_optimum, columns @ all_rows, rtol=0, atol=1e-9)
    for pose in (0, 17, state.dataset.n_poses - 1):
        rest = np.delete(np.arange(len(residual)), np.arange(pose * m, (pose + 1) * m))
        without = np.linalg.lstsq(J[rest], -residual[rest], rcond=None)[0]
        np.testing.assert_allclose(found.left_out[pose], columns @ (without - all_rows), rtol=1e-5, atol=1e-9)


def test_the_standard_error_is_that_of_repeated_campaigns():
    """Over campaigns that differ in their noise alone, predictions vary as the jackknife of one campaign states, whatever noise is stated."""
    dataset = make_cell(seed=72, points_per_scan=20, poses_per_plane=40).dataset
    model, prepared = geometry_fit(dataset)
    states = [refit(with_more_noise(dataset, 3e-4, k), model, prepared.free, ()) for k in range(12)]
    stated = np.array([prediction_changes(state, None).std for state in states])
    anywhere = random_poses(states[0], N_POSES)
    columns = displacement_columns(states[0], anywhere)[:, states[0].free]
    vectors = np.array([state.model.vector[state.free] for state in states])
    moved = (vectors - vectors.mean(axis=0)) @ columns.T
    spread = np.sqrt(np.sum(moved**2) / (len(states) - 1) / N_POSES)
    assert spread / 1.35 < np.sqrt(np.mean(stated**2)) < spread * 1.35


def test_weights_that_are_right_are_used(jittering):
    """If joints do not repeat, the fit with the weights of the jitter is shipped."""
    assert shipped_fit(jittering, jittering, jittering.whitening).fit == BY_COMPONENT


def test_weights_that_are_wrong_are_not_used():
    """Weights that have nothing to do with the noise are not used, and after.json is as it was without them."""
    for seed in range(4):
        state = fitted(80 + seed, poses_per_plane=40)
        shipped = shipped_fit(state, state, false_weights(state, np.random.default_rng(seed)))
        assert shipped.fit == EQUAL
        np.testing.assert_array_equal(shipped.held_out.metric, held_out_errors(state).metric)


@pytest.mark.parametrize(
    ("apart", "larger", "fit", "decided_by"),
    [(9e-4, 1.2, EQUAL, "held_out"), (1e-4, 1.2, BY_COMPONENT, "predicted_std"), (9e-4, 1.01, BY_COMPONENT, "predicted_std")],
)  # fmt: skip
def test_weights_that_mislead_are_not_used(monkeypatch, jittering, apart, larger, fit, decided_by):
    """Weights with which predictions seem more certain are not used if the two fits disagree beyond chance and held-out poses are predicted a fifth
    worse with them; either alone is no reason.
    """
    errors = held_out_errors(jittering)
    worse = replace(errors, metric=errors.metric * larger**2)
    monkeypatch.setattr(
        "scalar.diagnosis.shipping.shipped_fit.held_out_errors",
        lambda state, whitening=None: errors if whitening is None else worse,
    )
    monkeypatch.setattr(
        "scalar.diagnosis.shipping.shipped_fit.prediction_changes",
        lambda state, whitening: SimpleNamespace(
            std=1e-3 if whitening is None else 1e-4, difference_from=lambda other: (apart, 1e-4)
        ),
    )
    shipped = shipped_fit(jittering, jittering, jittering.whitening)
    assert (shipped.fit, shipped.decided_by) == (fit, decided_by)
    assert shipped.held_out is (worse if fit == BY_COMPONENT else errors)


@pytest.mark.parametrize(("unconfirmed", "helps"), [(2, True), (5, False)])
def test_an_unconfirmed_effect_helps_if_predictions_are_worse_without_it(unconfirmed, helps):
    """Joints 2 and 3 have a scale error: that of joint 2 helps beside that of joint 3, and one of joint 5 does not."""
    flaws = Flaws(joints=lambda at: at.q * [0.0, 2e-3, 2e-3, 0.0, 0.0, 0.0])
    confirmed = fitted(77, flaws, poses_per_plane=20).refitted([JointScale(3)])
    assert (
        unconfirmed_effects_help(confirmed, confirmed.refitted([JointScale(3), JointScale(unconfirmed)]))
        == helps
    )


def test_a_model_that_predicts_worse_is_not_shipped():
    """If held-out poses are predicted better without the effects, the model without them is shipped, and the effects remain findings."""
    before = fitted(75, poses_per_plane=40)
    after = before.refitted([JointHarmonic(j, tuple(range(2, 13))) for j in (1, 2, 3, 4)])
    shipped = shipped_fit(before, after, None)
    assert held_out_errors(after).rms > held_out_errors(before).rms
    assert shipped.fit == BEFORE and shipped.without_effects and shipped.effects_fit == EQUAL
    np.testing.assert_array_equal(shipped.held_out.metric, held_out_errors(before).metric)


@pytest.mark.slow
def test_what_is_reported_is_of_the_file_that_is_written():
    """The training and held-out errors of `after` are those of the calibration that is shipped, weighted or not."""
    dataset = make_cell(Flaws(jitter=1.5e-4), seed=71, points_per_scan=20, poses_per_plane=40).dataset
    diagnosis = diagnose(dataset)
    mapping = diagnosis.to_mapping()
    assert mapping["shipped"]["fit"] == BY_COMPONENT and mapping["effects"]
    shipped, state = diagnosis.calibration_after, diagnosis.after
    used = Residuals.of(diagnosis.cleaned.dataset, shipped.model)
    train = mapping["residual"]["after"]["train_rms_mm"]
    assert train == pytest.approx(1e3 * used.rms(shipped.model), rel=1e-9)
    weighted = held_out_errors(state, state.whitening)
    assert mapping["residual"]["after"]["held_out_rms_mm"] == pytest.approx(1e3 * weighted.rms, rel=1e-12)
    assert weighted.rms != held_out_errors(state).rms
    (sentence, *_) = shipped_sentences(diagnosis)
    assert "after.json is fitted with the weights" in sentence
    # The optimum under the weights that the report names is where the shipped calibration stands.
    rows = Residuals(
        WhitenedMeasurement(
            state.residuals.measurement, state.whitening, state.variance_components[0].as_noise()
        ),
        used.poses,
        used.bases,
        used.known,
    )
    residual, J = rows.linearise(shipped.model)
    free = np.array([name in shipped.free for name in shipped.model.names])
    step = np.linalg.lstsq(J[:, free], -residual, rcond=None)[0]
    assert np.linalg.norm(J[:, free] @ step) < 0.05


def test_effects_with_which_unseen_poses_are_predicted_worse_are_not_shipped():
    """They are not shipped even if the difference is not significant, because a correction that does harm is worse than one that is missing."""
    before = fitted(77, Flaws(joints=on_joint(3, lambda at: 1e-3 * at.q[:, 2])), poses_per_plane=20)
    after = before.refitted([JointScale(3)])
    errors = held_out_errors(before)
    rng = np.random.default_rng(3)
    for factor, fit in ((0.9, EQUAL), (1.2, BEFORE)):
        other = replace(
            errors, metric=errors.metric * factor * rng.permutation(errors.metric) / errors.metric
        )
        shipped = shipped_fit(before, after, None, (errors, other))
        assert (shipped.fit, shipped.decided_by) == (fit, "only_one" if fit == EQUAL else "unseen")


@pytest.mark.parametrize(
    ("poses_per_plane", "flexible", "decided_by"),
    [(13, True, "few_poses"), (13, False, "only_one"), (20, True, "only_one")],
)
def test_structure_without_a_name_is_not_corrected_with_few_poses(
    monkeypatch, poses_per_plane, flexible, decided_by
):
    """With 13 poses on each of three planes, two equations for each of 39 parameters, a flexible term is not shipped; an effect with a name is."""
    monkeypatch.setattr(JointScale, "flexible", flexible)
    before = fitted(
        77, Flaws(joints=on_joint(3, lambda at: 3e-3 * at.q[:, 2])), poses_per_plane=poses_per_plane
    )
    shipped = shipped_fit(before, before.refitted([JointScale(3)]), None)
    assert shipped.decided_by == decided_by and shipped.without_effects == (decided_by == "few_poses")


@pytest.mark.slow
def test_a_bow_that_is_no_finding_is_said_to_be_corrected():
    """If one target plane bows clearly and two bow a little, after.json has bows that are no findings, and report and diagnosis.json say so."""
    bent = {"floor": (4e-3, 2e-3, 4e-3), "wall_x": (13e-5, -13e-5, 13e-5), "wall_y": (-13e-5, 13e-5, 13e-5)}
    dataset = make_cell(Flaws(bent=bent), seed=5, poses_per_plane=25).dataset
    diagnosis = diagnose(dataset)
    added = [effect.target["plane"] for effect in diagnosis.shipped.choice.added]
    assert added and not set(added) & {f.effect.target["plane"] for f in diagnosis.findings}
    corrected = {effect.target["plane"] for effect in diagnosis.calibration_after.model.effects}
    assert corrected >= {"floor", *added}
    assert {entry["target"]["plane"] for entry in diagnosis.to_mapping()["shipped"]["added"]} == set(added)
    (sentence,) = [s for s in shipped_sentences(diagnosis) if "also corrects for" in s]
    assert all(plane in sentence for plane in added)


@pytest.mark.parametrize(
    ("factor", "fit", "decided_by"), [(1.005, EQUAL, "only_one"), (1.1, BEFORE, "regions")]
)
def test_effects_that_do_not_extrapolate_are_not_shipped(monkeypatch, factor, fit, decided_by):
    """Where whole regions are held out, the errors with effects may exceed those without by a hundredth at most."""
    before = fitted(77, Flaws(joints=on_joint(3, lambda at: 1e-3 * at.q[:, 2])), poses_per_plane=20)
    after = before.refitted([JointScale(3)])
    errors = held_out_errors(before)
    worse = replace(errors, metric=errors.metric * factor**2)
    monkeypatch.setattr(
        "scalar.diagnosis.shipping.shipped_fit.held_out_regions",
        lambda state, whitening=None: worse if state.effects else errors,
    )
    shipped = shipped_fit(before, after, None)
    assert (shipped.fit, shipped.decided_by) == (fit, decided_by)
    said = shipped.to_mapping()["regions"]
    assert said["with_effects_rms_mm"] == pytest.approx(factor * said["without_effects_rms_mm"])


def test_a_true_effect_extrapolates():
    """With a joint's scale error, regions that took no part in the fit are predicted well, and it is shipped; without effects no regions are held
    out.
    """
    before = fitted(77, Flaws(joints=on_joint(3, lambda at: 1e-3 * at.q[:, 2])), poses_per_plane=20)
    shipped = shipped_fit(before, before.refitted([JointScale(3)]), None)
    assert shipped.regions is not None and shipped.fit == EQUAL
    without, effects = shipped.regions
    assert effects.rms < 0.5 * without.rms
    assert shipped_fit(before, before, None).regions is None


@pytest.mark.parametrize(
    ("left", "most_gain", "most_growth", "decided_by"),
    [
        (0.4, True, 2.0, "only_one"),
        (0.6, True, 2.0, "held_out"),
        (0.4, False, 2.0, "held_out"),
        (0.4, True, 0.01, "held_out"),
    ],
)
def test_a_single_block_does_not_decide_against_effects_of_which_much_is_expected(
    monkeypatch, left, most_gain, most_growth, decided_by
):
    """Held-out errors in metres grow. If most blocks gain, effects that are expected to leave 40 % of the error are shipped, and not with 60 %; nor
    if the whole error grows beyond a limit.
    """
    state = fitted(83, Flaws(joints=on_joint(3, lambda at: 1e-3 * at.q[:, 2])))
    expected = {"errors_as_chosen": (left,) * 3, "errors_without": (1.0,) * 3, "std_without": 9.0}
    module = "scalar.diagnosis.shipping.shipped_fit."
    monkeypatch.setattr(
        module + "focused_choice", lambda found, _: replace(focused_choice(found), **expected)
    )
    monkeypatch.setattr(module + "no_worse", lambda without, _: without is not held_out_errors(state))
    monkeypatch.setattr(module + "improves_with_limited_blocks", lambda *_: most_gain)
    monkeypatch.setattr(module + "TWICE", most_growth)
    assert shipped_fit(state, state.refitted([JointScale(3)]), None).decided_by == decided_by
