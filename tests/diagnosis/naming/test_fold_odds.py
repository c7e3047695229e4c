"""The least log odds of an effect when one fold is left out: against no effect, part by part, and against rivals."""

import numpy as np
import pytest

from scalar.diagnosis.fit.fitted_state import FittedState, refit
from scalar.diagnosis.held_out.hold_out import blocks
from scalar.diagnosis.naming.fold_odds import fold_odds, without_each_fold
from scalar.effects import Effect
from scalar.effects.joint_harmonic import JointHarmonic
from scalar.effects.joint_scale import JointScale
from scalar.estimation.geometry_fit import geometry_fit
from tests.effects.injected import Flaws, PoseData, make_cell


def gear(at: PoseData) -> np.ndarray:
    """Return a gear error of the second order of joint 2."""
    error = np.zeros_like(at.q)
    error[:, 1] = 6e-4 * np.sin(2 * at.q[:, 1] + 0.3)
    return error


def state_with(effect: Effect, joints=gear) -> FittedState:
    """Return a workcell of 60 poses fitted with an effect."""
    dataset = make_cell(Flaws(joints=joints), seed=91, poses_per_plane=20).dataset
    model, prepared = geometry_fit(dataset, effects_follow=True)
    return refit(dataset, model, prepared.free, [effect])


def odds_of(state: FittedState, *others: Effect) -> np.ndarray:
    """Return the least log odds of the state's first effect."""
    return fold_odds(0, others, without_each_fold(state))


def test_an_injected_gear_error_keeps_its_odds_without_any_fold():
    """Its log odds against no effect and against rivals stay large, because four fifths of the poses have most of its evidence."""
    odds = odds_of(state_with(JointHarmonic(2, (2,))), JointScale(2), JointHarmonic(2, (3,)))
    assert odds.shape == (3,) and odds.min() > 5.0


def test_an_order_that_is_not_there_is_the_weakest_part():
    """The log odds of an effect against no effect are those of its weakest order."""
    right = odds_of(state_with(JointHarmonic(2, (2,))))
    more = odds_of(state_with(JointHarmonic(2, (2, 9))))
    assert right[0] > 20.0 and more[0] < 3.0


def test_an_effect_of_one_fold_has_no_odds_without_it():
    """If a gear errs in the poses of one fold only, its least log odds, those without that fold, are about zero."""
    cell = make_cell(seed=91, poses_per_plane=20)
    fold = blocks(cell.dataset.q)[1]

    def in_one_fold(at: PoseData) -> np.ndarray:
        return gear(at) * (fold == 0)[:, None]

    state = state_with(JointHarmonic(2, (2,)), in_one_fold)
    assert odds_of(state)[0] == pytest.approx(0.0, abs=3.0)
