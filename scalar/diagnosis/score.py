"""How much of a residual each candidate would explain beside everything the model already fits: a score test without a refit.

With Q an orthonormal basis of the Jacobian's columns, ``E' = E - Q Q' E`` is what a candidate's columns hold that the model does not, and
``gain = r' E' (E' E')^+ E' r`` is the drop of the squared residual if the candidate were added (Frisch, Waugh and Lovell). Directions
in which E' is all but nothing are never scored: an almost silent column explains whatever rounding left. Nor are combinations that
the data would know less well than common sense does: an effect of implausible size is none.

Rows are whitened, but a model that lacks something has more residual than noise, so gains are judged against the residual that
would remain: an F test, and an evidence (half the drop of the Bayesian information criterion, less the log of how many were tried).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.stats import f as f_distribution

from scalar.se3 import Array

SILENT_SHARE = 1e-5  # of a column's squared length: with less left beside the model, a direction is silent
_UNBOUNDED = 1e3  # standard errors: the size taken for a coefficient that is not bounded
_LEAST_REMAINDER = 0.2  # of the noise: what a residual is taken to keep, so that no gain looks infinite


@dataclass(frozen=True, eq=False)
class Background:
    """A fitted model's residual and everything it already explains.

    Attributes:
        residual: ``(N, m)``, without its components along Q.
        Q: ``(N m, F)``, orthonormal together with its rows on priors.
        freedom: Degrees of freedom of the residual.
    """

    residual: Array
    Q: Array
    freedom: int

    @classmethod
    def of(cls, residual: Array, jacobian: Array, n_poses: int, rows_per_pose: int) -> Background:
        """Return the background of whitened rows and the Jacobian by what is free; rows beyond the poses' are priors.

        Rows that are zero for every model (a scan of two points has no curvature) are not counted.
        """
        norms = np.linalg.norm(jacobian, axis=0)
        Q, R = np.linalg.qr(jacobian / np.where(norms > 0, norms, 1.0))
        Q = Q[:, np.abs(np.diag(R)) > 1e-10]
        rest = residual - Q @ (Q.T @ residual)
        measured = n_poses * rows_per_pose
        live = int(np.count_nonzero(np.any(jacobian != 0, axis=1)))
        return cls(rest[:measured].reshape(n_poses, -1), Q[:measured], max(live - Q.shape[1], 1))

    @property
    def squared(self) -> float:
        """Return the sum of squares of the residual."""
        return float(np.sum(self.residual**2))

    @property
    def variance(self) -> float:
        """Return the residual's mean square over its degrees of freedom: 1 where the noise explains it."""
        return self.squared / self.freedom

    def gram(self, E: Array) -> tuple[Array, Array, Array]:
        """Return ``E'^T E'``, ``E'^T r`` and the squared lengths of the columns of E ``(N m, e)``."""
        A = self.Q.T @ E
        return E.T @ E - A.T @ A, E.T @ self.residual.ravel(), np.sum(E * E, axis=0)


@dataclass(frozen=True)
class Score:
    """What a candidate would explain.

    Attributes:
        gain: Drop of the squared whitened residual.
        dof: How many of its directions are seen.
        observability: ``|E'| / |E|`` of its best-seen column, 0 to 1.
    """

    gain: float
    dof: int
    observability: float


def score_gram(background: Background, gram: Array, projection: Array, squared: Array, sizes: Array) -> Score:
    """Return the score of columns from ``Background.gram`` and the plausible sizes of their coefficients ``(e,)``."""
    kept = squared > 0
    share = np.zeros(len(squared))
    share[kept] = np.maximum(np.diag(gram)[kept] / squared[kept], 0.0)
    observability = float(np.sqrt(share.max(initial=0.0)))
    kept &= share > SILENT_SHARE
    if not kept.any():
        return Score(0.0, 0, observability)
    gain, dof = _gain(
        background.variance, gram[np.ix_(kept, kept)][None], projection[kept][None], squared[kept], sizes[kept]
    )
    return Score(float(gain[0]), int(dof[0]), observability)


def _gain(variance: float, grams: Array, projections: Array, squared: Array, sizes: Array) -> tuple[Array, Array]:
    """Return gains ``(T,)`` and degrees of freedom ``(T,)`` for grams ``(T, e, e)`` and projections ``(T, e)``.

    In units of the plausible sizes, and of the residual's own variance, an eigenvalue is how much better the data know a direction than
    common sense: directions below 1 are left out, the others are shrunk by that much.
    """
    unbounded = _UNBOUNDED * np.sqrt(variance / np.maximum(squared, 1e-300))
    scale = np.where(np.isfinite(sizes), sizes, unbounded)
    G = grams * (scale[:, None] * scale[None, :]) / variance
    values, vectors = np.linalg.eigh((G + np.swapaxes(G, 1, 2)) / 2)
    components = np.einsum("tei,te->ti", vectors, projections * scale) / variance
    seen = values > 1.0
    gain = variance * np.sum(np.where(seen, components**2 / (1.0 + np.maximum(values, 0.0)), 0.0), axis=1)
    return gain, seen.sum(axis=1)


