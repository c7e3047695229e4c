"""A model fitted to a dataset, as the diagnosis uses it: its residual, its Jacobian, its noise, and the columns of candidates at its optimum."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from scalar.diagnosis.fit.background import Background
from scalar.diagnosis.fit.column_products import ColumnProducts
from scalar.diagnosis.fit.effect_columns import Bases, EffectColumns
from scalar.diagnosis.fit.held_arrays import held_bytes
from scalar.diagnosis.fit.lately_fitted import key_of
from scalar.diagnosis.fit.measured_rows import MeasuredRows, profile_measurement
from scalar.diagnosis.fit.plausibility import is_implausible
from scalar.diagnosis.fit.variance_components import VarianceComponent, variance_components, whitening_for
from scalar.diagnosis.settings import DEFAULTS, Settings
from scalar.effects import Effect
from scalar.estimation.data_sheet_priors import misfit_ratio
from scalar.estimation.gauss_newton import optimum_near
from scalar.estimation.joint_fit import unobservable_coefficients
from scalar.estimation.model import Model
from scalar.estimation.residuals import Residuals, extra_basis_of
from scalar.geometry.se3 import Array

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset
    from scalar.estimation.result import Calibration

_Result = TypeVar("_Result")
# Largest number of relinearisations for nonlinear parameters of effects, such as a time constant; usually three suffice.
_RELINEARISATIONS = 8


@dataclass(frozen=True, eq=False)
class FittedState:
    """A model fitted to a dataset on its profile rows.

    Attributes:
        dataset: The cleaned dataset, of N poses with m rows each.
        model: The model at the optimum, with P parameters and the effects found so far.
        geometry_free: ``(G,)`` bool, which parameters of robot, sensor and target are free; the same whatever effects the model has.
        free: ``(P,)`` bool, which of all parameters are free, those of the effects included.
        residuals: The residuals of the dataset, whitened at the optimum for the noise within scans.
        settings: Thresholds.
        rows: The dataset reduced to rows, for refits.
        held_out: Held-out errors that were computed already, ``{id of a whitening: (the whitening, errors)}`` (``hold_out.held_out_errors``).
        candidate_columns: Columns of candidate sets that are known already, ``{id of a candidate set: columns}`` (``CandidateColumns.of``).
        results: What ``once`` has computed.
    """

    dataset: Dataset
    model: Model
    geometry_free: Array
    free: Array
    residuals: Residuals
    settings: Settings
    rows: MeasuredRows
    held_out: dict[int, tuple[Array | None, Any]] = field(default_factory=dict, init=False, repr=False)
    candidate_columns: dict[int, Any] = field(default_factory=dict, init=False, repr=False)
    results: dict[tuple[Any, ...], Any] = field(default_factory=dict, init=False, repr=False)

    def once(self, key: tuple[Any, ...], compute: Callable[[], _Result]) -> _Result:
        """Return a result of this state; it is computed when first asked for, since stages of a diagnosis ask again for that of the stage before.

        Args:
            key: The name of the result and what it depends on besides the state; these objects live as long as the state.
            compute: Computes it.
        """
        if key not in self.results:
            self.results[key] = compute()
        return self.results[key]

    def held_bytes(self, counted: set[int]) -> int:
        """Return the size of the arrays that this state alone holds [bytes]; ``counted`` as for ``held_arrays.held_bytes``."""
        sets = (columns.candidates for columns in self.candidate_columns.values())
        counted.update(map(id, (self.dataset, self.residuals.poses, self.rows, self.settings, *sets)))
        return held_bytes(self, counted)

    def refitted(self, effects: Sequence[Effect], start: Model | None = None) -> FittedState:
        """Return the joint optimum with other effects, fitted from this state's model or from ``start``, or kept from that fit (``LatelyFitted``)."""
        model = self.model if start is None else start
        fit = partial(refit, self.dataset, model, self.geometry_free, effects, self.settings, self.rows)
        return self.rows.fitted.of(key_of(self.settings, self.geometry_free, effects, model), fit)

    def with_equal_weights(self) -> FittedState:
        """Return the same state with no variance component, so that tests at it weight all poses equally; states refitted from it have their own."""
        state = replace(self)
        state.__dict__["variance_components"] = []  # in the place of the cached property
        return state

    @property
    def effects(self) -> tuple[Effect, ...]:
        """Return the effects found so far."""
        return self.model.effects

    @cached_property
    def _linearised(self) -> tuple[Array, Array]:
        residual, jacobian = self.residuals.linearise(self.model)
        return residual, jacobian[:, self.free]

    def linearised(self) -> tuple[Array, Array]:
        """Return the residual ``(N m + priors,)`` and its derivatives ``(N m + priors, F)`` by the F free parameters.

        Both are whitened for the noise within scans. The rows of priors follow those of the poses.
        """
        return self._linearised

    def rows_of(self, poses: Array) -> tuple[Array, Array]:
        """Return the indices of the rows of the poses with the indices ``poses``, and the same followed by the indices of the rows of priors."""
        N, m = self.dataset.n_poses, self.residuals.measurement.rows_per_pose
        rows = (poses[:, None] * m + np.arange(m)).ravel()
        return rows, np.r_[rows, np.arange(N * m, len(self.linearised()[0]))]

    def background_within_scans(self) -> Background:
        """Return the residual and the directions that the model explains, whitened for the noise within scans alone."""
        return self._background_within_scans

    @cached_property
    def _background_within_scans(self) -> Background:
        return self._background_of(*self.linearised())

    def _background_of(self, residual: Array, jacobian: Array) -> Background:
        """Return the background of a residual and its Jacobian, arrays as ``linearised`` returns them."""
        N, m = self.dataset.n_poses, self.residuals.measurement.rows_per_pose
        return Background.of(residual, jacobian, N, m, self.settings.score_test)

    @cached_property
    def variance_components(self) -> list[VarianceComponent]:
        """Return the variance components of whole poses that would explain the residual's covariance, the likeliest first."""
        return variance_components(
            self.background_within_scans(),
            self.residuals,
            self.model,
            self.settings.selection.alpha_unnamed,
        )

    @cached_property
    def whitening(self) -> Array | None:
        """Return the whitening ``(N, m, m)`` for the likeliest variance component of whole poses, or None if there is none.

        An effect that the model still lacks looks like such a component. With this whitening, tests do not mistake a few poses with large residuals
        for an effect.
        """
        return whitening_for(self.variance_components[0]) if self.variance_components else None

    @cached_property
    def _background(self) -> Background:
        return self.background_whitened_by(self.whitening)

    def background(self) -> Background:
        """Return the residual and the directions that the model explains, whitened for the state's own variance component as well."""
        return self._background

    @property
    def is_rounding(self) -> bool:
        """Return whether the residual is so small that it consists of rounding errors, whose structure means nothing."""
        return self.background().variance < self.settings.selection.rounding_variance

    @property
    def is_plausible(self) -> bool:
        """Return whether no effect is implausible."""
        return not self.implausible_effects

    @property
    def implausible_effects(self) -> list[int]:
        """Return the indices of effects that are impossible, or far beyond their size in real workcells (``is_implausible``)."""
        most = self.settings.selection.plausible_coefficient
        return [
            i
            for i, effect in enumerate(self.effects)
            if is_implausible(effect, self.dataset.robot, self.residuals.poses, most)
        ]

    def background_whitened_by(self, whitening: Array | None) -> Background:
        """Return the background under a given whitening ``(N, m, m)``; squared residuals of two states can be compared only under the same one."""
        if whitening is None:
            return self.background_within_scans()
        return self._background_of(*(whitened(whitening, rows) for rows in self.linearised()))

    def columns_of(self, effects: Sequence[Effect], bases: Bases | None = None) -> Array:
        """Return the columns ``(N m, e)`` of effects at this model, whitened like the background.

        Args:
            effects: Any effects, in the model or not.
            bases: Bases of effects at the poses that were computed before (``effect_columns``); those that are computed here are added.
        """
        return self._columns.of(effects, bases)

    def products_of(self, effects: Sequence[Effect], groups: Iterable[Array], bases: Bases) -> ColumnProducts:
        """Return the same columns for products within groups of them; the arguments are those of ``EffectColumns.products``."""
        return self._columns.products(effects, groups, bases)

    def columns_within_scans(self, effects: Sequence[Effect], bases: Bases | None = None) -> Array:
        """Return the columns ``(N m, e)`` that ``columns_of`` returns, whitened for the noise within scans alone."""
        return EffectColumns(self.residuals, self.model, self.rows, None).of(effects, bases)

    @cached_property
    def _columns(self) -> EffectColumns:
        return EffectColumns(self.residuals, self.model, self.rows, self.whitening)


