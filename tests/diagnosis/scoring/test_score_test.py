"""The score test: its gains are those of a refit, and its p-values are uniform without an effect."""

from math import log

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import kstest

from scalar.diagnosis.fit.background import Background
from scalar.diagnosis.scoring.change_scores import ChangeColumns
from scalar.diagnosis.scoring.ranking import score_of
from scalar.diagnosis.scoring.score_test import Projected, evidence, p_value
from scalar.effects.joint_scale import JointScale

HUGE = 1e9  # a size so large that it shrinks nothing
SHRUNK = 1e-5  # relative: what a prior of many standard errors may take away


def problem(seed, n_poses=40, rows=3, fitted=12, tried=8):
    """Return a whitened linear problem: residual ``(N m,)``, fitted columns, and candidate columns."""
    rng = np.random.default_rng(seed)
    size = n_poses * rows
    J = rng.standard_normal((size, fitted)) * 10.0 ** rng.uniform(-3, 3, fitted)
    E = rng.standard_normal((size, tried)) * 10.0 ** rng.uniform(-2, 2, tried)
    E += J @ (rng.standard_normal((fitted, tried)) / np.linalg.norm(J, axis=0)[:, None]) * 5
    return rng.standard_normal(size), J, E, Background.of(rng.standard_normal(size), J, n_poses, rows)


def squared_after(r, *columns):
    """Return the squared residual after a least-squares fit of columns, by ``lstsq`` alone."""
    A = np.hstack(columns)
    A = A / np.linalg.norm(A, axis=0)
    return float(np.sum((r - A @ np.linalg.lstsq(A, r, rcond=1e-12)[0]) ** 2))


def score_changes(background, E, touched, sizes, margin):
    """Return the scores of columns ``(N, m, e)`` that act from each of the touched poses on."""
    return ChangeColumns.of(background, E, np.flatnonzero(touched), margin).score(background, E, sizes)


def conditional_on(background, E, sizes=HUGE):
    return Projected.of(background, E, E.T @ E, np.full(E.shape[1], sizes))


@given(seed=st.integers(0, 10**6))
def test_the_gain_is_what_a_refit_would_gain(seed):
    """By the theorem of Frisch, Waugh and Lovell, the score is the drop of the squared residual when the columns are added to the fit, for single
    columns and groups, whatever their scales.
    """
    r, J, E, _ = problem(seed)
    background = Background.of(r, J, 40, 3)
    assert background.sum_of_squares == pytest.approx(squared_after(r, J), rel=1e-9)
    assert background.degrees_of_freedom == len(r) - J.shape[1]
    for groups in (np.arange(8)[:, None], np.arange(8).reshape(4, 2), np.arange(8).reshape(1, 8)):
        gain, dof, observability = conditional_on(background, E).score(groups)
        assert np.all(dof == groups.shape[1])
        assert np.all((observability > 0) & (observability <= 1))
        for k, group in enumerate(groups):
            drop = squared_after(r, J) - squared_after(r, J, E[:, group])
            assert gain[k] == pytest.approx(drop, rel=SHRUNK, abs=1e-6)
    together = squared_after(r, J) - squared_after(r, J, E[:, [2, 3, 6, 7]])
    assert conditional_on(background, E).gain_of([3, 1], 2) == (
        pytest.approx(together, rel=SHRUNK, abs=1e-6),
        4,
    )


@given(seed=st.integers(0, 10**6))
def test_forward_selection_is_stepwise_refitting(seed):
    """The terms are added in the order, and up to the step, at which adding the best column with a refit each time adds them."""
    r, J, E, _ = problem(seed, tried=10)
    r = r + E[:, [2, 7]] @ np.array([0.5, -0.4])
    background = Background.of(r, J, 40, 3)
    groups, worth = np.arange(10).reshape(5, 2), 2.0
    taken, now = [], squared_after(r, J)
    while len(taken) < 5:
        left = {
            k: squared_after(r, J, *(E[:, groups[i]] for i in [*taken, k]))
            for k in range(5)
            if k not in taken
        }
        best = min(left, key=left.__getitem__)
        if now - left[best] < worth * 2:
            break
        taken, now = [*taken, best], left[best]
    assert conditional_on(background, E).forward(2, worth) == taken


