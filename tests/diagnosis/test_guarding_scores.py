"""Thresholds of the score test and of held-out poses: each is tested with numbers on both sides of it, so that half or double the threshold changes
the decision.

``snakemake sensitivity`` names these tests for thresholds on which no blind set depends.
"""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from scalar.diagnosis.fit.background import Background
from scalar.diagnosis.held_out.hold_out import HeldOutErrors, blocks, improvement, no_worse
from scalar.diagnosis.held_out.repetitions import first_of_repetitions, moving_joints
from scalar.diagnosis.scoring.score_test import Projected, in_prior_units, remainder
from scalar.diagnosis.settings import DEFAULTS
from tests.diagnosis.stand_ins import doubled

SCORE, HOLD_OUT = DEFAULTS.score_test, DEFAULTS.hold_out


def background(settings: Any = SCORE, columns: Any = None) -> Background:
    """Return the background of 40 poses of three rows; one column is fitted unless others are given."""
    rng = np.random.default_rng(0)
    r, J = rng.standard_normal(120), rng.standard_normal((120, 1))
    return Background.of(r, J if columns is None else columns, 40, 3, settings)


def test_a_column_that_is_all_but_explained_is_not_scored():
    """The model leaves 15 millionths of the column's squared length: it is scored with a threshold of 10 millionths, and not with 20."""
    rng = np.random.default_rng(0)
    fitted, other = np.linalg.qr(rng.standard_normal((120, 2)))[0].T
    E = (fitted + np.sqrt(1.5e-5) * other)[:, None]
    for settings, scored in ((SCORE, True), (doubled(SCORE, "unobservable_share"), False)):
        given = background(settings, fitted[:, None])
        found = Projected.of(given, E, E.T @ E, np.array([np.inf]))
        assert bool(found.gram.any()) == scored


def test_a_column_of_rounding_adds_no_direction():
    """The second column differs from the first by 1.5e-10 of its length: it adds a direction with a tolerance of 1e-10, and none with 2e-10."""
    first, other = np.linalg.qr(np.random.default_rng(1).standard_normal((120, 2)))[0].T
    columns = np.column_stack([first, first + 1.5e-10 * other])
    assert background(SCORE, columns).degrees_of_freedom == 118
    assert background(doubled(SCORE, "rank_tolerance"), columns).degrees_of_freedom == 119


def test_a_coefficient_without_a_prior_is_given_a_wide_one():
    """Its prior standard deviation is the stated number of standard errors; a coefficient with a prior keeps it."""
    sizes, squared = np.array([np.inf, 0.3]), np.array([4.0, 4.0])
    usual, wider = (
        in_prior_units(background(s), squared, sizes) for s in (SCORE, doubled(SCORE, "std_without_prior"))
    )
    np.testing.assert_allclose(wider / usual, [2.0, 1.0])
    # A thousand standard errors: an estimate is shrunk by a millionth.
    assert usual[0] == pytest.approx(1000 * np.sqrt(background().variance / 4.0))


def test_no_gain_leaves_less_than_a_share_of_the_noise():
    """If nine tenths of the residual are explained, the remaining variance is taken to be a fifth of the noise, or two fifths with the threshold
    doubled.
    """
    given = background()
    left = [
        remainder(replace(given, settings=s), 0.9 * given.sum_of_squares, 1)
        for s in (SCORE, doubled(SCORE, "least_remainder"))
    ]
    assert left[1][0] == pytest.approx(2 * left[0][0])
    assert left[0][0] > 0.1 * given.sum_of_squares


def test_poses_within_reach_of_one_another_are_repetitions():
    """Poses that differ by three milliradians in one joint are two poses with a threshold of two milliradians, and one pose with four."""
    q = np.array([[0.0, 1.0], [0.003, 1.0], [0.5, 0.5]])
    assert list(first_of_repetitions(q, HOLD_OUT.same_pose)) == [0, 1, 2]
    assert list(first_of_repetitions(q, 2 * HOLD_OUT.same_pose)) == [0, 0, 2]


def test_a_joint_that_hardly_moves_what_is_measured_makes_no_other_pose():
    """With derivatives of 0.007 and 0.015 of the largest, only the second joint distinguishes poses; with the threshold halved both do, and with it
    doubled neither does.
    """
    rows = SimpleNamespace(derivatives_by_joint=lambda residuals, model: np.array([0.007, 0.015, 1.0]))
    state: Any = SimpleNamespace(rows=rows, residuals=None, model=None, settings=DEFAULTS)
    assert list(moving_joints(state)) == [False, True, True]


def test_poses_are_held_out_in_folds_of_blocks():
    """A hundred poses have the stated number of folds, and the stated number of blocks in all."""
    for settings in (HOLD_OUT, doubled(HOLD_OUT, "folds"), doubled(HOLD_OUT, "blocks_per_fold")):
        block, fold = blocks(np.arange(100.0)[:, None], settings)
        assert fold.max() + 1 == settings.folds
        assert block.max() + 1 == settings.folds * settings.blocks_per_fold


def errors(squared: Any, metric: float = 1.0, settings: Any = HOLD_OUT) -> HeldOutErrors:
    """Return held-out errors of blocks of one pose each."""
    n = len(squared)
    return HeldOutErrors(np.asarray(squared), np.full(n, metric), np.ones(n), np.arange(n), settings)


def test_the_gain_of_one_block_is_limited():
    """If nineteen blocks gain one each and the last gains eight, it counts for five.

    With the threshold doubled it counts for eight, and the scatter is larger.
    """
    drop = np.r_[np.ones(19) + 0.2 * np.tile([1, -1], 10)[:19], 8.0]
    usual, wide = (
        improvement(errors(drop + 5, settings=s), errors(np.full(20, 5.0)))
        for s in (HOLD_OUT, doubled(HOLD_OUT, "most_gain_of_block"))
    )
    assert usual > wide


def test_a_pose_far_beyond_the_noise_does_not_decide():
    """Twenty poses gain one each, and one whose squared error is a hundred times the median and more loses far more than all of them gain.

    It counts for no loss; with the threshold doubled it counts for one, and hides the gain.
    """
    drop = 1 + 0.2 * np.tile([1, -1], 10)
    after = errors(np.r_[np.full(20, 5.0), 5000.0])
    usual, wide = (
        improvement(errors(np.r_[drop + 5, 700.0], settings=s), after)
        for s in (HOLD_OUT, doubled(HOLD_OUT, "most_of_pose"))
    )
    assert usual > 2 and wide < 0


def test_an_error_in_metres_may_grow_by_a_little():
    """A growth by one and a half percent is too much with a tolerance of one percent, and not with two."""
    after = errors(np.ones(4), 1.015**2)
    assert not no_worse(errors(np.ones(4)), after)
    assert no_worse(errors(np.ones(4), settings=doubled(HOLD_OUT, "tolerated_growth")), after)
