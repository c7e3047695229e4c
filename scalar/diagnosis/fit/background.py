"""The background of a score test: the residual of a fitted model, and an orthonormal basis of the directions that the model explains already."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from scipy import linalg

from scalar.diagnosis.fit.column_products import Rows
from scalar.diagnosis.settings import DEFAULTS, ScoreTestSettings
from scalar.geometry.se3 import Array

_MOST_KEPT = 2_000_000  # bytes; larger rows (of thousands of poses) are not kept for further products


@dataclass(frozen=True, eq=False)
class LeftOut:
    """How the background of a model without some columns follows from that of the model with all its columns.

    Products of other columns with both follow from their products with the whole background, without another pass over the rows.

    Attributes:
        whole: The background with all columns.
        freed: ``(F, w)``, the directions that are released, in the coordinates of its Q.
        gained: ``(w,)``, the components that the residual gains along them.
    """

    whole: Background
    freed: Array
    gained: Array


@dataclass(frozen=True, eq=False)
class Background:
    """A fitted model's residual, and the directions that the model explains.

    Attributes:
        residual: ``(N, m)``, without its components along the directions that the model explains.
        Q: ``(N m, F)``, a basis of these directions; orthonormal together with the rows of priors, which are not kept.
        degrees_of_freedom: The sum of squares to expect of the residual if the noise is as the whitening assumes it and the parameters are drawn from
            their priors: the number of measured rows less the parameters that the data determine and not the priors (MacKay, 1992).
        n_live: Number of measured rows that are not zero for every model.
        R: ``(F, K)``: the Jacobian by the K free coordinates, rows of priors included, is ``Q R``.
        along: ``(F,)``, the components of the residual along Q before these were removed, rows of priors included.
        settings: Thresholds.
        released: ``(N m, w)`` or None: orthonormal directions within Q that the model no longer explains, because an effect was left out.
        left_out: How the background follows from that of the model with the effect; None if no effect was left out.
    """

    residual: Array
    Q: Array
    degrees_of_freedom: float
    n_live: int
    R: Array
    along: Array
    settings: ScoreTestSettings
    released: Array | None = None
    left_out: LeftOut | None = None

    @classmethod
    def of(
        cls,
        residual: Array,
        jacobian: Array,
        n_poses: int,
        rows_per_pose: int,
        settings: ScoreTestSettings = DEFAULTS.score_test,
    ) -> Background:
        """Return the background of a whitened residual.

        Args:
            residual: ``(N m + priors,)``, the rows of the poses, followed by those of the priors.
            jacobian: ``(N m + priors, K)``, its derivatives by the free parameters. Rows that are zero for every model (a scan of two points has no
                curvature) do not count as degrees of freedom.
            n_poses: N.
            rows_per_pose: m.
            settings: Thresholds.
        """
        norms = np.linalg.norm(jacobian, axis=0)
        scale = np.where(norms > 0, norms, 1.0)
        Q, R = _triangular(jacobian / scale, settings.rank_tolerance)
        R = R * scale
        along = Q.T @ residual
        rest = residual - Q @ along
        measured = n_poses * rows_per_pose
        live = int(np.count_nonzero(np.any(jacobian[:measured] != 0, axis=1)))
        explained = Q.shape[1] - float(np.sum(Q[measured:] ** 2))
        rows = rest[:measured].reshape(n_poses, -1)
        return cls(rows, Q[:measured], max(live - explained, 1.0), live, R, along, settings)

    def without(self, removed: Array, coefficients: Array) -> Background:
        """Return the background of the model without some of its columns, by an update of Q instead of a new factorisation.

        The model has to be linear in the coefficients of these columns. With P the directions that the other columns do not span, in the coordinates
        of Q, the residual gains ``Q P P^T (Q^T r - R c)``.

        Args:
            removed: ``(K,)`` bool, the k columns to leave out.
            coefficients: ``(k,)``, their coefficients c.
        """
        freed = self._spanned_by_these_alone(removed)
        gained = freed.T @ (self.along - self.R[:, removed] @ coefficients)
        released = self.Q @ freed
        residual = self.residual + (released @ gained).reshape(self.residual.shape)
        degrees_of_freedom = self.degrees_of_freedom + float(np.sum(released**2))
        return replace(
            self,
            residual=residual,
            degrees_of_freedom=degrees_of_freedom,
            released=released,
            left_out=LeftOut(self, freed, gained),
        )

    def _spanned_by_these_alone(self, removed: Array) -> Array:
        """Return orthonormal directions ``(F, w)``, in the coordinates of Q, that the columns other than ``removed`` ``(K,)`` do not span."""
        if (
            len(self.R) == self.R.shape[1]
        ):  # no column depends on others: those of R^-T are orthogonal to all columns but their own
            dual = linalg.solve_triangular(
                self.R, np.eye(len(removed))[:, removed], trans=1, check_finite=False
            )
            return np.linalg.qr(dual / np.linalg.norm(dual, axis=0))[0]
        others = self.R[:, ~removed]
        norms = np.linalg.norm(others, axis=0)
        pivoted: Any = linalg.qr(others / np.where(norms > 0, norms, 1.0), pivoting=True)
        basis, triangle, _ = pivoted
        return basis[:, np.count_nonzero(np.abs(np.diag(triangle)) > self.settings.rank_tolerance) :]

    def as_rows(self) -> Rows:
        """Return the directions and the residual as rows ``(N m, F + 1)`` of products with columns, which many searches ask for in turn."""
        return self._kept_rows if self.Q.nbytes <= _MOST_KEPT else Rows(self._with_residual())

    @cached_property
    def _kept_rows(self) -> Rows:
        return Rows(self._with_residual(), keep=True)

    def _with_residual(self) -> Array:
        return np.column_stack([self.Q, self.residual.ravel()])

    @cached_property
    def gram_of_priors(self) -> Array:
        """Return the products of the rows of priors in the orthonormal basis, ``(F, F)``; Q itself holds the rows of the poses alone."""
        return np.eye(self.Q.shape[1]) - self.Q.T @ self.Q

    @cached_property
    def sum_of_squares(self) -> float:
        """Return the sum of squares of the residual."""
        return float(np.sum(self.residual**2))

    @property
    def variance(self) -> float:
        """Return the residual's sum of squares over its degrees of freedom: about 1 if the noise explains the residual."""
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