@given(seed=st.integers(0, 10**6), margin=st.integers(1, 10))
def test_changes_by_cumulative_sums_are_direct_scores(seed, margin):
    """The score for every beginning is that of columns that are zero before it, on the poses that the change touches.

    On both sides of a beginning there are as many of these poses as the margin says, and not fewer than there are columns.
    """
    rng = np.random.default_rng(seed)
    r, J, E, _ = problem(seed, tried=3)
    background = Background.of(r, J, 40, 3)
    touched = rng.random(40) < 0.7
    E = E.reshape(40, 3, 3)
    E[~touched] = 0.0
    sizes = 10.0 ** rng.uniform(-1, 2, 3)
    found = score_changes(background, E, touched, sizes, margin)
    index, least = np.flatnonzero(touched), max(margin, 3)
    assert found.first.tolist() == index[least : len(index) - least + 1].tolist()
    for first, gain, dof in zip(found.first, found.gain, found.dof, strict=True):
        after = E * (np.arange(40) >= first)[:, None, None]
        flat = after.reshape(120, 3)
        direct = Projected.of(background, flat, flat.T @ flat, sizes).score(np.arange(3)[None])
        assert gain == pytest.approx(direct[0][0], rel=1e-6, abs=1e-9)
        assert dof == direct[1][0]


def test_a_change_at_too_few_poses_has_no_score():
    """If the change touches fewer poses than the margins need, it has no score."""
    r, J, E, _ = problem(1, tried=3)
    touched = np.arange(40) < 11
    found = score_changes(
        Background.of(r, J, 40, 3), E.reshape(40, 3, 3), touched, np.full(3, HUGE), margin=6
    )
    assert len(found.gain) == 0


@given(seed=st.integers(0, 10**6), size=st.sampled_from([1e-3, 1.0, HUGE, np.inf]))
def test_what_the_model_already_explains_is_never_scored(seed, size):
    """A column within the span of the fitted columns, and a column of zeros, have no gain and no degree of freedom, however large they are, because
    their remainders are rounding errors.
    """
    r, J, E, _ = problem(seed, tried=3)
    rng = np.random.default_rng(seed)
    E[:, 0] = J @ (rng.standard_normal(J.shape[1]) / np.linalg.norm(J, axis=0))
    E[:, 1] = 0.0
    background = Background.of(100 * r, J, 40, 3)
    gain, dof, observability = conditional_on(background, E, size).score(np.arange(3)[:, None])
    assert not gain[:2].any() and not dof[:2].any()
    assert np.all(observability[:2] < 1e-5)
    assert p_value(background, float(gain[0]), int(dof[0])) == 1.0
    assert evidence(background, float(gain[0]), int(dof[0]), 0.0) == -np.inf


def test_a_direction_determined_worse_than_its_prior_is_left_out():
    """A direction that the data determine less well than its prior does is left out."""
    r, J, E, _ = problem(5, tried=1)
    faint = E / np.linalg.norm(E) * 1e-3  # one unit of the coefficient makes a thousandth of a sigma
    background = Background.of(r, J, 40, 3)
    assert conditional_on(background, faint, 1.0).score(np.zeros((1, 1), dtype=int))[1][0] == 0
    assert conditional_on(background, faint, 1e5).score(np.zeros((1, 1), dtype=int))[1][0] == 1


@pytest.mark.parametrize("scale", [1.0, 4.0])
def test_p_values_are_uniform_where_nothing_is_there(scale):
    """Over 1,500 draws of noise the p-value of a fixed candidate is uniform, also if the noise is larger than stated (Kolmogorov and Smirnov's test
    at 1e-3).
    """
    rng = np.random.default_rng(11)
    _, J, E, _ = problem(6, tried=3)
    found = []
    for _ in range(1500):
        background = Background.of(scale * rng.standard_normal(120), J, 40, 3)
        gain, dof, _ = conditional_on(background, E).score(np.arange(3)[None])
        found.append(p_value(background, float(gain[0]), int(dof[0])))
    assert kstest(found, "uniform").pvalue > 1e-3


def test_evidence_pays_for_complexity_and_for_trying():
    """With the same gain, more degrees of freedom or more candidates mean less evidence; a larger gain means more."""
    r, J, _, background = problem(7)
    assert len(r) == 120 and J.shape[1] == 12
    assert evidence(background, 20.0, 1, 0.0) > evidence(background, 20.0, 2, 0.0)
    assert evidence(background, 20.0, 1, 0.0) > evidence(background, 20.0, 1, log(50))
    assert evidence(background, 30.0, 1, 0.0) > evidence(background, 20.0, 1, 0.0)


def test_choices_beyond_the_integers_of_a_machine():
    """A dozen effects, each chosen from some hundreds, are more choices than 64 bits hold: their logarithms are added."""
    background = problem(7)[3]
    effect = JointScale(joint=1)
    alone, apart, together = (
        score_of(background, effect, 20.0, 1, 1.0, tried, tried).evidence for tried in (1, 500, 500**12)
    )
    assert alone - together == pytest.approx(12 * (alone - apart))


