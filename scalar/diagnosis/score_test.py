"""How much of a residual each candidate would explain given everything the model already fits: a score test without a refit.

With Q an orthonormal basis of the Jacobian's columns, ``E' = E - Q Q' E`` is the part of a candidate's columns that the model does not span, and
``gain = r' E' (E' E')^+ E' r`` is the drop of the squared residual if the candidate were added (Frisch, Waugh and Lovell). Directions in which E'
is almost zero are not scored, because an almost unobservable column explains nothing but rounding errors. Combinations that the data determine
less well than their prior does are not scored either, because their coefficients would be implausibly large.

Rows are whitened, but the residual of an incomplete model is larger than the noise. Gains are therefore compared with the residual that would
remain: by an F test, and by the log evidence (half the drop of the Bayesian information criterion, less the log of the number of candidates).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from scipy import linalg
from scipy.special import fdtrc

from scalar.diagnosis.settings import DEFAULTS, ScoreTestSettings
from scalar.geometry.se3 import Array


@dataclass(frozen=True, eq=False)
class Background:
    """A fitted model's residual and everything it already explains.

    Attributes:
        residual: ``(N, m)``, without its components along what the model explains.
        Q: ``(N m, F)``, orthonormal together with its rows on priors.
        degrees_of_freedom: Of the residual.
        R: ``(F, K)``: the Jacobian by the K free coordinates is ``Q R``, priors included.
        along: ``(F,)``, the rows' components along Q, priors included.
        settings: Thresholds.
        released: ``(N m, w)`` or None: orthonormal directions within Q that the model no longer explains, because an effect was left out.
    """

    residual: Array
    Q: Array
    degrees_of_freedom: int
    R: Array
    along: Array
    settings: ScoreTestSettings
    released: Array | None = None

    @classmethod
    def of(
        cls,
        residual: Array,
        jacobian: Array,
        n_poses: int,
        rows_per_pose: int,
        settings: ScoreTestSettings = DEFAULTS.score_test,
    ) -> Background:
        """Return the background of whitened rows and the Jacobian by what is free; rows beyond the poses' are priors.

        Rows that are zero for every model (a scan of two points has no curvature) are not counted.
        """
        norms = np.linalg.norm(jacobian, axis=0)
        scale = np.where(norms > 0, norms, 1.0)
        Q, R = _triangular(jacobian / scale, settings.rank_tolerance)
        R = R * scale
        along = Q.T @ residual
        rest = residual - Q @ along
        measured = n_poses * rows_per_pose
        live = int(np.count_nonzero(np.any(jacobian != 0, axis=1)))
        degrees_of_freedom = max(live - Q.shape[1], 1)
        return cls(rest[:measured].reshape(n_poses, -1), Q[:measured], degrees_of_freedom, R, along, settings)

    def without(self, removed: Array, coefficients: Array, n_priors: int) -> Background:
        """Return the background of the model without some of its columns, in which it is linear. Q is updated and not factorised again.

        With N the directions that the other columns do not span, in the coordinates of Q, the residual gains ``Q N N' (Q' r - R c)``.

        Args:
            removed: ``(K,)`` bool, the columns to leave out.
            coefficients: ``(k,)``, their coefficients.
            n_priors: Number of rows of priors that are left out with them.
        """
        others = self.R[:, ~removed]
        norms = np.linalg.norm(others, axis=0)
        pivoted: Any = linalg.qr(others / np.where(norms > 0, norms, 1.0), pivoting=True)
        basis, triangle, _ = pivoted
        freed = basis[:, np.count_nonzero(np.abs(np.diag(triangle)) > self.settings.rank_tolerance) :]
        gained = freed.T @ (self.along - self.R[:, removed] @ coefficients)
        released = self.Q @ freed
        residual = self.residual + (released @ gained).reshape(self.residual.shape)
        degrees_of_freedom = max(self.degrees_of_freedom + freed.shape[1] - n_priors, 1)
        return replace(self, residual=residual, degrees_of_freedom=degrees_of_freedom, released=released)

    @cached_property
    def sum_of_squares(self) -> float:
        """Return the sum of squares of the residual."""
        return float(np.sum(self.residual**2))

    @property
    def variance(self) -> float:
        """Return the residual's mean square over its degrees of freedom: 1 where the noise explains it."""
        return self.sum_of_squares / self.degrees_of_freedom


