"""The models that are nested in a wide one, and the errors that are expected of their predictions (the focused information criterion)."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property

import numpy as np
from scipy.stats import chi2

from scalar.diagnosis.fit.fitted_state import FittedState
from scalar.diagnosis.held_out.repetitions import distinct_equations
from scalar.diagnosis.shipping.jackknife import Linearised, covariance_of
from scalar.estimation.displacement import position_std
from scalar.geometry.se3 import Array

Errors = tuple[float, float, float]
"""Expected errors of a predicted position [m]: within the joint limits, within the measured ranges, at the measured poses."""
LIMITS, RANGES, MEASURED = 0, 1, 2  # the indices of ``Errors``


class NestedModels:
    """A wide model, linearised at its optimum, and the models nested in it, which have some of its effects.

    Attributes:
        linear: The linearised fit, with F free coordinates.
        beyond_chance: Standard errors up to which a difference of predictions counts as chance.
        effect_index: ``(F,)``, index of the effect that each free coordinate belongs to; -1 for robot, sensor and target.
        optimum: Step to the optimum of the wide model and the steps without each pose, as ``Linearised.fitted`` returns them.
    """

    def __init__(self, state: FittedState):
        """Linearise a state that has all effects of the wide model."""
        # A place of the sensor that is held during the fit may be as wrong as any stated place.
        model = state.model.released()
        self.linear = Linearised(state if model is state.model else replace(state, model=model), None)
        self.beyond_chance = state.settings.shipped_fit.beyond_chance
        self._equations = distinct_equations(state)
        sizes = [len(effect.coefficients) for effect in state.effects]
        effect_index = np.r_[np.full(len(state.geometry_free), -1), np.repeat(np.arange(len(sizes)), sizes)]
        self.effect_index = effect_index[state.free]
        self.optimum = self.linear.fitted(np.ones(len(self.effect_index), dtype=bool))
        self._latest: tuple[bytes, tuple[Array, Array]] | None = None
        self._errors: dict[bytes, Errors] = {}

    def errors(self, kept: tuple[int, ...]) -> Errors:
        """Return the expected errors [m] of a predicted position, root mean square over poses, with the effects of the indices ``kept``.

        The first is over random poses within the joint limits, the second over random poses within the measured ranges, the third over measured
        poses.
        """
        free = self._free(kept)
        known = self._errors.get(free.tobytes())
        return self._errors.setdefault(free.tobytes(), self._errors_of(free)) if known is None else known

    def _errors_of(self, free: Array) -> Errors:
        """Return the errors of the nested model with the free coordinates ``(F,)``."""
        step, left_out = self._fitted(free)
        covariance = self._covariance(free, left_out)
        by_chance = covariance_of(left_out - self.optimum[1])
        within_limits, within_ranges, measured = (
            self._error(step, covariance, by_chance, columns, gram)
            for columns, gram in zip(self._all_columns, self._grams, strict=True)
        )
        return within_limits, within_ranges, measured

    def std(self, kept: tuple[int, ...]) -> float:
        """Return the standard error [m] of a predicted position, root mean square over poses within the joint limits; arguments as for ``errors``."""
        free = self._free(kept)
        return position_std(self.linear.columns, self._covariance(free, self._fitted(free)[1]))

    def p_value(self, index: int, kept: tuple[int, ...]) -> float:
        """Return the probability of coefficients as large as those of an effect in a nested model if all of them were zero (Wald's test).

        Their covariance is that of the jackknife over poses.

        Args:
            index: Index of the effect.
            kept: Indices of the effects that the nested model has, this one among them.
        """
        own = self.effect_index == index
        step, left_out = self._fitted(self._free(kept))
        estimate = (self.linear.coefficients + step)[own]
        covariance = covariance_of(left_out[:, own])
        wald = estimate @ np.linalg.pinv(covariance, hermitian=True) @ estimate
        return float(chi2.sf(wald, len(estimate)))

    def f_statistic(self, tested: tuple[int, ...], kept: tuple[int, ...]) -> float:
        """Return by how much effects reduce the sum of squares for each of their coefficients, in units of the variance that is left.

        Args:
            tested: Indices of the effects.
            kept: Indices of the effects that the nested model has, these among them.
        """
        n_tested = int(np.isin(self.effect_index, tested).sum())
        free = self._free(kept)
        left = self.linear.sum_of_squares(free)
        without = self.linear.sum_of_squares(self._free(tuple(i for i in kept if i not in tested)))
        variance = left / max(self._equations - int(free.sum()), 1)
        return (without - left) / (n_tested * variance)

    def _covariance(self, free: Array, left_out: Array) -> Array:
        """Return the covariance ``(F, F)`` of the coordinates of a nested model: by the jackknife, and by what the data sheet may err.

        Args:
            free: ``(F,)`` bool, the coordinates that the nested model has.
            left_out: ``(N, F)``, the steps from its fit when each of the N poses is left out, as ``Linearised.fitted`` returns them.
        """
        by_data_sheet = self.linear.steps_of_data_sheet(free)
        return covariance_of(left_out) + by_data_sheet.T @ by_data_sheet

    def _free(self, kept: tuple[int, ...]) -> Array:
        """Return which coordinates ``(F,)`` a nested model has."""
        return (self.effect_index < 0) | np.isin(self.effect_index, kept)

    def _fitted(self, free: Array) -> tuple[Array, Array]:
        """Return the steps of a nested model, as ``Linearised.fitted``; the latest are kept, since each of its effects is asked for in turn."""
        key = free.tobytes()
        if self._latest is None or self._latest[0] != key:
            self._latest = key, self.linear.fitted(free)
        return self._latest[1]

    @cached_property
    def _all_columns(self) -> tuple[Array, Array, Array]:
        """Return the derivatives ``(3 K, F)`` of the positions at the poses of each of ``Errors`` [m]."""
        return self.linear.columns, self.linear.columns_in_ranges, self.linear.columns_measured

    @cached_property
    def _grams(self) -> list[Array]:
        """Return the inner products ``(F, F)`` of these derivatives, mean over the K poses [m^2]; with a covariance they give a variance."""
        return [columns.T @ columns / (len(columns) / 3) for columns in self._all_columns]

    def _error(self, step: Array, covariance: Array, by_chance: Array, columns: Array, gram: Array) -> float:
        """Return the expected error [m] at K poses: the root of the variance plus the squared bias beyond chance.

        Args:
            step: ``(F,)``, to the optimum of the nested model.
            covariance: ``(F, F)``, of the coordinates of the nested model.
            by_chance: ``(F, F)``, of their difference from those of the wide model.
            columns: ``(3 K, F)``, derivatives of the positions at K poses [m].
            gram: ``(F, F)``, one of ``_grams``.
        """
        difference = columns @ (step - self.optimum[0])
        squared_distance = float(difference @ difference) / (len(difference) / 3)
        variance, variance_by_chance = (float(np.sum(gram * each)) for each in (covariance, by_chance))
        squared_bias = max(squared_distance - self.beyond_chance**2 * variance_by_chance, 0.0)
        return float(np.sqrt(max(variance, 0.0) + squared_bias))
