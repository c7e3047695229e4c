"""A measurement whose rows are whitened for a variance component of whole poses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from scalar.geometry.se3 import Array
from scalar.sensors import Measurement, NoiseComponent, Rows, Target


@dataclass(frozen=True, eq=False)
class WhitenedMeasurement(Measurement):
    """A measurement whose rows are whitened for noise common to a pose.

    Attributes:
        inner: The measurement whose rows are whitened.
        whitening: ``(N, m, m)``, inverse square roots of the covariances of its rows.
        component: The variance component for which they are whitened.
    """

    inner: Any
    whitening: Array
    component: NoiseComponent

    def __getattr__(self, name: str) -> Any:
        """Return an attribute of the inner measurement that this class does not define."""
        return getattr(self.inner, name)

    @property
    def target_index(self) -> Array:  # type: ignore[override]
        """Return the index of the item of the target (a plane, for example) that each pose measures, ``(N,)``."""
        return self.inner.target_index

    @property
    def sigma(self) -> float:  # type: ignore[override]
        """Return the standard deviation within scans."""
        return self.inner.sigma

    @property
    def noise_components(self) -> tuple[NoiseComponent, ...]:
        """Return the components of the inner measurement, and the one for which its rows are whitened here."""
        return (*self.inner.noise_components, self.component)

    @property
    def estimated_noise(self) -> tuple[NoiseComponent, ...]:
        """Return the estimated noise of the inner measurement."""
        return self.inner.estimated_noise

    @property
    def ratio_to_stated(self) -> float | None:
        """Return that of the inner measurement."""
        return self.inner.ratio_to_stated

    @property
    def rows_per_pose(self) -> int:  # type: ignore[override]
        """Return the number of rows of each pose."""
        return self.inner.rows_per_pose

    @classmethod
    def of(cls, dataset: Any) -> Measurement:
        """Refuse: a whitened measurement is made from another measurement."""
        raise NotImplementedError

    @classmethod
    def target_to_mapping(cls, target: Target, std: Any) -> dict[str, Any]:
        """Refuse: the kind of the inner measurement saves the target."""
        raise NotImplementedError

    @classmethod
    def target_from_mapping(cls, mapping: Any) -> Target:
        """Refuse: the kind of the inner measurement loads the target."""
        raise NotImplementedError

    @property
    def sigma_known(self) -> bool:
        """Return whether the noise within scans is stated; the variance component is estimated separately and not by the fit."""
        return self.inner.sigma_stated

    def initial_target(self, dataset: Any) -> Target:
        """Return the initial target of the inner measurement."""
        return self.inner.initial_target(dataset)

    def fitted_target(self, T_base_sensor: Array, target: Target) -> Target:
        """Return the fitted target of the inner measurement."""
        return self.inner.fitted_target(T_base_sensor, target)

    def rows(self, T_base_sensor: Array, target: Target, point_effects: Sequence[Any] = ()) -> Rows:
        """Return the inner rows, whitened."""
        rows = self.inner.rows(T_base_sensor, target, point_effects)
        residual = np.einsum("nij,nj->ni", self.whitening, rows.residual)
        return Rows(
            residual, self.whitening @ rows.wrench, self.whitening @ rows.target, self.whitening @ rows.extra
        )

    def by_range_scale(self, T_base_sensor: Array, target: Target) -> Array | None:
        """Return the inner derivatives, whitened."""
        inner = self.inner.by_range_scale(T_base_sensor, target)
        return None if inner is None else np.einsum("nij,nj->ni", self.whitening, inner)

    def reweighted(self, T_base_sensor: Array, target: Target) -> Measurement:
        """Return the inner measurement reweighted, whitened as before."""
        return replace(self, inner=self.inner.reweighted(T_base_sensor, target))

    def distances(
        self, T_base_sensor: Array, target: Target, point_effects: Sequence[Any] = ()
    ) -> tuple[Array, Array]:
        """Return the inner distances."""
        return self.inner.distances(T_base_sensor, target, point_effects)

    def perfect_rows(self, T_base_sensor: Array, target: Target, index: Array) -> tuple[Array, Array, Array]:
        """Return the perfect rows of the inner measurement, which are not whitened here."""
        return self.inner.perfect_rows(T_base_sensor, target, index)
