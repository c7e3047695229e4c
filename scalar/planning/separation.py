"""Which further poses separate causes that a diagnosis could not distinguish, and which show what it could not see.

A question is an effect e of a known size c, and what may take its place: the geometry, the other effects that were found, and a rival. If e acts
and the model has the rival instead, the best fit of these leaves residuals whose squared length is the noncentrality (Atkinson and Fedorov,
Biometrika 62, 1975: T-optimality)

    lambda = c' [(M^-1)_ee]^-1 c,   M the information on e and on all that may take its place.

Its root is the signal in standard errors. Poses are added one by one, each the one with which the sum over the questions of log(lambda), up to
where a question is answered, grows most. One pose changes M by rank m, which gives lambda for all candidates in a few products.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from scalar.geometry.se3 import Array

ANSWERED = 25.0
"""Noncentrality from which a question counts as answered: a signal of five standard errors."""
_LEAST = 1e-6  # noncentrality: below it the logarithm says nothing


@dataclass(frozen=True, eq=False)
class Question:
    """One thing to find out.

    Attributes:
        title: In words.
        own: Indices of the coefficients of the effect.
        rest: Indices of all that may take its place.
        size: ``(k,)``, of the coefficients, in the units of the rows.
    """

    title: str
    own: Array
    rest: Array
    size: Array


@dataclass(frozen=True, eq=False)
class Answered:
    """What becomes of a question.

    Attributes:
        question: Asked.
        now: Its noncentrality with the poses that were measured.
        planned: With the further poses as well.
        limit: With all candidates: more than any plan gives.
    """

    question: Question
    now: float
    planned: float
    limit: float

    @property
    def separable(self) -> bool:
        """Return whether any poses of the candidates answer it."""
        return self.limit >= ANSWERED

    @property
    def separated(self) -> bool:
        """Return whether the planned poses answer it."""
        return self.planned >= ANSWERED


class _Asked:
    """A question with the covariance of what it concerns, as poses are added."""

    def __init__(self, question: Question, start: Array, rows: Array):
        self.question = question
        index = np.r_[question.rest, question.own].astype(int)
        self.rows = rows[:, :, index]
        self.start = start[np.ix_(index, index)]
        self.covariance = np.linalg.inv(self.start)
        self.own = slice(len(question.rest), len(index))

    def value(self) -> float:
        """Return the noncentrality."""
        return float(self._of(self.covariance[None, self.own, self.own])[0])

    def values_with(self, which: Array) -> Array:
        """Return the noncentrality if one of some candidates is added, each ``(K,)``."""
        A = self.rows[which]
        AC = A @ self.covariance
        G = AC @ np.swapaxes(A, 1, 2)
        own = AC[:, :, self.own]
        fall = np.swapaxes(own, 1, 2) @ np.linalg.solve(np.eye(G.shape[1]) + G, own)
        return self._of(self.covariance[self.own, self.own] - fall)

    def add(self, i: int) -> None:
        """Add a candidate."""
        A = self.rows[i]
        AC = A @ self.covariance
        self.covariance = self.covariance - AC.T @ np.linalg.solve(np.eye(len(A)) + AC @ A.T, AC)
        self.covariance = (self.covariance + self.covariance.T) / 2

    def limit(self) -> float:
        """Return the noncentrality with all candidates."""
        A = self.rows.reshape(-1, len(self.start))
        C = np.linalg.inv(self.start + A.T @ A)
        return float(self._of(C[None, self.own, self.own])[0])

    def _of(self, covariance: Array) -> Array:
        c = self.question.size
        return (
            np.linalg.solve(covariance, np.broadcast_to(c[:, None], (len(covariance), len(c), 1)))[:, :, 0]
            @ c
        )


def separating_poses(
    questions: Sequence[Question], start: Array, rows: Array, count: int
) -> tuple[list[int], list[Answered]]:
    """Return the candidates to measure next, and what becomes of every question.

    Args:
        questions: To be answered.
        start: ``(P, P)``, information on all parameters that is there: measured poses and priors.
        rows: ``(N, m, P)``, whitened, of the candidates.
        count: How many poses.
    """
    asked = [_Asked(question, start, rows) for question in questions]
    now = [a.value() for a in asked]
    limits = [a.limit() for a in asked]
    enough = [min(ANSWERED, max(limit, _LEAST)) for limit in limits]
    chosen: list[int] = []
    for _ in range(min(count, len(rows))):
        others = np.setdiff1d(np.arange(len(rows)), chosen)
        score = np.zeros(len(others))
        for a, most in zip(asked, enough, strict=True):
            values = a.values_with(others)
            # Beyond the answer more still counts, a little: it breaks ties.
            score += np.log(np.clip(values, _LEAST, most)) + 1e-3 * np.log(np.maximum(values, _LEAST))
        best = int(others[np.argmax(score)])
        chosen.append(best)
        for a in asked:
            a.add(best)
    answered = [
        Answered(a.question, before, a.value(), limit)
        for a, before, limit in zip(asked, now, limits, strict=True)
    ]
    return chosen, answered


def noncentralities(questions: Sequence[Question], start: Array, rows: Array) -> list[float]:
    """Return the noncentrality of each question if poses are added.

    Args:
        questions: To be answered.
        start: ``(P, P)``, information that is there.
        rows: ``(N, m, P)``, whitened, of all poses that are added.
    """
    return [_Asked(question, start, rows).limit() for question in questions]