def test_rows_without_content_are_no_degrees_of_freedom():
    """Rows that are zero for every model (a scan of two points has no curvature) do not count as degrees of freedom."""
    r, J, _, _ = problem(8)
    dead = np.arange(120) % 3 == 2
    r[dead], J[dead] = 0.0, 0.0
    assert Background.of(r, J, 40, 3).degrees_of_freedom == 80 - 12


@pytest.mark.parametrize("prior_std", [0.01, 0.3, 30.0])
def test_the_variance_of_the_noise_is_found_beside_priors(prior_std):
    """With half as many priors as rows, and parameters drawn from them, the estimated variance is right on average, be they narrow or wide."""
    rng = np.random.default_rng(11)
    N, F = 30, 15
    found = []
    for _ in range(400):
        J = np.vstack([rng.standard_normal((N, F)), np.eye(F) / prior_std])
        truth = prior_std * rng.standard_normal(F)
        r = np.r_[
            J[:N] @ truth + rng.standard_normal(N), np.zeros(F)
        ]  # at parameters of zero, which the priors expect
        found.append(Background.of(r, J, N, 1).variance)
    assert np.mean(found) == pytest.approx(1.0, abs=4 * np.std(found) / np.sqrt(len(found)))


@pytest.mark.parametrize("seed", range(3))
def test_leaving_columns_out_by_update_is_leaving_them_out(seed):
    """The background without some columns, updated from that of the whole model, has the residual, gains and degrees of freedom of a model that never
    had them.
    """
    rng = np.random.default_rng(seed)
    N, m, F, priors = 40, 3, 12, 2
    J = rng.standard_normal((N * m + priors, F))
    J[N * m :] = 0.0
    mine = np.zeros(F, dtype=bool)
    mine[[4, 9]] = True
    J[N * m + np.arange(priors), np.flatnonzero(mine)] = 0.5
    c = rng.standard_normal(2)
    r = rng.standard_normal(len(J)) + J[:, mine] @ c
    updated = Background.of(r, J, N, m).without(mine, c)
    direct = Background.of(r - J[:, mine] @ c, J[:, ~mine], N, m)
    np.testing.assert_allclose(updated.residual, direct.residual, atol=1e-10)
    assert updated.degrees_of_freedom == pytest.approx(direct.degrees_of_freedom, abs=1e-9)
    E = rng.standard_normal((N * m, 5))
    sizes, groups = np.full(5, 1.0), np.array([[0, 1], [2, 3], [3, 4]])
    ours, theirs = (Projected.of(b, E, E.T @ E, sizes).score(groups) for b in (updated, direct))
    for a, b in zip(ours, theirs, strict=True):
        np.testing.assert_allclose(a, b, rtol=1e-8)
    touched = np.ones(N, dtype=bool)
    ours, theirs = (score_changes(b, E.reshape(N, m, 5), touched, sizes, margin=6) for b in (updated, direct))
    np.testing.assert_allclose(ours.gain, theirs.gain, rtol=1e-8)


def test_a_column_that_adds_nothing_hides_no_other():
    """Columns of zeros and copies of columns explain nothing more, wherever they stand, and what other columns explain does not change."""
    rng = np.random.default_rng(7)
    N, m = 30, 3
    plain = rng.standard_normal((N * m, 5))
    padded = np.column_stack([np.zeros(N * m), plain[:, :2], plain[:, 0] - 2 * plain[:, 1], plain[:, 2:]])
    r = rng.standard_normal(N * m)
    ours, theirs = Background.of(r, padded, N, m), Background.of(r, plain, N, m)
    np.testing.assert_allclose(ours.residual, theirs.residual, atol=1e-12)
    assert ours.degrees_of_freedom == theirs.degrees_of_freedom
    np.testing.assert_allclose(ours.Q @ ours.R, padded, atol=1e-12)
    mine, c = np.arange(7) == 5, rng.standard_normal(1)
    left_out = ours.without(mine, c)
    direct = Background.of(r - padded[:, mine] @ c, padded[:, ~mine], N, m)
    np.testing.assert_allclose(left_out.residual, direct.residual, atol=1e-12)
    assert left_out.degrees_of_freedom == pytest.approx(direct.degrees_of_freedom, abs=1e-9)


def test_an_effect_without_columns_earns_nothing():
    """If all coefficients of an effect are fixed, it has no gain, no degree of freedom and no evidence."""
    rng = np.random.default_rng(3)
    background = Background.of(rng.standard_normal(60), rng.standard_normal((60, 4)), 20, 3)
    E = np.zeros((60, 0))
    gain, dof, seen = Projected.of(background, E, E.T @ E, np.zeros(0)).score(np.zeros((1, 0), dtype=int))
    assert (gain[0], dof[0], seen[0]) == (0.0, 0, 0.0)
    assert evidence(background, 0.0, 0, 0.0) == -np.inf