def remainder(background: Background, gain: float, dof: int) -> tuple[float, int]:
    """Return the squared residual that would remain after a gain, and its degrees of freedom."""
    freedom = max(background.freedom - dof, 1)
    least = _LEAST_REMAINDER * freedom * min(1.0, background.variance)
    return max(background.squared - gain, least), freedom


def p_value(background: Background, gain: float, dof: int) -> float:
    """Return the chance of a gain this large where nothing is there to be explained (an F test)."""
    if dof == 0:
        return 1.0
    rest, freedom = remainder(background, gain, dof)
    return float(f_distribution.sf((gain / dof) / (rest / freedom), dof, freedom))


def evidence(background: Background, gain: float, dof: int, tried: int) -> float:
    """Return the log evidence for a candidate, in nats: fit less complexity less the log of how many of its kind were tried."""
    if dof == 0:
        return -np.inf
    rest, _ = remainder(background, gain, dof)
    n = background.freedom
    return 0.5 * (n * np.log((rest + gain) / rest) - dof * np.log(n)) - np.log(max(tried, 1))


def forward(
    background: Background,
    gram: Array,
    projection: Array,
    squared: Array,
    sizes: Array,
    terms: list[Array],
    worth: float,
) -> list[int]:
    """Return which terms to take, best first, adding one as long as it drops the squared residual by ``worth`` a column.

    Args:
        background: Of the fitted model.
        gram, projection, squared: As of ``Background.gram``, over all terms.
        sizes: Plausible sizes of the coefficients.
        terms: Columns of each term.
        worth: Least gain a column, in whitened squares.
    """
    chosen: list[int] = []
    reached = 0.0
    while len(chosen) < len(terms):
        best, best_gain = -1, reached
        for k in range(len(terms)):
            if k in chosen:
                continue
            columns = np.concatenate([terms[i] for i in (*chosen, k)])
            part = np.ix_(columns, columns)
            gain = score_gram(background, gram[part], projection[columns], squared[columns], sizes[columns]).gain
            if gain - reached > best_gain - reached + 1e-12:
                best, best_gain = k, gain
        if best < 0 or best_gain - reached < worth * len(terms[best]):
            break
        chosen.append(best)
        reached = best_gain
    return chosen


@dataclass(frozen=True, eq=False)
class ChangeScores:
    """Scores of a change at every possible moment.

    Attributes:
        first: ``(T,)``, index of the first pose after the change, in order of acquisition among the poses that it touches.
        gain: ``(T,)``.
        dof: ``(T,)``.
    """

    first: Array
    gain: Array
    dof: Array


def score_changes(background: Background, E: Array, touched: Array, sizes: Array, margin: int) -> ChangeScores:
    """Return the scores of columns that act from one pose on, for every such pose, by cumulative sums: one pass for all.

    Args:
        background: Of the fitted model, poses in order of acquisition.
        E: ``(N, m, e)``, the columns where they act all the time.
        touched: ``(N,)`` bool, the poses on which they act at all.
        sizes: ``(e,)``, plausible sizes of the coefficients.
        margin: Least number of touched poses on each side.
    """
    index = np.flatnonzero(touched)
    T = len(index)
    if T < 2 * margin:
        empty = np.zeros(0)
        return ChangeScores(empty.astype(int), empty, empty.astype(int))
    N, m, e = E.shape
    Q = background.Q.reshape(N, m, -1)[index]
    Ei, r = E[index], background.residual[index]
    moment = np.cumsum(np.einsum("nmi,nmj->nij", Ei, Ei)[::-1], axis=0)[::-1]
    shared = np.cumsum(np.einsum("nmf,nme->nfe", Q, Ei)[::-1], axis=0)[::-1]
    projection = np.cumsum(np.einsum("nme,nm->ne", Ei, r)[::-1], axis=0)[::-1]
    at = np.arange(margin, T - margin + 1)
    grams = moment[at] - np.einsum("tfe,tfg->teg", shared[at], shared[at])
    gain, dof = _gain(background.variance, grams, projection[at], np.einsum("nme,nme->e", Ei, Ei), sizes)
    return ChangeScores(index[at], gain, dof)
