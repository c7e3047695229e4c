"""The noncentrality agrees with least squares, and poses that separate effects are chosen where there are any."""

import numpy as np
import pytest

from scalar.planning.separation import Question, separating_poses


def left_over(rows, own, rest, size, prior):
    """Return the squared residual if an effect acts and the rest, with weak priors, is fitted in its place."""
    A = rows.reshape(-1, rows.shape[2])
    signal = np.r_[A[:, own] @ size, np.zeros(len(rest))]
    J = np.vstack([A[:, rest], np.diag(np.sqrt(prior[rest]))])
    return np.sum((signal - J @ np.linalg.lstsq(J, signal, rcond=None)[0]) ** 2)


def test_noncentrality_is_the_residual_of_the_wrong_model():
    """The noncentralities now, planned and with all candidates are the squared residuals of the wrong model, fitted on these poses."""
    rng = np.random.default_rng(1)
    rows = rng.standard_normal((12, 2, 6))
    measured = rng.standard_normal((5, 2, 6))
    prior = np.full(6, 1e-9)
    start = np.diag(prior) + np.einsum("nmp,nmq->pq", measured, measured)
    question = Question("q", np.array([4, 5]), np.array([0, 1, 2, 3]), np.array([1.0, -2.0]))
    chosen, (answer,) = separating_poses([question], start, rows, 3)
    for found, poses in (
        (answer.now, measured),
        (answer.planned, np.concatenate([measured, rows[chosen]])),
        (answer.limit, np.concatenate([measured, rows])),
    ):
        expected = left_over(poses, question.own, question.rest, question.size, prior)
        assert found == pytest.approx(expected, rel=1e-5)


def test_the_poses_that_separate_are_found():
    """Two columns agree in all candidates but two: these two answer the question, and all others together do not."""
    rows = np.zeros((30, 1, 3))
    rows[:, 0, 0] = 1.0
    rows[:, 0, 1] = rows[:, 0, 2] = np.linspace(-1, 1, 30)
    rows[[7, 20], 0, 2] += 40.0
    measured = np.delete(rows, [7, 20], axis=0)
    start = 1e-6 * np.eye(3) + np.einsum("nmp,nmq->pq", measured, measured)
    question = Question("q", np.array([2]), np.array([0, 1]), np.array([1.0]))
    chosen, (answer,) = separating_poses([question], start, rows, 2)
    assert set(chosen) & {7, 20}
    assert answer.separated and answer.separable
    assert answer.now < 0.01


def test_what_no_poses_separate_is_said():
    """Where two columns agree in every candidate, no plan separates them, and the other question still gets its poses."""
    rng = np.random.default_rng(3)
    rows = rng.standard_normal((40, 2, 4)) * 4
    rows[:, :, 1] = rows[:, :, 0]
    questions = [
        Question("never", np.array([1]), np.array([0]), np.array([1.0])),
        Question("well", np.array([3]), np.array([0, 2]), np.array([1.0])),
    ]
    chosen, (never, well) = separating_poses(questions, 1e-9 * np.eye(4), rows, 6)
    assert not never.separable and not never.separated
    assert well.separated
    assert len(set(chosen)) == 6


def test_more_poses_never_tell_less():
    """The noncentrality of every question grows with each pose."""
    rng = np.random.default_rng(4)
    rows = rng.standard_normal((25, 1, 5))
    questions = [Question(str(k), np.array([k]), np.arange(3), np.ones(1)) for k in (3, 4)]
    before = [0.0, 0.0]
    for count in range(1, 8):
        _, answers = separating_poses(questions, 1e-6 * np.eye(5), rows, count)
        now = [a.planned for a in answers]
        assert all(n >= b - 1e-9 for n, b in zip(now, before, strict=True))
        before = now


def test_columns_that_are_the_same_do_not_end_a_plan():
    """If two coefficients of an effect move all measurements alike, the information is singular: the plan is as if there were one of them."""
    rng = np.random.default_rng(2)
    rows, measured = rng.standard_normal((12, 2, 4)), rng.standard_normal((5, 2, 4))
    doubled = np.array([0, 1, 2, 3, 3])
    start = np.eye(4) * 1e-9 + np.einsum("nmp,nmq->pq", measured, measured)
    once = Question("q", np.array([3]), np.array([0, 1, 2]), np.array([2.0]))
    twice = Question("q", np.array([3, 4]), np.array([0, 1, 2]), np.array([1.0, 1.0]))
    _, (expected,) = separating_poses([once], start, rows, 2)
    _, (found,) = separating_poses([twice], start[np.ix_(doubled, doubled)], rows[:, :, doubled], 2)
    assert np.isfinite([found.now, found.planned, found.limit]).all()
    assert found.separable == expected.separable
