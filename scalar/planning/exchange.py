"""Optimal designs by exchange: which of N candidate poses to measure, so that a criterion of the covariance is least.

Candidate i has m whitened rows A_i, so that a set S has the information ``M = M_0 + sum over S of A_i' A_i`` and the covariance ``C = M^-1``.
The criteria are A, ``trace(B C)``, the variance of what is predicted (B states what that is), and D, ``-log det M``. One candidate changes M by
rank m, so that with
``G = A C A'`` and ``H = A C B C A'`` (Fedorov, Theory of Optimal Experiments, 1972; Mitchell, Technometrics 16, 1974)

    added:    trace(B C) falls by trace((I + G)^-1 H),  log det M grows by log det(I + G)
    removed:  trace(B C) grows by trace((I - G)^-1 H),  log det M falls by -log det(I - G)
    C becomes C -+ C A' (I +- G)^-1 A C

and all candidates together cost a few products of matrices. No candidate is chosen twice. Candidates may belong to groups (the planes that they
measure) of which each keeps a least number.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from scalar.geometry.se3 import Array

_LEAST_LEFT = 1e-10  # smallest eigenvalue of I - G: below it the pose alone determines a direction, and cannot be removed
_WORTH = 1e-9  # relative: a smaller gain of an exchange may be a rounding error


@dataclass(eq=False)
class Design:
    """A set of candidates and its covariance.

    Attributes:
        rows: ``(N, m, F)``, whitened rows of all candidates.
        start: ``(F, F)``, the information M_0 without any candidate; positive definite.
        interest: ``(F, F)``, B of the criterion A, positive semidefinite; None for D.
        chosen: Indices of the candidates in the set.
        covariance: ``(F, F)``, C of the set.
        groups: ``(N,)`` int, the group of every candidate.
        least: The least number of candidates of each group in the set.
    """

    rows: Array
    start: Array
    interest: Array | None
    chosen: list[int]
    covariance: Array
    groups: Array
    least: int = 0

    @classmethod
    def of(
        cls,
        rows: Array,
        start: Array,
        interest: Array | None,
        chosen: list[int] | None = None,
        groups: Array | None = None,
        least: int = 0,
    ) -> Design:
        """Return the design with these candidates chosen, all in one group unless groups are given."""
        groups = np.zeros(len(rows), dtype=int) if groups is None else groups
        design = cls(rows, start, interest, list(chosen or ()), np.zeros_like(start), groups, least)
        design.refresh()
        return design

    def refresh(self) -> None:
        """Compute the covariance anew, without the rounding errors of many updates."""
        A = self.rows[self.chosen].reshape(-1, self.start.shape[0])
        self.covariance = np.linalg.inv(self.start + A.T @ A)

    @property
    def value(self) -> float:
        """Return the criterion, which is to be small: ``trace(B C)``, or ``log det C``."""
        if self.interest is None:
            return float(np.linalg.slogdet(self.covariance)[1])
        return float(np.sum(self.interest * self.covariance))

    def gains(self, which: Array) -> Array:
        """Return, for each of K candidates, by how much the criterion falls if that one is added ``(K,)``."""
        G, H = self._overlaps(which)
        eye = np.eye(G.shape[1])
        if H is None:
            return np.linalg.slogdet(eye + G)[1]
        return np.trace(np.linalg.solve(eye + G, H), axis1=1, axis2=2)

    def losses(self, which: Array) -> Array:
        """Return, for each of K chosen candidates, by how much the criterion grows if that one is removed ``(K,)``; inf if it cannot be."""
        G, H = self._overlaps(which)
        left = np.eye(G.shape[1]) - G
        stays = np.linalg.eigvalsh(left)[:, 0] > _LEAST_LEFT
        safe = np.where(stays[:, None, None], left, np.eye(G.shape[1]))
        loss = (
            -np.linalg.slogdet(safe)[1] if H is None else np.trace(np.linalg.solve(safe, H), axis1=1, axis2=2)
        )
        return np.where(stays, loss, np.inf)

    def add(self, i: int) -> None:
        """Add a candidate."""
        self._update(i, 1.0)
        self.chosen.append(i)

    def remove(self, i: int) -> None:
        """Remove a candidate."""
        self._update(i, -1.0)
        self.chosen.remove(i)

    def others(self) -> Array:
        """Return the indices of the candidates that are not chosen."""
        free = np.ones(len(self.rows), dtype=bool)
        free[self.chosen] = False
        return np.flatnonzero(free)

    def eligible(self) -> Array:
        """Return the candidates that may be added next: those of the groups that have too few, else all that are not chosen."""
        others = self.others()
        short = [g for g in np.unique(self.groups) if np.sum(self.groups[self.chosen] == g) < self.least]
        of_short = others[np.isin(self.groups[others], short)]
        return of_short if len(of_short) else others

    def _overlaps(self, which: Array) -> tuple[Array, Array | None]:
        """Return G and H ``(K, m, m)`` of candidates; H is None for the criterion D."""
        A = self.rows[which]
        AC = A @ self.covariance
        G = AC @ np.swapaxes(A, 1, 2)
        H = None if self.interest is None else (AC @ self.interest) @ np.swapaxes(AC, 1, 2)
        return G, H

    def _update(self, i: int, sign: float) -> None:
        A = self.rows[i]
        AC = A @ self.covariance
        self.covariance = self.covariance - sign * AC.T @ np.linalg.solve(
            np.eye(len(A)) + sign * AC @ A.T, AC
        )
        self.covariance = (self.covariance + self.covariance.T) / 2


def add_best(design: Design, count: int) -> None:
    """Add candidates one by one, each the one that lowers the criterion most; groups that have too few come first."""
    for _ in range(count):
        others = design.eligible()
        if not len(others):
            return
        design.add(int(others[np.argmax(design.gains(others))]))
    design.refresh()


def exchange(design: Design, fixed: int = 0) -> int:
    """Exchange chosen candidates for others as long as the criterion falls; return the number of exchanges.

    The chosen candidate with the smallest loss is removed and the best of all others is put in its place, if that is better; if not, the
    next one is tried. The criterion never grows. At the end no such exchange improves the set.

    Args:
        design: The design, which is changed.
        fixed: Number of candidates at the beginning of ``design.chosen`` that are never exchanged.
    """
    done = 0
    tried: set[int] = set()
    while True:
        free = np.array([i for i in design.chosen[fixed:] if i not in tried], dtype=int)
        if not len(free):
            break
        losses = design.losses(free)
        k = int(np.argmin(losses))
        if not np.isfinite(losses[k]):
            break
        out = int(free[k])
        before, value = design.covariance, abs(design.value)
        place = design.chosen.index(out)
        design.remove(out)
        others = design.eligible()
        gains = design.gains(others)
        into = int(others[np.argmax(gains)])
        if into != out and gains.max() > losses[k] + _WORTH * max(value, float(losses[k])):
            design.add(into)
            done += 1
            tried.clear()
        else:
            design.covariance = before
            design.chosen.insert(place, out)
            tried.add(out)
    design.refresh()
    return done
