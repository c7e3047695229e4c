"""A fitted model during forward selection, and the columns of everything that might be added to it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from scalar.diagnosis.effect_columns import Basis, EffectColumns
from scalar.diagnosis.measured_rows import MeasuredRows, profile_measurement
from scalar.diagnosis.score_test import Background
from scalar.diagnosis.settings import DEFAULTS, Settings
from scalar.diagnosis.variance_components import VarianceComponent, variance_components, whitening_for
from scalar.effects import Effect
from scalar.estimation.data_sheet_priors import misfit_ratio
from scalar.estimation.joint_fit import unobservable_coefficients
from scalar.estimation.least_squares import fit
from scalar.estimation.model import Model
from scalar.estimation.residuals import Residuals, extra_basis_of
from scalar.geometry.se3 import Array

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset

# Refits: steps of Gauss-Newton by normal equations, then the careful fit where they do not end.
_STEPS = 10  # three are the rule
_PROMISED = 1e-8  # of the misfit's variance: a step that promises a smaller drop is the last
_SOUND = 1e-11  # of the largest eigenvalue: with a smaller one, normal equations have too few digits
_TOLERANCE = 1e-9  # relative, of cost and coordinates where the careful fit ends: rounding
_RELINEARISATIONS = 8  # more fits for what an effect is not linear in, a time constant; three are the rule


@dataclass(frozen=True, eq=False)
class FittedState:
    """A model fitted to a dataset on its profile rows.

    Attributes:
        dataset: Cleaned.
        model: At the optimum, with the effects found so far.
        geometry_free: ``(G,)`` bool over robot, sensor and target: what is free whatever the effects.
        free: ``(P,)`` bool.
        residuals: Whitened at the optimum.
        settings: Thresholds.
        rows: The dataset reduced to rows, for refits.
        held_out: Held-out errors that are known already, ``{id of a whitening: (the whitening, errors)}`` (``hold_out.held_out_errors``).
    """

    dataset: Dataset
    model: Model
    geometry_free: Array
    free: Array
    residuals: Residuals
    settings: Settings
    rows: MeasuredRows
    held_out: dict[int, tuple[Array | None, Any]] = field(default_factory=dict, init=False, repr=False)

    def refitted(self, effects: Sequence[Effect], start: Model | None = None) -> FittedState:
        """Return the joint optimum with other effects, from where this state, or another model, stands."""
        model = self.model if start is None else start
        return refit(self.dataset, model, self.geometry_free, effects, self.settings, self.rows)

    @property
    def effects(self) -> tuple[Effect, ...]:
        """Return the effects found so far."""
        return self.model.effects

    @cached_property
    def _rows(self) -> tuple[Array, Array]:
        residual, jacobian = self.residuals.linearise(self.model)
        return residual, jacobian[:, self.free]

    def linearised(self) -> tuple[Array, Array]:
        """Return rows whitened for the noise within scans ``(N m + priors,)`` and the Jacobian by what is free."""
        return self._rows

    def rows_of(self, poses: Array) -> tuple[Array, Array]:
        """Return the indices of the rows of some poses, and these with the rows on priors, which follow those of all poses."""
        N, m = self.dataset.n_poses, self.residuals.measurement.rows_per_pose
        rows = (poses[:, None] * m + np.arange(m)).ravel()
        return rows, np.r_[rows, np.arange(N * m, len(self.linearised()[0]))]

    def background_within_scans(self) -> Background:
        """Return the residual and what the model explains already, whitened for the noise within scans alone."""
        return self._background_within_scans

    @cached_property
    def _background_within_scans(self) -> Background:
        return Background.of(
            *self.linearised(),
            self.dataset.n_poses,
            self.residuals.measurement.rows_per_pose,
            self.settings.score_test,
        )

    @cached_property
    def variance_components(self) -> list[VarianceComponent]:
        """Return the noises common to a pose that the residual's covariance would be explained by, the likeliest first."""
        return variance_components(
            self.background_within_scans(),
            self.residuals,
            self.model,
            self.settings.selection.alpha_unnamed,
        )

    @cached_property
    def whitening(self) -> Array | None:
        """Return ``(N, m, m)``, the whitening of the likeliest variance component of whole poses, or None.

        Whatever a model lacks looks like such a component at first. With it, tests do not take a few poses of large residuals for an effect.
        """
        return whitening_for(self.variance_components[0]) if self.variance_components else None

    @cached_property
    def _background(self) -> Background:
        return self.background_whitened_by(self.whitening)

    def background(self) -> Background:
        """Return the residual and what the model explains already, whitened for the state's own variance component as well."""
        return self._background

    @property
    def is_rounding(self) -> bool:
        """Return whether what the model leaves is rounding: its structure is the computer's."""
        return self.background().variance < self.settings.selection.rounding

    @property
    def is_plausible(self) -> bool:
        """Return whether no coefficient is far beyond its prior: a gain of the range of -1 shrinks all scans to a point, and leaves no residual."""
        most = self.settings.selection.plausible_coefficient
        return all(np.all(np.abs(effect.coefficients) <= most * effect.prior_std) for effect in self.effects)

    def background_whitened_by(self, whitening: Array | None) -> Background:
        """Return the same under any whitening ``(N, m, m)``: squared residuals of two states compare only under one."""
        if whitening is None:
            return self.background_within_scans()
        residual, jacobian = (whitened(whitening, rows) for rows in self.linearised())
        return Background.of(
            residual,
            jacobian,
            self.dataset.n_poses,
            self.residuals.measurement.rows_per_pose,
            self.settings.score_test,
        )

    def columns_of(self, effects: Sequence[Effect], bases: dict[Effect, Basis] | None = None) -> Array:
        """Return the columns ``(N m, e)`` of effects at this model, whitened as the background, whether or not it has them.

        Args:
            effects: Any.
            bases: What effects do at the poses, where it is known already; filled where it is not.
        """
        return self._columns.of(effects, bases)

    def columns_within_scans(
        self, effects: Sequence[Effect], bases: dict[Effect, Basis] | None = None
    ) -> Array:
        """Return the same columns, whitened for the noise within scans alone."""
        return EffectColumns(self.residuals, self.model, self.rows, None).of(effects, bases)

    @cached_property
    def _columns(self) -> EffectColumns:
        return EffectColumns(self.residuals, self.model, self.rows, self.whitening)