def whitened(whitening: Array | None, rows: Array) -> Array:
    """Return rows ``(N m + priors,)`` or ``(N m + priors, k)``, those of each pose multiplied by its ``(m, m)`` matrix; priors are unchanged."""
    if whitening is None:
        return rows
    N, m, _ = whitening.shape
    flat = rows.reshape(len(rows), -1)
    result = np.concatenate([(whitening @ flat[: N * m].reshape(N, m, -1)).reshape(N * m, -1), flat[N * m :]])
    return result.reshape(rows.shape)


def plausibly_refitted(state: FittedState, effects: Sequence[Effect]) -> FittedState:
    """Return a state refitted with fewer effects, or the state itself if their coefficients would become implausible.

    What a dropped effect explained may drive another one far from any real size: a range that shrinks all scans to a point leaves no residual.

    Args:
        state: The state.
        effects: Those of its effects that are kept, perhaps with others.
    """
    trial = state.refitted(effects)
    return trial if trial.is_plausible else state


def refit(
    dataset: Dataset,
    model: Model,
    geometry_free: Array,
    effects: Sequence[Effect],
    settings: Settings = DEFAULTS,
    rows: MeasuredRows | None = None,
) -> FittedState:
    """Return the joint optimum of a model with the given effects; the fit starts from the given parameters and coefficients.

    Args:
        dataset: The cleaned dataset.
        model: Robot, sensor and target to start from.
        geometry_free: ``(G,)`` bool over robot, sensor and target.
        effects: The effects, with the coefficients to start from.
        settings: Thresholds.
        rows: The same dataset reduced to rows, or None to reduce it here.
    """
    rows = MeasuredRows(dataset) if rows is None else rows
    state = _fitted(dataset, replace(model, effects=tuple(effects)), geometry_free, settings, rows)
    weighted = state = _with_weight_of_priors(state)
    for _ in range(_RELINEARISATIONS):
        moved = [effect.relinearised() for effect in state.effects]
        if all(new is old for new, old in zip(moved, state.effects, strict=True)):
            break
        state = _fitted(dataset, replace(state.model, effects=tuple(moved)), geometry_free, settings, rows)
    return state if state is weighted else _with_weight_of_priors(state)


