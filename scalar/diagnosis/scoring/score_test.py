"""How much of a residual each candidate would explain given everything the model already fits: a score test without a refit.

With Q an orthonormal basis of the Jacobian's columns, ``E' = E - Q Q^T E`` is the part of a candidate's columns that the model does not span, and
``gain = r^T E' (E'^T E')^+ E'^T r`` is the drop of the squared residual if the candidate were added (Frisch, Waugh and Lovell). Columns of which E'
is almost zero are not scored, because an almost unobservable column explains nothing but rounding errors. Combinations that the data determine
less well than their prior does are not scored either, because their coefficients would be implausibly large.

Rows are whitened, but the residual of an incomplete model is larger than the noise. Gains are therefore compared with the residual that would
remain: by an F test, and by the log evidence (half the drop of the Bayesian information criterion, less the log of the number of candidates).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import fdtrc

from scalar.diagnosis.fit.background import Background
from scalar.geometry.se3 import Array
from scalar.kernels.gains import chosen_forward, shrunk_gains

_NO_LENGTH = 1e-250  # a squared length that stands for none; a variance, however large, is divided by it without an overflow


@dataclass(frozen=True, eq=False)
class Projected:
    """Columns conditional on a model: the gain of any group of them follows from their products, without another pass over the rows.

    Attributes:
        variance: Variance of the residual.
        gram: ``(e, e)``, ``E'^T E'``, for coefficients in units of their prior standard deviations, divided by the residual's variance.
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
            background: The background of the fitted model.
            E: ``(N m, e)``, the columns.
            own_gram: ``(e, e)``, ``E^T E``, which does not depend on the background.
            prior_std: ``(e,)``, prior standard deviations of the coefficients.
        """
        return cls.with_gram(background, E, gram_given(background, E, own_gram), np.diag(own_gram), prior_std)

    @classmethod
    def with_gram(
        cls, background: Background, E: Array, gram: Array, squared_lengths: Array, prior_std: Array
    ) -> Projected:
        """Return the same from ``gram``, ``E'^T E'`` ``(e, e)``, and the squared lengths of the columns ``(e,)``."""
        share, scale = observable_share(background, np.diag(gram), squared_lengths, prior_std)
        return cls(
            background.variance,
            gram * (scale[:, None] * scale[None, :]) / background.variance,
            (E.T @ background.residual.ravel()) * scale / background.variance,
            share,
        )

    def score(self, groups: Array) -> tuple[Array, Array, Array]:
        """Return gain, degrees of freedom and observability, ``(T,)`` each, of T groups of columns with the indices ``groups`` ``(T, w)``."""
        gain, dof = shrunk_gain(self.gram[groups[:, :, None], groups[:, None, :]], self.projection[groups])
        return self.variance * gain, dof, np.sqrt(self.share[groups].max(axis=1, initial=0.0))

    def gain_of(self, groups: Sequence[int], width: int) -> tuple[float, int]:
        """Return gain and degrees of freedom of some of the groups of ``width`` columns that follow one another, all of these together."""
        where = np.array([width * k + i for k in sorted(groups) for i in range(width)])
        gain, dof = shrunk_gain(self.gram[where[:, None], where][None], self.projection[where][None])
        return float(self.variance * gain[0]), int(dof[0])

    def forward(self, width: int, least_drop: float) -> list[int]:
        """Return the indices of the groups of columns that forward selection adds, in the order in which they are added.

        The selection ends when no group lowers the squared residual by ``least_drop`` for each of its columns. After each step the remaining columns
        and the residual are made conditional on the group that was added.

        Args:
            width: Number of columns of each group; the groups follow one another.
            least_drop: Least drop of the squared residual for each column.
        """
        G, s = self.gram, self.projection
        compiled = chosen_forward(G, s, width, least_drop * width / self.variance)
        if compiled is not None:
            return compiled
        local = np.arange(len(s)).reshape(-1, width)
        chosen: list[int] = []
        while len(chosen) < len(local):
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
    """Return ``E'^T E'`` ``(e, e)`` of columns E ``(N m, e)`` conditional on a background, ``own_gram`` being ``E^T E``."""
    A = background.Q.T @ E
    gram = own_gram - A.T @ A
    if background.released is not None:
        B = background.released.T @ E
        gram = gram + B.T @ B
    return gram


def observable_share(
    background: Background, given: Array, squared_lengths: Array, prior_std: Array
) -> tuple[Array, Array]:
    """Return ``|E'|^2 / |E|^2`` ``(e,)`` of columns, and the factor ``(e,)`` of ``in_prior_units`` on each, zero if it is almost unobservable.

    Args:
        background: The background of the fitted model.
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
    """Return the factor ``(e,)`` that gives each coefficient the unit of its prior standard deviation; without a prior, of many standard errors.

    Args:
        background: The background of the fitted model.
        squared_lengths: ``(e,)``, of the columns.
        prior_std: ``(e,)``, prior standard deviations of the coefficients, infinite for those without a prior.
    """
    without_prior = background.settings.std_without_prior * np.sqrt(
        background.variance / np.maximum(squared_lengths, _NO_LENGTH)
    )
    return np.where(np.isfinite(prior_std), prior_std, without_prior)


