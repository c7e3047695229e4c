"""Score tests of a change for all poses at which it may begin. Its columns are zero before that pose.

``E^T E``, ``Q^T E`` and ``E^T r`` of the columns from each pose on are cumulative sums over the poses, from the last pose to the first. The scores
for all poses together therefore cost hardly more than the score for one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from scalar.diagnosis.fit.background import Background
from scalar.diagnosis.scoring.score_test import in_prior_units, shrunk_gain
from scalar.geometry.se3 import Array


@dataclass(frozen=True, eq=False)
class ChangeScores:
    """Scores of a change for each of the T poses at which it may begin.

    Attributes:
        first: ``(T,)``, index of the pose with which the change begins.
        gain: ``(T,)``, drop of the squared whitened residual.
        dof: ``(T,)``, number of observable directions.
    """

    first: Array
    gain: Array
    dof: Array


@dataclass(frozen=True, eq=False)
class ChangeColumns:
    """The columns of a change for each of the T poses at which it may begin: the products that do not depend on the residual.

    Attributes:
        index: Indices of the poses that the change touches.
        at: ``(T,)``, positions in ``index`` of the poses with which the change may begin.
        grams: ``(T, e, e)``, ``E'^T E'`` of the columns of the change that begins there.
        squared_lengths: ``(e,)``, of the columns if the change begins with the first pose.
    """

    index: Array
    at: Array
    grams: Array
    squared_lengths: Array

    @classmethod
    def of(cls, background: Background, E: Array, index: Array, margin: int) -> ChangeColumns:
        """Return the products of a change's columns.

        Args:
            background: The background of a model with all its effects; directions that it has released are not taken into account.
            E: ``(N, m, e)``, the columns if the change begins with the first pose.
            index: Indices of the poses that the change touches.
            margin: As for ``beginnings``.
        """
        Ei = E[index]
        grams_from = np.cumsum(np.einsum("nmi,nmj->nij", Ei, Ei)[::-1], axis=0)[::-1]
        at = beginnings(len(index), E.shape[2], margin)
        shared = _from_each_on(background.Q, E, index)[at]
        grams = grams_from[at] - np.swapaxes(shared, 1, 2) @ shared
        return cls(index, at, grams, np.einsum("nme,nme->e", Ei, Ei))

    def score(self, background: Background, E: Array, prior_std: Array) -> ChangeScores:
        """Return the scores for all beginnings.

        Args:
            background: The background of the same model, or of that without some of its effects.
            E: ``(N, m, e)``, the columns if the change begins with the first pose.
            prior_std: ``(e,)``, prior standard deviations of their coefficients.
        """
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


def beginnings(n_poses: int, n_columns: int, margin: int) -> Array:
    """Return with which of the poses that a change touches it may begin, as indices among these poses.

    Args:
        n_poses: Number of poses that it touches.
        n_columns: Number of its columns.
        margin: Least number of these poses before its beginning, and from there on; not fewer than it has columns in any case.
    """
    margin = max(margin, n_columns)
    return np.arange(margin, n_poses - margin + 1)


def _from_each_on(Q: Array, E: Array, index: Array) -> Array:
    """Return ``Q^T E`` ``(len(index), F, e)``, each summed over one pose of ``index`` and all those after it."""
    N, m, _ = E.shape
    by_pose = np.swapaxes(Q.reshape(N, m, -1)[index], 1, 2) @ E[index]
    return np.cumsum(by_pose[::-1], axis=0)[::-1]
