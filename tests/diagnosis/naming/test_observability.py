"""Unobservable effects are listed, each with the prediction error that it causes."""

from dataclasses import replace

import numpy as np
import pytest

from scalar.diagnosis.fit.fitted_state import refit, whitened
from scalar.diagnosis.fit.predicted_displacements import random_poses
from scalar.diagnosis.naming.observability import prediction_errors, unobservable_effects
from scalar.diagnosis.scoring.candidate_set import candidates
from scalar.effects import registry
from scalar.effects.base_compliance import BaseCompliance
from scalar.effects.joint_harmonic import JointHarmonic
from scalar.effects.joint_scale import JointScale
from scalar.effects.range_scale import RangeScale
from scalar.estimation.effect_bases import EffectBases
from scalar.estimation.geometry_fit import geometry_fit
from scalar.estimation.kinematics import Kinematics
from tests.effects.injected import make_cell


@pytest.fixture(scope="module")
def state():
    """Return the fitted state of a workcell without errors."""
    dataset = make_cell(seed=4, poses_per_plane=40, points_per_scan=12, noise=2e-6).dataset
    model, prepared = geometry_fit(dataset)
    return refit(dataset, model, prepared.free, ())


def displaced(state, steps, effect, size):
    """Return the root mean square distance [m] between predictions with parameters changed by ``steps``, and the truth with the effect."""
    poses = random_poses(state)

    def positions(model):
        return Kinematics.of(model, poses, EffectBases.of(model.nominal, poses, model.effects)).T_base_sensor[
            :, :3, 3
        ]

    moved = state.model.with_vector(state.model.vector + steps)
    truth = replace(state.model, effects=(effect.with_coefficients(size),))
    p, q = positions(moved), positions(truth)
    p, q = p - p.mean(0), q - q.mean(0)
    U, _, Vt = np.linalg.svd(p.T @ q)
    R = U @ np.diag([1.0, 1.0, np.sign(np.linalg.det(U @ Vt))]) @ Vt
    return float(np.sqrt(np.mean(np.sum((p @ R - q) ** 2, axis=1))))


@pytest.mark.parametrize(
    "effect", [JointScale(2), JointHarmonic(4, (2,)), BaseCompliance((2,)), RangeScale()]
)
def test_the_error_is_that_of_the_fit_that_absorbs_the_effect(state, effect):
    """The stated error is that between the true arm with the effect and the model whose parameters have absorbed it, by exact kinematics."""
    E = state.columns_of([effect])
    errors = prediction_errors(state, effect, E)
    J = whitened(state.whitening, state.linearised()[1])[: len(E)]
    for k, size in enumerate(effect.natural_sizes):
        steps = np.zeros(len(state.free))
        steps[state.free] = np.linalg.lstsq(J, E[:, k] * size, rcond=1e-10)[0]
        own = np.eye(len(effect.coefficients))[k] * size
        assert errors[k] == pytest.approx(displaced(state, steps, effect, own), rel=0.05)


def test_only_what_leaves_no_residual_is_listed(state):
    """A gain of the laser's range, which scales the whole workcell, is listed with its prediction error; errors of moving joints are not listed."""
    found = {u.effect.name: u for u in unobservable_effects(state, candidates(state.dataset))}
    assert "joint_harmonic" not in found
    gain = found["range_scale"]
    assert gain.observability < 0.01 and gain.prediction_error > 1e-5
    assert "known length" in gain.consequence


@pytest.mark.parametrize("kind", [kind for kind in registry.BUILT_IN if not kind.flexible])
def test_no_kind_is_said_to_do_no_harm_where_it_does(state, kind):
    """Whatever the kind of effect, if it changes predictions by half a millimetre, its sentence says so."""
    proposed = [*kind.candidates(state.dataset), *(effect for effect, _ in kind.changes(state.dataset))]
    for effect in proposed[:1]:
        words = effect.consequence(5e-4)
        assert "0.50 mm" in words and "no harm" not in words