def shrunk_gain(grams: Array, projections: Array) -> tuple[Array, Array]:
    """Return the gains ``(T,)``, divided by the residual's variance, and the degrees of freedom ``(T,)`` of T groups of w columns.

    In the units of ``Projected`` an eigenvalue v of the gram is the information of the data on a direction over that of its prior. Directions with an
    eigenvalue below 1 are left out; the gain of the others is shrunk by the factor ``v / (1 + v)``.

    Args:
        grams: ``(T, w, w)``, in the units of ``Projected``.
        projections: ``(T, w)``, in the same units.
    """
    compiled = shrunk_gains(grams, projections)
    return _gain_along_eigenvectors(grams, projections) if compiled is None else compiled


def _gain_along_eigenvectors(grams: Array, projections: Array) -> tuple[Array, Array]:
    """Return what ``shrunk_gain`` does, from the eigenvalues of each matrix."""
    values, components = _in_eigenvectors(grams, projections)
    determined = values > 1.0
    gain = np.sum(np.where(determined, components**2 / (1.0 + np.maximum(values, 0.0)), 0.0), axis=1)
    return gain, determined.sum(axis=1)


def _in_eigenvectors(grams: Array, projections: Array) -> tuple[Array, Array]:
    """Return the eigenvalues ``(T, w)`` of symmetric matrices ``(T, w, w)``, and the components ``(T, w)`` of vectors along their eigenvectors.

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
    """Return the squared residuals that would remain, and their degrees of freedom, both in the shape of ``gain`` and ``dof``.

    Args:
        background: The background of the model without the candidates.
        gain: ``(...)``, by how much each candidate lowers the squared residual.
        dof: ``(...)``, number of observable directions of each candidate.
    """
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


def fall(background: Background, gain: Array, dof: Array) -> Array:
    """Return the fall of -2 times the log likelihood ``(...)`` that gains make, twice a number in nats; arguments as for ``remainder``."""
    rest, _ = remainder(background, gain, dof)
    return background.degrees_of_freedom * np.log((rest + gain) / rest)


def evidence(background: Background, gain: Array, dof: Array, log_tried: Array) -> Array:
    """Return the log evidence for candidates [nats]: half the drop of the Bayesian information criterion, less ``log_tried``.

    Args:
        background: The background of the model without them.
        gain: ``(...)``, by how much each candidate lowers the squared residual.
        dof: ``(...)``, number of observable directions of each candidate; if it is zero, the log evidence is minus infinity.
        log_tried: ``(...)``, logarithm of the number of candidates of the same kind.
    """
    n = background.degrees_of_freedom
    found = 0.5 * (fall(background, gain, dof) - dof * np.log(n)) - log_tried
    return np.where(dof > 0, found, -np.inf)
