"""Hidden effects: those that every arm has to some degree, and that a model lacks because the data do not show them.

No gear is rigid, and no axis is quite parallel to another (``Effect.in_every_arm``). An effect of this kind that is too small to be found among the
measured poses is missing from the model, and may make a larger error at other poses. With r the whitened residual of a fit, J its derivatives and E
the columns of K such effects, the data say of their coefficients c what is left after the fitted parameters adapt: ``E' = E - J A`` with ``A = J^+
E``. With the prior ``c ~ N(0, S)``, the posterior has covariance ``V = (E'^T E' + S^-1)^-1`` and mean ``-V E'^T r`` (Kennedy and O'Hagan, Journal of
the Royal Statistical Society B 63, 2001, treat what a model lacks in this way). A prediction with derivatives D by the parameters and C by the
coefficients is off by ``(C - D A) c``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from scalar.diagnosis.fitted_state import FittedState
from scalar.effects import Effect
from scalar.effects.registry import known
from scalar.estimation.displacement import displacement_columns
from scalar.geometry.se3 import Array

if TYPE_CHECKING:
    from scalar.data.poses import Poses

PRIOR_SHARE = 0.5  # prior standard deviation of a coefficient over its natural size
_RANK_TOLERANCE = 1e-10  # smaller singular values of the parameters' columns, over the largest, count as zero


@dataclass(frozen=True, eq=False)
class HiddenEffects:
    """Effects that every arm has and a fit lacks, with what the data say of their K coefficients.

    Attributes:
        state: The fit, with F free parameters.
        effects: The effects, their coefficients zero.
        absorbed: ``(F, K)``, by how much the free parameters change for a unit of each coefficient when the fit adapts to it (the matrix A).
        root: ``(K, K + 1)``, independent deviations of the coefficients, of one standard deviation each: a root of the posterior covariance, and
            the posterior mean, which counts as a deviation because the model lacks it.
    """

    state: FittedState
    effects: tuple[Effect, ...]
    absorbed: Array
    root: Array

    @classmethod
    def of(cls, state: FittedState) -> HiddenEffects | None:
        """Return what the data of a fit leave open of such effects; None if there are no such effects for the arm."""
        effects = [effect for kind in known().values() for effect in kind.in_every_arm(state.dataset)]
        if not effects:
            return None
        std = PRIOR_SHARE * np.concatenate([effect.natural_sizes for effect in effects])
        absorbed, left, rest = left_by_fit(state, effects)
        # A residual that the noise does not explain says the less of the coefficients the larger it is.
        variance = max(float(rest @ rest) / max(len(rest) - len(absorbed), 1), 1.0)
        # Coefficients in units of their prior standard deviation.
        scaled = left * std / np.sqrt(variance)
        values, axes = np.linalg.eigh(np.eye(len(std)) + scaled.T @ scaled)
        root = axes / np.sqrt(values)
        mean = -root @ (root.T @ (scaled.T @ rest)) / np.sqrt(variance)
        return cls(state, tuple(effects), absorbed, std[:, None] * np.column_stack([root, mean]))

    @property
    def kinds(self) -> list[str]:
        """Return what the kinds of these effects are called, each once."""
        return list(dict.fromkeys(effect.kind for effect in self.effects))

    def deviations(self, poses: Poses) -> Array:
        """Return by how much predicted positions deviate at N poses ``(3 N, K + 1)`` [m], for each deviation of ``root``."""
        state, model = self.state, self.state.model
        columns = displacement_columns(replace(model, effects=(*model.effects, *self.effects)), poses)
        by_parameters, by_effects = np.split(columns, [len(state.free)], axis=1)
        return (by_effects - by_parameters[:, state.free] @ self.absorbed) @ self.root


def left_by_fit(state: FittedState, effects: Sequence[Effect]) -> tuple[Array, Array, Array]:
    """Return what a fit of R rows and F free parameters leaves of K coefficients of effects that it lacks.

    Returns:
        The changes of the parameters ``(F, K)`` when the fit adapts to a unit of each coefficient, the rows ``(R, K)`` that are left of the
        coefficients' whitened columns then, and the whitened residual ``(R,)``, at its optimum.
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
    return absorbed, E - J @ absorbed, residual - J @ steps[:, -1]


def hidden_effects(state: FittedState) -> HiddenEffects | None:
    """Return the hidden effects of a fit; None if there are none. They are computed once."""
    return state.once(("hidden effects",), lambda: HiddenEffects.of(state))
