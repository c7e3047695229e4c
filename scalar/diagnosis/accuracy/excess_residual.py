"""By how much a calibration errs because its model lacks something: the residual beyond the noise, which the covariance of the parameters leaves out.

The excess is measured in two ways. At the measured poses it is too small, because the parameters absorb a part of what the model lacks. In regions of
the joint space that are left out of the fit it is too large, because it also contains the errors of the parameters, which the covariance counts
already. The mean of the two variances is used.

Noise that is larger than stated leaves such an excess as well. Errors over the workspace therefore count it at the upper end of their bands alone. If
a diagnosis names the excess as a random error of whole poses or scans, it is no error of the model, and is reported on its own.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from scalar.diagnosis.fit.fitted_state import FittedState
from scalar.diagnosis.held_out.hold_out import held_out_regions
from scalar.diagnosis.shipping.shipped_fit import BY_COMPONENT, ShippedFit
from scalar.estimation.misfit import lacks_something, misfit, squares_for_a_shift, unexplained_shift
from scalar.estimation.result import Calibration
from scalar.estimation.usual_noise import exceeds_usual_noise

_EQUATIONS = 1.5  # for each free parameter, that the other regions have to give: with fewer, their fit says nothing of the region left out


class Shipping(Protocol):
    """What a diagnosis says of the fit that it ships (``Diagnosis``)."""

    @property
    def shipped(self) -> ShippedFit:
        """Return which fit is shipped."""
        ...

    @property
    def shipped_state(self) -> FittedState:
        """Return that fit."""
        ...

    @property
    def calibration_after(self) -> Calibration:
        """Return the calibration that is shipped."""
        ...

    @property
    def reported_noise(self) -> Sequence[object]:
        """Return the variance components that are reported."""
        ...

    @property
    def noise_without_a_name(self) -> bool:
        """Return whether a variance component is reported without a name."""
        ...


def excess_distance(calibration: Calibration, state: FittedState) -> float:
    """Return the root mean square distance [m] by which a calibration errs beyond the noise; zero unless its residual clearly exceeds the noise.

    If the noise is not known and the residual is clearly no noise, it is the whole residual.

    Args:
        calibration: The calibration.
        state: Its model and data, at its optimum.
    """
    if exceeds_usual_noise(calibration):
        return _whole_residual(state)
    return excess_of(state) if lacks_something(calibration.summary) else 0.0


def _whole_residual(state: FittedState) -> float:
    """Return the root mean square shift of the measured point [m] that makes the residuals of the poses; nothing of it is known to be noise."""
    residual, _ = state.linearised()
    N, m = state.dataset.n_poses, state.residuals.measurement.rows_per_pose
    squares = squares_for_a_shift(state.residuals, state.model)
    return float(np.sqrt(np.sum(residual[: N * m] ** 2) / max(float(squares.sum()), 1e-300)))


def excess_of(state: FittedState) -> float:
    """Return the root mean square distance [m] by which poses are off beyond the noise, at measured poses and in regions that the fit leaves out.

    The variance is the mean of that at the measured poses and of that in the regions. The latter is the median over the regions, and at least the
    former. If there are too few poses for regions, or if the other regions hardly determine the parameters, it is that at the measured poses alone.

    Args:
        state: Model and data at the optimum.
    """
    residuals, model = state.residuals, state.model
    at_measured = unexplained_shift(residuals, model, misfit(residuals, model, state.free))
    regions = held_out_regions(state)
    measurement = residuals.measurement
    if regions is None:
        return at_measured
    left = measurement.equations.sum() - np.bincount(regions.block, weights=measurement.equations)
    if left.min() < _EQUATIONS * state.free.sum():
        return at_measured
    T = residuals.kinematics(model).T_base_sensor
    within, _ = measurement.scatter(T, model.target, residuals.point_effects(model))
    excess, of_a_metre = (
        np.bincount(regions.block, weights=each)
        for each in (regions.whitened - within - measurement.equations, squares_for_a_shift(residuals, model))
    )
    typical = float(np.median(excess / np.maximum(of_a_metre, 1e-300)))
    return float(np.sqrt((at_measured**2 + max(typical, at_measured**2)) / 2.0))


def excess_distance_after(diagnosis: Shipping) -> float:
    """Return the same distance [m] for ``after.json``; zero if the diagnosis names the excess as a random error.

    If poses are weighted by a variance component, the weighted residual no longer shows the excess. If the component is not confirmed as a random
    error, or has no name, the excess is taken from the residual with equal weights, even if its p-value alone would not show it.
    """
    shipped = diagnosis.shipped
    named = bool(diagnosis.reported_noise) and not diagnosis.noise_without_a_name
    if named and not shipped.without_effects:
        return 0.0
    if shipped.fit == BY_COMPONENT:
        return excess_of(shipped.choice.state)
    return excess_distance(diagnosis.calibration_after, diagnosis.shipped_state)