def whitened(whitening: Array | None, rows: Array) -> Array:
    """Return rows ``(N m + priors,)`` or ``(N m + priors, k)`` with every pose's own whitened by ``(N, m, m)``; priors as they are."""
    if whitening is None:
        return rows
    N, m, _ = whitening.shape
    flat = rows.reshape(len(rows), -1)
    result = np.concatenate([(whitening @ flat[: N * m].reshape(N, m, -1)).reshape(N * m, -1), flat[N * m :]])
    return result.reshape(rows.shape)


def refit(
    dataset: Dataset,
    model: Model,
    geometry_free: Array,
    effects: Sequence[Effect],
    settings: Settings = DEFAULTS,
    rows: MeasuredRows | None = None,
) -> FittedState:
    """Return the joint optimum of a model with the given effects, starting from where model and effects stand.

    Args:
        dataset: Cleaned.
        model: Robot, sensor and target to start from.
        geometry_free: ``(G,)`` bool over robot, sensor and target.
        effects: With starting coefficients.
        settings: Thresholds.
        rows: The same dataset reduced to rows, or None to reduce it now.
    """
    rows = MeasuredRows(dataset) if rows is None else rows
    state = _fitted(dataset, replace(model, effects=tuple(effects)), geometry_free, settings, rows)
    for _ in range(_RELINEARISATIONS):
        moved = [effect.relinearised() for effect in state.effects]
        if all(new is old for new, old in zip(moved, state.effects, strict=True)):
            break
        state = _fitted(dataset, replace(state.model, effects=tuple(moved)), geometry_free, settings, rows)
    return state


def _fitted(
    dataset: Dataset, model: Model, geometry_free: Array, settings: Settings, rows: MeasuredRows
) -> FittedState:
    """Return the joint optimum of a model with its effects, linear in their coefficients."""
    model, effects = model.rebased(), model.effects
    free = np.r_[geometry_free, np.ones(sum(len(e.coefficients) for e in effects), dtype=bool)]
    measurement = rows.keeping(extra_basis_of(model.effects))
    residuals = Residuals.of(dataset, model, measurement)
    if measurement.scans:
        # Noise that is not stated is measured from the scatter within scans, which profiles leave out.
        weighted = residuals if measurement.sigma_stated else residuals.reweighted(model)
        profiled = profile_measurement(measurement, model, weighted)
        residuals = Residuals(profiled, residuals.poses, residuals.bases, residuals.known)
    if effects:
        free &= ~unobservable_coefficients(residuals, model, free, settings.estimation.fit.unseen_share)
    model = _optimum(residuals, model, free).rebased()
    again = residuals.reweighted(model)
    if again.measurement is not residuals.measurement:
        residuals, model = again, _optimum(again, model, free)
    if model.priors:
        ratio = misfit_ratio(residuals, model, free, settings.estimation)
        if abs(ratio / model.misfit_ratio - 1.0) > settings.estimation.identifiability.settled_weight:
            model = _optimum(residuals, replace(model, misfit_ratio=ratio), free)
    return FittedState(dataset, model, geometry_free, free, residuals, settings, rows)


def _optimum(residuals: Residuals, model: Model, free: Array) -> Model:
    """Return the optimum near a model: Gauss-Newton steps while each lowers the cost as it promises, else the careful way."""
    start = model
    cost = np.inf
    for _ in range(_STEPS):
        residual, jacobian = residuals.linearise(model)
        now = float(residual @ residual)
        if now > cost * (1.0 + 1e-9):
            break
        cost = now
        J = jacobian[:, free]
        scale = np.linalg.norm(J, axis=0)
        scale[scale == 0] = 1.0
        gram, projection = (J.T @ J) / np.outer(scale, scale), (J.T @ residual) / scale
        values, vectors = np.linalg.eigh(gram)
        if len(values) == 0 or values[0] < _SOUND * values[-1]:
            break
        along = vectors.T @ projection
        vector = model.vector.copy()
        vector[free] -= (vectors @ (along / values)) / scale
        model = model.with_vector(vector)
        promised = float(np.sum(along**2 / values))
        if promised < _PROMISED * max(1.0, cost / max(len(residual), 1)):
            return model
    return fit(residuals, start, free, tolerance=_TOLERANCE).model
