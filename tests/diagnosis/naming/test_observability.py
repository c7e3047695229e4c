"""Unobservable effects are listed, each with the prediction error that it causes."""

from dataclasses import replace

import numpy as np
import pytest

from scalar.diagnosis.fit.fitted_state import refit, whitened
from scalar.diagnosis.fit.predicted_displacements import random_poses
from scalar.diagnosis.naming import observability
from scalar.diagnosis.naming.observability import prediction_errors, unobservable_effects
from scalar.diagnosis.scoring.candidate_set import candidates
from scalar.effects import registry
from scalar.effects.base_compliance import BaseCompliance
from scalar.effects.joint_compliance import JointCompliance
from scalar.effects.joint_harmonic import JointHarmonic
from scalar.effects.joint_scale import JointScale
from scalar.effects.range_scale import RangeScale
from scalar.estimation.effect_bases import EffectBases
from scalar.estimation.geometry_fit import geometry_fit
from scalar.estimation.kinematics import Kinematics
from tests.effects.injected import Flaws, make_cell
from tests.effects.test_meaning import tilting


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
    sizes = np.diag(effect.natural_sizes)
    errors = prediction_errors(state, effect, E @ sizes, sizes)
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


@pytest.mark.parametrize(("share", "listed"), [(0.007, True), (0.015, False)])
def test_what_leaves_more_than_a_hundredth_is_observable(share, listed, state, monkeypatch):
    """An effect of which the model takes up all but 0.7 % is listed as unobservable, and one of which 1.5 % is left is not."""
    monkeypatch.setattr(observability, "_unexplained", lambda background, columns: share * columns)
    monkeypatch.setattr(observability, "prediction_errors", lambda *_: np.ones(1))
    assert bool(unobservable_effects(state, [JointScale(2)])) == listed


@pytest.mark.parametrize("kind", [kind for kind in registry.BUILT_IN if not kind.flexible])
def test_no_kind_is_said_to_do_no_harm_where_it_does(state, kind):
    """Whatever the kind of effect, if it changes predictions by half a millimetre, its sentence says so."""
    proposed = [*kind.candidates(state.dataset), *(effect for effect, _ in kind.changes(state.dataset))]
    for effect in proposed[:1]:
        words = effect.consequence(5e-4)
        assert "0.50 mm" in words and "no harm" not in words


def test_a_base_that_gives_way_is_listed_beside_a_joint_that_looks_like_it():
    """The compliance of joint 2 explains a tilting base to a fifth; how far a base may tilt unseen is then listed, and only then."""
    cell = make_cell(seed=25, poses_per_plane=4)
    cell = make_cell(
        Flaws(base=tilting(cell.scene.truth, (8.0, 8.0))), seed=25, poses_per_plane=30, noise=2e-5
    )
    model, prepared = geometry_fit(cell.dataset, effects_follow=True)
    rigid = refit(cell.dataset, model, prepared.free, ())
    bent = rigid.refitted([JointCompliance(((2, 2), (2, 3)))])
    beyond_noise = [max(s.residuals.rms(s.model) ** 2 - 2e-5**2, 0.0) for s in (rigid, bent)]
    assert beyond_noise[1] < 0.2**2 * beyond_noise[0]
    proposed = candidates(cell.dataset)
    assert not [u for u in unobservable_effects(rigid, proposed) if u.effect.name == "base_compliance"]
    (base,) = [u for u in unobservable_effects(bent, proposed) if u.effect.name == "base_compliance"]
    assert "compliance of joint 2" in base.consequence
    assert not base.effect.coefficients.any()
