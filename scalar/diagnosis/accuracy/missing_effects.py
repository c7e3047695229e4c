"""Effects that the model of a fit lacks: how its parameters adapt to them, and by how much predictions are off because of them.

With r the whitened residual of a fit, J its derivatives and E the columns of the effects, a fit that lacks the effects moves its parameters by
``A = J^+ E`` for a unit of each coefficient. The data show of the coefficients only what is left then, ``E' = E - J A``. A prediction with
derivatives D by the parameters and C by the coefficients c is off by ``(C - D A) c``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from scalar.diagnosis.fit.fitted_state import FittedState
from scalar.diagnosis.fit.predicted_displacements import displacement_columns
from scalar.effects import Effect
from scalar.geometry.se3 import Array

if TYPE_CHECKING:
    from scalar.data.poses import Poses

_RANK_TOLERANCE = 1e-10  # smaller singular values of the parameters' columns, over the largest, count as zero


@dataclass(frozen=True, eq=False)
class MissingEffects:
    """Effects that a fit of F free parameters lacks, with K coefficients in all.

    Attributes:
        state: The fit.
        effects: The effects, their coefficients zero.
        absorbed: ``(F, K)``, by how much the free parameters change for a unit of each coefficient when the fit adapts to it (the matrix A).
    """

    state: FittedState
    effects: tuple[Effect, ...]
    absorbed: Array

    @cached_property
    def owner(self) -> Array:
        """Return the index of the effect that each coefficient belongs to ``(K,)``."""
        sizes = np.array([len(effect.coefficients) for effect in self.effects], dtype=int)
        return np.repeat(np.arange(len(self.effects)), sizes)

    @cached_property
    def natural_sizes(self) -> Array:
        """Return the natural sizes of all coefficients ``(K,)``."""
        return np.concatenate([np.zeros(0), *(effect.natural_sizes for effect in self.effects)])

    def only(self, chosen: Array) -> MissingEffects:
        """Return those of the effects that have the indices ``chosen``, in ascending order."""
        of_chosen = np.isin(self.owner, chosen)
        return replace(
            self, effects=tuple(self.effects[i] for i in chosen), absorbed=self.absorbed[:, of_chosen]
        )

    def prediction_errors(self, poses: Poses) -> Array:
        """Return by how much predicted positions are off at N poses ``(3 N, K)`` [m], for a unit of each coefficient (``C - D A``)."""
        free = self.state.free
        columns = displacement_columns(self.state, poses, self.effects)
        by_parameters, by_effects = np.split(columns, [len(free)], axis=1)
        return by_effects - by_parameters[:, free] @ self.absorbed


def without_absorbed(state: FittedState, effects: Sequence[Effect]) -> tuple[MissingEffects, Array, Array]:
    """Return effects that a fit of R rows lacks, and what its data show of them that its parameters cannot explain.

    Returns:
        The effects, with K coefficients. The rows ``(R, K)`` that are left of the whitened columns of the coefficients after the fit has adapted to
        each (E'), and the whitened residual ``(R,)`` at the optimum of the fit.
    """
    residual, J = state.linearised()
    measured = state.columns_within_scans(effects) if effects else np.zeros((0, 0))
    E = np.zeros((len(J), measured.shape[1]))
    E[: len(measured)] = measured
    scale = np.linalg.norm(J, axis=0)
    scale[scale == 0] = 1.0
    both = np.column_stack([E, residual])
    steps = np.linalg.lstsq(J / scale, both, rcond=_RANK_TOLERANCE)[0] / scale[:, None]
    absorbed = steps[:, :-1]
    missing = MissingEffects(state, tuple(effects), absorbed)
    return missing, E - J @ absorbed, residual - J @ steps[:, -1]