def state_of(calibration: Calibration, dataset: Dataset) -> FittedState:
    """Return the fit of a calibration to the dataset that it was estimated from."""
    model = calibration.model
    free = np.isin(model.names[: model.blocks["effects"].start], calibration.free)
    return refit(dataset, model, free, model.effects)


def _with_weight_of_priors(state: FittedState) -> FittedState:
    """Return a state whose priors weigh as the misfit at its optimum demands; the same one if they do already."""
    model, settings = state.model, state.settings.estimation
    if not model.priors:
        return state
    ratio = misfit_ratio(state.residuals, model, state.free, settings)
    if abs(ratio / model.misfit_ratio - 1.0) <= settings.identifiability.settled_weight:
        return state
    weighted = optimum_near(state.residuals, replace(model, misfit_ratio=ratio), state.free)
    return replace(state, model=weighted)


def _fitted(
    dataset: Dataset, model: Model, geometry_free: Array, settings: Settings, rows: MeasuredRows
) -> FittedState:
    """Return the joint optimum of a model with its effects, linear in their coefficients; the priors keep their weight."""
    model, effects = model.rebased(), model.effects
    free = np.r_[geometry_free, np.ones(sum(len(e.coefficients) for e in effects), dtype=bool)]
    measurement = rows.with_functions(extra_basis_of(model.effects))
    residuals = Residuals.of(dataset, model, measurement)
    if measurement.scans:
        # Noise that is not stated is estimated from the scatter within the scans, which profile rows no longer contain.
        weighted = residuals if measurement.sigma_stated else residuals.reweighted(model)
        profiled = profile_measurement(measurement, model, weighted)
        residuals = Residuals(profiled, residuals.poses, residuals.bases, residuals.known)
    if effects:
        free &= ~unobservable_coefficients(residuals, model, free, settings.estimation.fit.unseen_share)
    model = optimum_near(residuals, model, free).rebased()
    again = residuals.reweighted(model)
    if again.measurement is not residuals.measurement:
        residuals, model = again, optimum_near(again, model, free)
    return FittedState(dataset, model, geometry_free, free, residuals, settings, rows)
