"""Backward elimination drops the parts of effects that held-out poses do not confirm."""

import numpy as np
import pytest

from scalar.diagnosis.fit.fitted_state import FittedState, refit
from scalar.diagnosis.held_out.hold_out import held_out_errors, held_out_errors_without, improvement
from scalar.diagnosis.scoring.candidate_columns import named_candidates
from scalar.diagnosis.selection.backward_elimination import eliminate_backward
from scalar.effects import Effect
from scalar.effects.joint_compliance import JointCompliance
from scalar.effects.joint_harmonic import JointHarmonic
from scalar.effects.joint_scale import JointScale
from scalar.estimation.geometry_fit import geometry_fit
from tests.effects.injected import Flaws, PoseData, make_cell, sag
from tests.random_scene import make_scene


def gear(at: PoseData) -> np.ndarray:
    """Return a gear error of two orders of joint 2."""
    error = np.zeros_like(at.q)
    error[:, 1] = 6e-4 * np.sin(2 * at.q[:, 1] + 0.3) + 6e-4 * np.sin(7 * at.q[:, 1] + 1.0)
    return error


def state_with(effects: list[Effect], flaws: Flaws, seed: int) -> FittedState:
    """Return a workcell fitted with effects."""
    dataset = make_cell(flaws, seed=seed, poses_per_plane=25).dataset
    model, prepared = geometry_fit(dataset, effects_follow=True)
    return refit(dataset, model, prepared.free, effects)


def eliminated(state: FittedState) -> tuple[Effect, ...]:
    """Return the effects that remain of those of a state."""
    return eliminate_backward(state, named_candidates(state.dataset)).effects


@pytest.mark.parametrize("seed", [51, 52, 53])
def test_orders_and_effects_that_are_not_there_are_dropped(seed):
    """Two injected orders stay; an order and an effect that were not injected are dropped."""
    effects = [JointHarmonic(2, (2, 7, 11)), JointScale(5)]
    kept = eliminated(state_with(effects, Flaws(joints=gear), seed))
    assert [effect.target for effect in kept] == [{"joint": 2, "orders": [2, 7]}]
    assert np.abs(kept[0].coefficients).max() == pytest.approx(6e-4, rel=0.3)


def test_a_joint_without_compliance_is_dropped():
    """Of a compliance of joints 2 and 5, only that of joint 2 was injected, and only it stays."""
    truth = make_scene(seed=61).truth
    flaws = Flaws(joints=sag(truth, np.array([0, 1e-5, 0, 0, 0, 0]), np.random.default_rng(61)))
    pairs = tuple((j, f) for j in (2, 5) for f in range(j, 7))
    kept = eliminated(state_with([JointCompliance(pairs)], flaws, 61))
    assert [effect.target for effect in kept] == [{"joints": [2]}]


def test_no_effect_is_kept_on_noise_alone():
    """If nothing was injected, all effects that the model is given are dropped."""
    effects = [JointScale(3), JointHarmonic(4, (3,)), JointHarmonic(6, (5,))]
    assert eliminated(state_with(effects, Flaws(), 71)) == ()


@pytest.mark.parametrize("seed", [81, 82])
def test_errors_without_a_part_are_those_of_a_refit(seed):
    """Held-out errors without one order of a gear, or without one of two effects, are predicted by linear fits as a refit gives them."""
    state = state_with([JointHarmonic(2, (2, 7)), JointScale(5)], Flaws(joints=gear), seed)
    refitted = [
        (JointHarmonic(2, (7,)), JointScale(5)),
        (JointHarmonic(2, (2,)), JointScale(5)),
        (JointHarmonic(2, (2, 7)),),
    ]
    coefficients = [np.array([0, 1]), np.array([2, 3]), np.array([4])]
    complete = held_out_errors(state)
    predicted = held_out_errors_without(state, coefficients)
    for effects, errors in zip(refitted, predicted, strict=True):
        trial = held_out_errors(state.refitted(effects))
        assert errors.rms == pytest.approx(trial.rms, rel=1e-3)
        assert improvement(errors, complete) == pytest.approx(improvement(trial, complete), abs=0.02)
    assert predicted[0].rms > 1.5 * complete.rms