def _triangular(columns: Array, tolerance: float) -> tuple[Array, Array]:
    """Return Q ``(n, F)``, an orthonormal basis of columns ``(n, K)`` of unit or no length, and R ``(F, K)`` with ``columns = Q R``."""
    Q, R = np.linalg.qr(columns)
    if np.all(np.abs(np.diag(R)) > tolerance):
        return Q, R
    # Without pivoting, a column that adds no direction would occupy a column of Q, and later columns would be expressed by it.
    pivoted: Any = linalg.qr(columns, mode="economic", pivoting=True)
    Q, R, order = pivoted
    rank = np.count_nonzero(np.abs(np.diag(R)) > tolerance)
    back = np.empty_like(order)
    back[order] = np.arange(len(order))
    return Q[:, :rank], R[:rank, back]


@dataclass(frozen=True, eq=False)
class Projected:
    """Columns conditional on a model: the gain of any group of them follows from their products, without another pass over the rows.

    Attributes:
        variance: Of the residual.
        gram: ``(e, e)``, ``E'^T E'``, in units of the prior standard deviations and of the residual's variance.
        projection: ``(e,)``, ``E'^T r`` in the same units.
        share: ``(e,)``, ``|E'|^2 / |E|^2`` of each column.
    """

    variance: float
    gram: Array
    projection: Array
    share: Array

    @classmethod
    def of(cls, background: Background, E: Array, own_gram: Array, prior_std: Array) -> Projected:
        """Return the columns conditional on a background.

        Args:
            background: Of the fitted model.
            E: ``(N m, e)``.
            own_gram: ``E^T E``, which does not depend on the background.
            prior_std: ``(e,)``, prior standard deviations of the coefficients.
        """
        return cls.with_gram(background, E, gram_given(background, E, own_gram), np.diag(own_gram), prior_std)

    @classmethod
    def with_gram(
        cls, background: Background, E: Array, gram: Array, squared_lengths: Array, prior_std: Array
    ) -> Projected:
        """Return the same, where ``E'^T E'`` ``(e, e)`` and the columns' squared lengths ``(e,)`` are known."""
        share, scale = observable_share(background, np.diag(gram), squared_lengths, prior_std)
        return cls(
            background.variance,
            gram * (scale[:, None] * scale[None, :]) / background.variance,
            (E.T @ background.residual.ravel()) * scale / background.variance,
            share,
        )

    def score(self, groups: Array) -> tuple[Array, Array, Array]:
        """Return gain, degrees of freedom and observability ``(T,)`` each of groups of columns ``(T, w)``."""
        gain, dof = shrunk_gain(self.gram[groups[:, :, None], groups[:, None, :]], self.projection[groups])
        return self.variance * gain, dof, np.sqrt(self.share[groups].max(axis=1, initial=0.0))

    def forward(self, groups: Array, least_drop: float) -> list[int]:
        """Return the groups of columns ``(T, w)`` that forward selection takes, best first.

        It ends when no group lowers the squared residual by ``least_drop`` for each of its columns. After each step the remaining columns and the
        residual are made conditional on the group that was taken.
        """
        width = groups.shape[1]
        columns = groups.ravel()
        G, s = self.gram[np.ix_(columns, columns)].copy(), self.projection[columns].copy()
        local = np.arange(len(columns)).reshape(groups.shape)
        chosen: list[int] = []
        while len(chosen) < len(groups):
            gain, dof = shrunk_gain(G[local[:, :, None], local[:, None, :]], s[local])
            gain[chosen] = -np.inf
            best = int(np.argmax(gain))
            if dof[best] == 0 or self.variance * gain[best] < least_drop * width:
                break
            chosen.append(best)
            taken = local[best]
            solved = np.linalg.solve(
                G[np.ix_(taken, taken)] + np.eye(width), np.column_stack([G[taken], s[taken]])
            )
            across = G[:, taken]
            s = s - across @ solved[:, -1]
            G = G - across @ solved[:, :-1]
        return chosen


def gram_given(background: Background, E: Array, own_gram: Array) -> Array:
    """Return ``E'^T E'`` ``(e, e)`` of columns conditional on a background."""
    A = background.Q.T @ E
    gram = own_gram - A.T @ A
    if background.released is not None:
        B = background.released.T @ E
        gram = gram + B.T @ B
    return gram


