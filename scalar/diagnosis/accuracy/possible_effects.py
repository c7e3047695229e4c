"""Effects that a fit may lack, each counted by its probability, and the errors that predictions have because of them.

Most arms have effects that are too small to be found, or whose shape no name fits. Their covariance does not cover them: the parameters absorb a part
of each, and the rest is hidden in the noise. Here the fit may lack none of the effects that many arms have (``Effect.in_many_arms``), or one of them,
with coefficients ``c ~ N(0, (s n)^2)``; n are their natural sizes and s is one of several shares. With r and E' the residual and the columns of an
effect given the fitted parameters (``missing_effects``), the evidence is the density of ``r ~ N(0, v I + s^2 E' diag(n^2) E'^T)`` with the variance
v at its most likely value, so that a noise that is stated wrongly counts for no effect. Predictions are averaged over these models with their
posterior probabilities (Hoeting, Madigan, Raftery and Volinsky, Statistical Science 14, 1999): a model is drawn, and from its posterior the
coefficients.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from scalar.data.poses import Poses
from scalar.diagnosis.accuracy.missing_effects import MissingEffects, without_absorbed
from scalar.diagnosis.fit.fitted_state import FittedState
from scalar.effects.registry import known
from scalar.geometry.se3 import Array

# Chosen: the prior probability that the model lacks none of the effects; the others share the rest alike.
NONE_LACKS = 0.3
# Chosen: prior standard deviations of the coefficients over their natural size, all as probable.
SHARES = np.geomspace(0.03, 1.0, 8)
# Trial values of the variance v, over that without any effect; an effect leaves less, and hardly ever less than a fiftieth.
_VARIANCES = np.exp(np.linspace(-4.0, 0.2, 43))
_LEAST_VALUE = 1e-12  # smaller eigenvalues of an effect's information, over the largest, count as zero


@dataclass(frozen=True, eq=False)
class PossibleEffects:
    """The effects that a fit may lack, with K coefficients in all, and what the data say of them.

    Attributes:
        missing: The effects, given the fit.
        information: ``(K, K)``, ``S E'^T E' S`` with the natural sizes S on a diagonal.
        gradient: ``(K,)``, ``S E'^T r``.
        squares: Sum of squares of the residual r.
        degrees_of_freedom: Of that sum.
    """

    missing: MissingEffects
    information: Array
    gradient: Array
    squares: float
    degrees_of_freedom: int

    @classmethod
    def of(cls, state: FittedState) -> PossibleEffects:
        """Return the effects that a fit may lack."""
        effects = [effect for kind in known().values() for effect in kind.in_many_arms(state.dataset)]
        missing, left, rest = without_absorbed(state, effects)
        scaled = left * missing.natural_sizes
        freedom = max(len(rest) - len(missing.absorbed), 1)
        return cls(missing, scaled.T @ scaled, scaled.T @ rest, float(rest @ rest), freedom)

    @cached_property
    def models(self) -> list[_Model]:
        """Return the models with their probabilities, that without any effect first."""
        without = _Model(np.zeros(0, dtype=int), 0.0, 1.0, np.log(NONE_LACKS))
        share = np.log((1.0 - NONE_LACKS) / max(len(self.missing.effects) * len(SHARES), 1))
        models = [without]
        for i in range(len(self.missing.effects)) if self.squares > 0 else ():
            own = np.flatnonzero(self.missing.owner == i)
            evidence, variance = self._evidence(own)
            models += [
                _Model(own, s, v, share + of_share)
                for s, of_share, v in zip(SHARES, evidence, variance, strict=True)
            ]
        log = np.array([model.probability for model in models])
        weights = np.exp(log - log.max())
        return [
            replace(model, probability=float(weight))
            for model, weight in zip(models, weights / weights.sum(), strict=True)
        ]

    def _evidence(self, own: Array) -> tuple[Array, Array]:
        """Return the log evidence of an effect over that of none ``(S,)``, and the variance v ``(S,)``, for each of the S shares.

        Args:
            own: Indices of its coefficients.
        """
        values, axes = _eigen(self.information[np.ix_(own, own)])
        squares = (axes.T @ self.gradient[own]) ** 2 / values
        rest = max(self.squares - float(squares.sum()), _LEAST_VALUE * self.squares)
        others = max(self.degrees_of_freedom - len(values), 1)
        v = _VARIANCES * self.squares / self.degrees_of_freedom
        total = v[:, None] + np.r_[0.0, SHARES**2][:, None, None] * values
        density = -0.5 * (np.sum(np.log(total) + squares / total, axis=2) + others * np.log(v) + rest / v)
        best = density.max(axis=1)
        return best[1:] - best[0], v[density.argmax(axis=1)[1:]]

    def draws(self, poses: Poses, count: int, seed: int) -> Array:
        """Return draws ``(3 N, count)`` [m] of by how much predicted positions are off at N poses because of what the model lacks.

        Args:
            poses: The N poses.
            count: How many draws.
            seed: Of the draws.
        """
        rng = np.random.default_rng(seed)
        owner = self.missing.owner
        coefficients = np.zeros((len(owner), count))
        weights = [model.probability for model in self.models]
        drawn = rng.choice(len(self.models), count, p=weights)
        for k in np.unique(drawn):
            which = np.flatnonzero(drawn == k)
            own = self.models[k].own
            coefficients[np.ix_(own, which)] = self._coefficients(self.models[k], rng, len(which))
        used = np.unique(owner[coefficients.any(axis=1)]).astype(int)
        return self.missing.only(used).prediction_errors(poses) @ coefficients[np.isin(owner, used)]

    def _coefficients(self, model: _Model, rng: np.random.Generator, count: int) -> Array:
        """Return draws ``(k, count)`` of an effect's coefficients from their posterior in a model."""
        values, axes = _eigen(self.information[np.ix_(model.own, model.own)])
        natural = self.missing.natural_sizes[model.own]
        total = model.variance + model.share**2 * values
        mean = -axes @ (model.share**2 * (axes.T @ self.gradient[model.own]) / total)
        # The root of the posterior covariance ``s^2 (1 - axes diag(s^2 values / total) axes')``: what no measurement shows keeps its prior.
        root = axes * (np.sqrt(model.variance / total) - 1.0) @ axes.T + np.eye(len(natural))
        chance = model.share * root @ rng.standard_normal((len(natural), count))
        return natural[:, None] * (mean[:, None] + chance)


@dataclass(frozen=True, eq=False)
class _Model:
    """A model with one further effect, or with none.

    Attributes:
        own: Indices of the effect's coefficients; none without an effect.
        share: Prior standard deviation of the coefficients over their natural size.
        variance: The variance v at its most likely value.
        probability: Its probability, or the logarithm of that up to a constant.
    """

    own: Array
    share: float
    variance: float
    probability: float


def possible_effects(state: FittedState) -> PossibleEffects:
    """Return the effects that a fit may lack; they are computed once."""
    return state.once(("possible effects",), lambda: PossibleEffects.of(state))


def _eigen(information: Array) -> tuple[Array, Array]:
    """Return the eigenvalues ``(k,)`` of a matrix that are not zero, and their eigenvectors as columns."""
    values, axes = np.linalg.eigh(information)
    kept = values > _LEAST_VALUE * max(float(values.max(initial=0.0)), 1e-300)
    return values[kept], axes[:, kept]
