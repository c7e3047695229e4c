"""Choose further poses that separate effects which a diagnosis could not distinguish, and that show those which it could not observe.

A question is an effect e of a known size c, and what may explain the data in its place: the geometry, the other effects that were found, and a
rival. If e acts and the model has the rival instead, its best fit leaves residuals whose squared length is the noncentrality (Atkinson and Fedorov,
Biometrika 62, 1975: T-optimality)

    lambda = c' [(M^-1)_ee]^-1 c,   M the information on e and on all parameters that may explain the data in its place.

Its root is the signal in standard errors. Poses are added one by one: each time the one with which the sum over the questions of
log(lambda) grows most, where lambda counts only up to the value that answers a question. One pose changes M by rank m, which gives lambda for
all candidates in a few products of matrices.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from scalar.geometry.se3 import Array

ANSWERED = 25.0
"""Noncentrality from which a question counts as answered: a signal of five standard errors."""
_RANK_TOLERANCE = 1e-12  # smaller eigenvalues, over the largest, count as zero
_LEAST = 1e-6  # lower bound of noncentralities, so that their logarithms are finite


@dataclass(frozen=True, eq=False)
class Question:
    """Whether an effect acts, or what may explain the data in its place.

    Attributes:
        title: The question in words.
        own: ``(k,)``, indices of the effect's coefficients among the P parameters of the rows.
        rest: ``(r,)``, indices of the parameters that may explain the data in its place.
        size: ``(k,)``, the effect's coefficients c, in the units of the parameters.
    """

    title: str
    own: Array
    rest: Array
    size: Array


@dataclass(frozen=True, eq=False)
class Answer:
    """How well poses answer a question.

    Attributes:
        question: The question.
        now: Its noncentrality with the measured poses.
        planned: The same with the planned poses added.
        limit: The same with all candidates added, which no plan exceeds.
        alone: As ``limit``, if nothing else could take the effect's place.
    """

    question: Question
    now: float
    planned: float
    limit: float
    alone: float

    @property
    def separable(self) -> bool:
        """Return whether all candidates together answer the question."""
        return self.limit >= ANSWERED

    @property
    def separated(self) -> bool:
        """Return whether the planned poses answer the question."""
        return self.planned >= ANSWERED


class _QuestionState:
    """A question with the covariance of the parameters that it concerns, as poses are added."""

    def __init__(self, question: Question, start: Array, rows: Array):
        """Begin with the measured poses alone; ``start`` and ``rows`` are as in ``separating_poses``."""
        self.question = question
        index = np.r_[question.rest, question.own].astype(int)
        self.rows = rows[:, :, index]
        self.start = start[np.ix_(index, index)]
        self.covariance = _inverse(self.start)
        self.own = slice(len(question.rest), len(index))

    def value(self) -> float:
        """Return the noncentrality with the poses added so far."""
        return float(self._noncentrality(self.covariance[None, self.own, self.own])[0])

    def values_with(self, which: Array) -> Array:
        """Return, for each of K candidates, the noncentrality if that one is added ``(K,)``."""
        A = self.rows[which]
        AC = A @ self.covariance
        G = AC @ np.swapaxes(A, 1, 2)
        own = AC[:, :, self.own]
        reduction = np.swapaxes(own, 1, 2) @ np.linalg.solve(np.eye(G.shape[1]) + G, own)
        return self._noncentrality(self.covariance[self.own, self.own] - reduction)

    def add(self, i: int) -> None:
        """Add a candidate."""
        A = self.rows[i]
        AC = A @ self.covariance
        self.covariance = self.covariance - AC.T @ np.linalg.solve(np.eye(len(A)) + AC @ A.T, AC)
        self.covariance = (self.covariance + self.covariance.T) / 2

    def value_with_all(self) -> float:
        """Return the noncentrality with all candidates added to the measured poses."""
        A = self.rows.reshape(-1, len(self.start))
        C = _inverse(self.start + A.T @ A)
        return float(self._noncentrality(C[None, self.own, self.own])[0])

    def value_alone(self) -> float:
        """Return the noncentrality with all candidates added to the start, if all other parameters were known."""
        A = self.rows[:, :, self.own].reshape(-1, len(self.question.size))
        c = self.question.size
        return float(c @ (self.start[self.own, self.own] + A.T @ A) @ c)

    def _noncentrality(self, covariance: Array) -> Array:
        """Return ``c' covariance^-1 c`` for covariances ``(K, k, k)`` of the effect's coefficients, ``(K,)``."""
        c = self.question.size
        return np.einsum("i,kij,j->k", c, _inverse(covariance), c)


def _inverse(matrix: Array) -> Array:
    """Return the inverse of a symmetric matrix, or of each of several; the pseudoinverse where one is singular, which finds less to separate."""
    try:
        return np.linalg.inv(matrix)
    except np.linalg.LinAlgError:
        return np.linalg.pinv(matrix, rcond=_RANK_TOLERANCE, hermitian=True)


def separating_poses(
    questions: Sequence[Question], start: Array, rows: Array, count: int
) -> tuple[list[int], list[Answer]]:
    """Return the indices of the candidates to measure next, and the answer to every question.

    Args:
        questions: The questions to answer.
        start: ``(P, P)``, information on all parameters from the measured poses and the priors.
        rows: ``(N, m, P)``, whitened rows of the candidates.
        count: Number of poses to choose.
    """
    states = [_QuestionState(question, start, rows) for question in questions]
    now = [state.value() for state in states]
    limits = [state.value_with_all() for state in states]
    enough = [min(ANSWERED, max(limit, _LEAST)) for limit in limits]
    chosen: list[int] = []
    for _ in range(min(count, len(rows))):
        others = np.setdiff1d(np.arange(len(rows)), chosen)
        score = np.zeros(len(others))
        for state, most in zip(states, enough, strict=True):
            values = state.values_with(others)
            # The small second term breaks ties between candidates that all answer the question.
            score += np.log(np.clip(values, _LEAST, most)) + 1e-3 * np.log(np.maximum(values, _LEAST))
        best = int(others[np.argmax(score)])
        chosen.append(best)
        for state in states:
            state.add(best)
    answers = [
        Answer(state.question, before, state.value(), limit, state.value_alone())
        for state, before, limit in zip(states, now, limits, strict=True)
    ]
    return chosen, answers


def noncentralities(questions: Sequence[Question], start: Array, rows: Array) -> list[float]:
    """Return the noncentrality of each question if poses are added.

    Args:
        questions: The questions to answer.
        start: ``(P, P)``, information without these poses.
        rows: ``(N, m, P)``, whitened rows of the poses, which are all added.
    """
    return [_QuestionState(question, start, rows).value_with_all() for question in questions]
