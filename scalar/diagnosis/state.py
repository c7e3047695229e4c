"""A fitted model in the course of a hunt, and the columns of everything that might be added to it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from scalar.calibrate import unseen_effects
from scalar.diagnosis.noise import Spread, spreads, whitening
from scalar.diagnosis.score import Background
from scalar.effects.effect import Effect
from scalar.least_squares import fit
from scalar.model import Model
from scalar.residuals import Residuals, extra_basis_of
from scalar.se3 import Array
from scalar.sensors import Measurement, measure
from scalar.sensors.line_laser import LineLaser

if TYPE_CHECKING:
    from scalar.dataset import Dataset

_TOLERANCE = 1e-9


@dataclass(frozen=True, eq=False)
class State:
    """A model fitted to a dataset on its profile rows.

    Attributes:
        dataset: Cleaned.
        model: At the optimum, with the effects found so far.
        geometry_free: ``(G,)`` bool over robot, sensor and target: what is free whatever the effects.
        free: ``(P,)`` bool.
        residuals: Whitened at the optimum.
    """

    dataset: Dataset
    model: Model
    geometry_free: Array
    free: Array
    residuals: Residuals

    @property
    def effects(self) -> tuple[Effect, ...]:
        """Return the effects found so far."""
        return self.model.effects

    def linearised(self) -> tuple[Array, Array]:
        """Return rows whitened for the noise within scans ``(N m + priors,)`` and the Jacobian by what is free."""
        residual, jacobian = self.residuals.linearise(self.model)
        return residual, jacobian[:, self.free]

    @cached_property
    def spreads(self) -> list[Spread]:
        """Return the noises common to a pose that the residual's covariance would be explained by, the likeliest first."""
        return spreads(self)

    @cached_property
    def mix(self) -> Array | None:
        """Return ``(N, m, m)``, the whitening of what whole poses spread by beyond the noise of their points, or None.

        Whatever a model lacks looks like such a spread at first. To test with it costs little power where something is there, and keeps a few
        poses that spread more than others from posing as an effect where nothing is.
        """
        return whitening(self.spreads[0]) if self.spreads else None

    def background(self) -> Background:
        """Return the residual and what the model explains already, whitened for the spread of whole poses as well."""
        residual, jacobian = self.linearised()
        return self.background_of(residual, jacobian)

    def background_of(self, residual: Array, jacobian: Array) -> Background:
        """Return the background of rows and columns ``(N m + priors, ...)`` after the same whitening."""
        N, m = self.dataset.n_poses, self.residuals.measurement.rows_per_pose
        return Background.of(mixed(self.mix, residual), mixed(self.mix, jacobian), N, m)

    def columns_of(self, effects: Sequence[Effect]) -> Array:
        """Return the columns ``(N m, e)`` of effects at this model, whitened as the background, whether or not it has them."""
        model = replace(self.model, effects=(*self.model.effects, *effects))
        names = extra_basis_of(model.effects)
        residuals = Residuals.of(
            self.dataset, model, profile_measurement(self.dataset, self.model, self.residuals, names)
        )
        jacobian = residuals.linearise_measured(model)[1]
        return mixed(self.mix, jacobian[:, len(self.model.vector) :])


def mixed(mix: Array | None, rows: Array) -> Array:
    """Return rows ``(N m + priors,)`` or ``(N m + priors, k)`` with every pose's own mixed by ``(N, m, m)``; priors as they are."""
    if mix is None:
        return rows
    N, m, _ = mix.shape
    flat = rows.reshape(len(rows), -1)
    result = np.concatenate([(mix @ flat[: N * m].reshape(N, m, -1)).reshape(N * m, -1), flat[N * m :]])
    return result.reshape(rows.shape)


def profile_measurement(
    dataset: Dataset, model: Model, residuals: Residuals, extra_basis: Sequence[str]
) -> Measurement:
    """Return a dataset's rows for tests: scans as profiles, whitened where the sensor stands in a model."""
    measurement = measure(dataset, extra_basis)
    if isinstance(measurement, LineLaser):
        old = residuals.measurement
        measurement = replace(measurement, sigma=old.sigma)
        return measurement.profiles(residuals.kinematics(model).T_base_sensor, model.target)
    return measurement


def settle(dataset: Dataset, model: Model, geometry_free: Array, effects: Sequence[Effect]) -> State:
    """Return the joint optimum of a model with the given effects, starting from where model and effects stand.

    Args:
        dataset: Cleaned.
        model: Robot, sensor and target to start from.
        geometry_free: ``(G,)`` bool over robot, sensor and target.
        effects: With starting coefficients.
    """
    model = replace(model, effects=tuple(effects)).rebased()
    free = np.r_[geometry_free, np.ones(sum(len(e.coefficients) for e in effects), dtype=bool)]
    names = extra_basis_of(model.effects)
    residuals = Residuals.of(dataset, model, measure(dataset, names))
    if isinstance(residuals.measurement, LineLaser):
        # The sigma of unstated noise comes from the scans; profiles leave the scatter that it is measured from out.
        weighed = residuals.reweighted(model)
        residuals = Residuals.of(dataset, model, profile_measurement(dataset, model, weighed, names))
    if effects:
        free &= ~unseen_effects(residuals, model, free)
    found = fit(residuals, model, free, tolerance=_TOLERANCE)
    model = found.model.rebased()
    residuals = residuals.reweighted(model)
    found = fit(residuals, model, free, tolerance=_TOLERANCE)
    return State(dataset, found.model, geometry_free, free, residuals)