def observable_share(
    background: Background, given: Array, squared_lengths: Array, prior_std: Array
) -> tuple[Array, Array]:
    """Return ``|E'|^2 / |E|^2`` ``(e,)`` of columns, and the factor ``(e,)`` on each: zero if the column is almost unobservable.

    Args:
        background: Of the fitted model.
        given: ``(e,)``, squared lengths of the columns conditional on it.
        squared_lengths: ``(e,)``, of the columns.
        prior_std: ``(e,)``, prior standard deviations of the coefficients.
    """
    share = np.where(
        squared_lengths > 0, np.maximum(given, 0.0) / np.where(squared_lengths > 0, squared_lengths, 1.0), 0.0
    )
    scale = in_prior_units(background, squared_lengths, prior_std)
    scale[share <= background.settings.unobservable_share] = 0.0
    return share, scale


def in_prior_units(background: Background, squared_lengths: Array, prior_std: Array) -> Array:
    """Return the factor ``(e,)`` on each column: the prior standard deviation of its coefficient, or many standard errors if it has no prior."""
    without_prior = background.settings.std_without_prior * np.sqrt(
        background.variance / np.maximum(squared_lengths, 1e-300)
    )
    return np.where(np.isfinite(prior_std), prior_std, without_prior)


def shrunk_gain(grams: Array, projections: Array) -> tuple[Array, Array]:
    """Return gains ``(T,)``, divided by the residual's variance, and degrees of freedom ``(T,)`` of grams ``(T, w, w)``, projections ``(T, w)``.

    In the units of ``Projected`` an eigenvalue says how much better the data determine a direction than its prior does: directions with less
    than 1 are left out, the others are shrunk by that much.
    """
    values, components = _in_eigenvectors(grams, projections)
    seen = values > 1.0
    gain = np.sum(np.where(seen, components**2 / (1.0 + np.maximum(values, 0.0)), 0.0), axis=1)
    return gain, seen.sum(axis=1)


def _in_eigenvectors(grams: Array, projections: Array) -> tuple[Array, Array]:
    """Return the eigenvalues ``(T, w)`` of symmetric matrices ``(T, w, w)`` and vectors ``(T, w)`` along their eigenvectors ``(T, w)``.

    Most candidates have one column or two, for which one rotation of Jacobi's method is exact and is made for all matrices at once.
    """
    width = grams.shape[1]
    if width == 1:
        return grams[:, 0], projections
    if width == 2:
        a, b, c = grams[:, 0, 0], (grams[:, 0, 1] + grams[:, 1, 0]) / 2, grams[:, 1, 1]
        half = np.where(b != 0, (c - a) / (2 * np.where(b != 0, b, 1.0)), np.inf)
        tangent = np.copysign(1.0, half) / (np.abs(half) + np.hypot(1.0, half))
        cosine = 1.0 / np.hypot(1.0, tangent)
        x, y = projections.T
        values = np.stack([a - tangent * b, c + tangent * b], axis=1)
        return values, np.stack([x - tangent * y, y + tangent * x], axis=1) * cosine[:, None]
    values, vectors = np.linalg.eigh((grams + np.swapaxes(grams, 1, 2)) / 2)
    return values, np.einsum("tei,te->ti", vectors, projections)


def remainder(background: Background, gain: Array, dof: Array) -> tuple[Array, Array]:
    """Return the squared residuals that would remain after gains, and their degrees of freedom."""
    degrees_of_freedom = np.maximum(background.degrees_of_freedom - dof, 1)
    least = background.settings.least_remainder * degrees_of_freedom * min(1.0, background.variance)
    return np.maximum(background.sum_of_squares - gain, least), degrees_of_freedom


def p_value(background: Background, gain: Array, dof: Array) -> Array:
    """Return the probability of gains at least this large if no effect is present (an F test)."""
    rest, degrees_of_freedom = remainder(background, gain, dof)
    each = np.maximum(dof, 1)
    return np.where(
        dof > 0,
        fdtrc(each, degrees_of_freedom, np.maximum(gain, 0.0) / each / (rest / degrees_of_freedom)),
        1.0,
    )


def evidence(background: Background, gain: Array, dof: Array, log_tried: Array) -> Array:
    """Return the log evidence for candidates [nats]: the gain in fit, less penalties for coefficients and for the number of their kind."""
    rest, _ = remainder(background, gain, dof)
    n = background.degrees_of_freedom
    found = 0.5 * (n * np.log((rest + gain) / rest) - dof * np.log(n)) - log_tried
    return np.where(dof > 0, found, -np.inf)
