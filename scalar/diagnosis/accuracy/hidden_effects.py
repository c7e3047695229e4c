"""Hidden effects: those that every arm has to some degree, and that a model lacks because the data do not show them.

No gear is rigid, and no axis is quite parallel to another (``Effect.in_every_arm``). An effect of this kind that is too small to be found among the
measured poses is missing from the model, and may make a larger error at other poses. With the prior ``c ~ N(0, S)`` of the coefficients c, and with
r and E' the residual and the columns of the effects given the fitted parameters (``missing_effects``), the posterior has covariance
``V = (E'^T E' + S^-1)^-1`` and mean ``-V E'^T r`` (Kennedy and O'Hagan, Journal of the Royal Statistical Society B 63, 2001, treat what a model lacks
in this way).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from scalar.diagnosis.accuracy.missing_effects import MissingEffects, without_absorbed
from scalar.diagnosis.fit.fitted_state import FittedState
from scalar.effects.registry import known
from scalar.geometry.se3 import Array

if TYPE_CHECKING:
    from scalar.data.poses import Poses

PRIOR_SHARE = 0.5  # prior standard deviation of a coefficient over its natural size


@dataclass(frozen=True, eq=False)
class HiddenEffects:
    """Effects that every arm has and a fit lacks, with what the data say of their K coefficients.

    Attributes:
        missing: The effects, given the fit that lacks them.
        root: ``(K, K + 1)``, independent deviations of the coefficients, of one standard deviation each: a root of the posterior covariance, and
            the posterior mean, which counts as a deviation because the model lacks it.
    """

    missing: MissingEffects
    root: Array

    @classmethod
    def of(cls, state: FittedState) -> HiddenEffects | None:
        """Return what the data of a fit leave open of such effects; None if there are no such effects for the arm."""
        effects = [effect for kind in known().values() for effect in kind.in_every_arm(state.dataset)]
        if not effects:
            return None
        missing, left, rest = without_absorbed(state, effects)
        std = PRIOR_SHARE * missing.natural_sizes
        # A residual that the noise does not explain says the less of the coefficients the larger it is.
        variance = max(float(rest @ rest) / max(len(rest) - len(missing.absorbed), 1), 1.0)
        # Coefficients in units of their prior standard deviation.
        scaled = left * std / np.sqrt(variance)
        values, axes = np.linalg.eigh(np.eye(len(std)) + scaled.T @ scaled)
        root = axes / np.sqrt(values)
        mean = -root @ (root.T @ (scaled.T @ rest)) / np.sqrt(variance)
        return cls(missing, std[:, None] * np.column_stack([root, mean]))

    @property
    def kinds(self) -> tuple[str, ...]:
        """Return what the kinds of these effects are called, each once."""
        return tuple(dict.fromkeys(effect.kind for effect in self.missing.effects))

    def deviations(self, poses: Poses) -> Array:
        """Return by how much predicted positions deviate at N poses ``(3 N, K + 1)`` [m], for each deviation of ``root``."""
        return self.missing.prediction_errors(poses) @ self.root


def hidden_effects(state: FittedState) -> HiddenEffects | None:
    """Return the hidden effects of a fit; None if there are none. They are computed once."""
    return state.once(("hidden effects",), lambda: HiddenEffects.of(state))
