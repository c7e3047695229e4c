"""Score tests of a change for all poses at which it may begin: columns that act from one pose on.

``E'^T E'`` and ``E'^T r`` of the columns from each pose on are cumulative sums over the poses, taken from the last one, so all poses together
cost hardly more than one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from scalar.diagnosis.score_test import Background, in_prior_units, shrunk_gain
from scalar.geometry.se3 import Array


@dataclass(frozen=True, eq=False)
class ChangeScores:
    """Scores of a change for each of the T poses at which it may begin.

    Attributes:
        first: ``(T,)``, index of the first pose after the change, in order of acquisition among the poses that it touches.
        gain: ``(T,)``, drop of the squared whitened residual.
        dof: ``(T,)``, number of observable directions.
    """

    first: Array
    gain: Array
    dof: Array


@dataclass(frozen=True, eq=False)
class ChangeColumns:
    """Columns that act from one pose on, for every such pose, given a model: what does not depend on the residual.

    Attributes:
        index: Indices of the poses that the change touches.
        at: ``(T,)``, positions in ``index`` of the poses that may be the first after the change.
        grams: ``(len(at), e, e)``, ``E'^T E'`` of the columns from there on.
        squared_lengths: ``(e,)``, of the columns where they act all the time.
    """

    index: Array
    at: Array
    grams: Array
    squared_lengths: Array

    @classmethod
    def of(cls, background: Background, E: Array, index: Array, margin: int) -> ChangeColumns:
        """Return the products of columns ``(N, m, e)`` that touch the poses ``index``; what a background has released is not regarded.

        The change begins at least ``margin`` poses after the first one that it touches and before the end.
        """
        Ei = E[index]
        grams_from = np.cumsum(np.einsum("nmi,nmj->nij", Ei, Ei)[::-1], axis=0)[::-1]
        at = np.arange(margin, len(index) - margin + 1)
        shared = _from_each_on(background.Q, E, index)[at]
        grams = grams_from[at] - np.swapaxes(shared, 1, 2) @ shared
        return cls(index, at, grams, np.einsum("nme,nme->e", Ei, Ei))

    def score(self, background: Background, E: Array, prior_std: Array) -> ChangeScores:
        """Return the scores given a background of the same model, or one that has released directions of it."""
        projection = np.cumsum(
            np.einsum("nme,nm->ne", E[self.index], background.residual[self.index])[::-1], axis=0
        )[::-1]
        grams = self.grams
        if background.released is not None:
            shared = _from_each_on(background.released, E, self.index)[self.at]
            grams = grams + np.swapaxes(shared, 1, 2) @ shared
        scale = in_prior_units(background, self.squared_lengths, prior_std)
        grams = grams * ((scale[:, None] * scale[None, :]) / background.variance)
        gain, dof = shrunk_gain(grams, projection[self.at] * scale / background.variance)
        return ChangeScores(self.index[self.at], background.variance * gain, dof)


def _from_each_on(Q: Array, E: Array, index: Array) -> Array:
    """Return ``Q^T E`` over the poses of ``index`` from each on, ``(T, F, e)``."""
    N, m, _ = E.shape
    by_pose = np.swapaxes(Q.reshape(N, m, -1)[index], 1, 2) @ E[index]
    return np.cumsum(by_pose[::-1], axis=0)[::-1]
