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

_MOST_KEPT = 2_000_000  # bytes of the products that one kind of change keeps


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
        whole: The background of the model with all its effects.
        projections: ``(T, e)``, products of the columns with its residual.
        shared: ``(T, F, e)``, products of its Q with the columns; None if they would take much memory.
    """

    index: Array
    at: Array
    grams: Array
    squared_lengths: Array
    whole: Background
    projections: Array
    shared: Array | None

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
        # The beginnings are successive, and a slice copies nothing.
        begun = slice(at[0], at[0] + len(at)) if len(at) else slice(0)
        shared = _from_each_on(background.Q, E, index)[begun]
        grams = grams_from[at] - np.swapaxes(shared, 1, 2) @ shared
        squared_lengths, projections = (
            np.einsum("nme,nme->e", Ei, Ei),
            _projections(background, Ei, index)[at],
        )
        kept = shared if shared.nbytes <= _MOST_KEPT else None
        return cls(index, at, grams, squared_lengths, background, projections, kept)

    def score(self, background: Background, E: Array, prior_std: Array) -> ChangeScores:
        """Return the scores for all beginnings.

        Args:
            background: The background of the same model, or of that without some of its effects.
            E: ``(N, m, e)``, the columns if the change begins with the first pose.
            prior_std: ``(e,)``, prior standard deviations of their coefficients.
        """
        projections, shared = self._with_background(background, E)
        grams = self.grams if shared is None else self.grams + np.swapaxes(shared, 1, 2) @ shared
        scale = in_prior_units(background, self.squared_lengths, prior_std)
        grams = grams * ((scale[:, None] * scale[None, :]) / background.variance)
        gain, dof = shrunk_gain(grams, projections * scale / background.variance)
        return ChangeScores(self.index[self.at], background.variance * gain, dof)

    def _with_background(self, background: Background, E: Array) -> tuple[Array, Array | None]:
        """Return the products of the columns with a background's residual ``(T, e)``, and of the directions that it released with them ``(T, w, e)``.

        Where they follow from those with the background of the whole model, the rows are not needed.
        """
        if background is self.whole and background.released is None:
            return self.projections, None
        left_out = background.left_out
        if self.shared is not None and left_out is not None and left_out.whole is self.whole:
            shared = left_out.freed.T @ self.shared
            return self.projections + left_out.gained @ shared, shared
        shared = None
        if background.released is not None:
            shared = _from_each_on(background.released, E, self.index)[self.at]
        return _projections(background, E[self.index], self.index)[self.at], shared


def beginnings(n_poses: int, n_columns: int, margin: int) -> Array:
    """Return with which of the poses that a change touches it may begin, as indices among these poses.

    Args:
        n_poses: Number of poses that it touches.
        n_columns: Number of its columns.
        margin: Least number of these poses before its beginning, and from there on; not fewer than it has columns in any case.
    """
    margin = max(margin, n_columns)
    return np.arange(margin, n_poses - margin + 1)


def _projections(background: Background, Ei: Array, index: Array) -> Array:
    """Return ``E^T r`` ``(len(index), e)``, r the residual of a background, summed as ``_from_each_on`` does; Ei ``(len(index), m, e)`` of E."""
    return np.cumsum(np.einsum("nme,nm->ne", Ei, background.residual[index])[::-1], axis=0)[::-1]


def _from_each_on(Q: Array, E: Array, index: Array) -> Array:
    """Return ``Q^T E`` ``(len(index), F, e)``, each summed over one pose of ``index`` and all those after it."""
    N, m, _ = E.shape
    by_pose = np.swapaxes(Q.reshape(N, m, -1)[index], 1, 2) @ E[index]
    from_end = by_pose[::-1]
    # In place: with many parameters and poses the array is large.
    np.add.accumulate(from_end, axis=0, out=from_end)
    return by_pose
