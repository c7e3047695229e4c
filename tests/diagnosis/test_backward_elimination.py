"""What the poses held out do not bear out is dropped, part by part."""

import numpy as np
import pytest

from scalar.diagnosis.backward_elimination import eliminate_backward
from scalar.diagnosis.fitted_state import FittedState, refit
from scalar.effects import Effect
from scalar.effects.joint_compliance import JointCompliance
from scalar.effects.joint_harmonic import JointHarmonic
from scalar.effects.joint_scale import JointScale
from scalar.estimation.geometry_fit import geometry_fit
from tests.effects.injected import Flaws, PoseData, make_cell, sag
from tests.random_scene import make_scene


def gear(at: PoseData) -> np.ndarray:
    """Return two orders of joint 2."""
    error = np.zeros_like(at.q)
    error[:, 1] = 6e-4 * np.sin(2 * at.q[:, 1] + 0.3) + 6e-4 * np.sin(7 * at.q[:, 1] + 1.0)
    return error


def state_with(effects: list[Effect], flaws: Flaws, seed: int) -> FittedState:
    """Return a workcell fitted with effects."""
    dataset = make_cell(flaws, seed=seed, poses_per_plane=25).dataset
    model, prepared = geometry_fit(dataset, effects_follow=True)
    return refit(dataset, model, prepared.free, effects)


@pytest.mark.parametrize("seed", [51, 52, 53])
def test_orders_and_effects_that_are_not_there_are_dropped(seed):
    """Two right orders stay, a wrong one and a wrong effect go."""
    effects = [JointHarmonic(2, (2, 7, 11)), JointScale(5)]
    kept = eliminate_backward(state_with(effects, Flaws(joints=gear), seed)).effects
    assert [effect.target for effect in kept] == [{"joint": 2, "orders": [2, 7]}]
    assert np.abs(kept[0].coefficients).max() == pytest.approx(6e-4, rel=0.3)


def test_a_joint_that_does_not_give_way_is_dropped():
    """Of the compliance of joints 2 and 5, of which 2 gives way."""
    truth = make_scene(seed=61).truth
    flaws = Flaws(joints=sag(truth, np.array([0, 1e-5, 0, 0, 0, 0]), np.random.default_rng(61)))
    pairs = tuple((j, f) for j in (2, 5) for f in range(j, 7))
    kept = eliminate_backward(state_with([JointCompliance(pairs)], flaws, 61)).effects
    assert [effect.target for effect in kept] == [{"joints": [2]}]


def test_of_noise_alone_nothing_is_kept():
    """Effects that were put into the model by hand go, all of them."""
    effects = [JointScale(3), JointHarmonic(4, (3,)), JointHarmonic(6, (5,))]
    assert eliminate_backward(state_with(effects, Flaws(), 71)).effects == ()
