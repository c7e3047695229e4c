"""Identify the variance components of the arm or of the scans: those that explain the scatter better than the sensor's own noise.

Whole poses scatter by more than the noise of their points if the joints do not repeat, or if each scan has an error of its own. The sensor alone can
cause the same scatter in two ways: the noise of all rows is larger than it appears, or an error extends over a whole scan (a surface with waves
longer than a scan, slow speckle). Each component of the arm or of the scans is therefore fitted together with these two components of the sensor by
restricted likelihood, and is identified only if it explains scatter that the two do not. A jitter smaller than the repeatability of any data sheet is
no finding; it is fitted together with every other component.

A jitter of all joints, or a bias of the scans, is not named if a random error at one place explains the scatter clearly better. Something unknown
then acts on one joint, on the sensor's mount or on the base (``only_place``).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from scalar.diagnosis.fit.component_likelihood import chance_of
from scalar.diagnosis.fit.fitted_state import FittedState
from scalar.diagnosis.fit.variance_components import JITTER, VarianceComponent, columns_by_place
from scalar.diagnosis.noise.autocorrelation import depends_on
from scalar.diagnosis.noise.restricted_likelihood import fit_components
from scalar.geometry.se3 import Array


def identified_components(state: FittedState) -> tuple[VarianceComponent, ...]:
    """Return the variance components of a state that the sensor's own noise does not explain, the likeliest first.

    The gain of log likelihood [nats] and the p-value of each are those given the sensor's own noise; its standard deviation is left as it was.

    A sensor that takes no scans does not show by itself how its points err as a whole. Whatever scatters alike in all directions is then taken for
    noise of the sensor, unless residuals are autocorrelated: the likeliest component is then returned, to be reported without a name.

    Args:
        state: The state with all effects that were found.
    """
    residuals = state.residuals
    found = tuple(state.variance_components)
    if not found:
        return found
    background = state.background_within_scans()
    # Covariances (N, m, m) of the whitened rows by each source of unit variance.
    sensor_kernels = _kernels_of_sensor(state)
    kernels = {component.name: component.kernel for component in found}
    settings = state.settings
    too_small = {
        c.name for c in found if c.name == JITTER and c.std < settings.variance_components.least_repeatability
    }
    given = [*sensor_kernels, *(kernels[name] for name in too_small)]
    log_likelihood_given = fit_components(background, given).log_likelihood
    identified: list[VarianceComponent] = []
    scans = residuals.measurement.scans
    for component in found:
        if component.name in too_small or (component.name == "scan_bias" and not scans):
            continue
        together = fit_components(background, [kernels[component.name], *given])
        if not scans and together.variances[0] < settings.variance_components.least_repeatability**2:
            continue
        gain = together.log_likelihood - log_likelihood_given
        p_value = chance_of(gain)
        if p_value < settings.selection.alpha_unnamed:
            identified.append(replace(component, log_likelihood_gain=gain, p_value=p_value))
    if not identified and not scans and depends_on(state):
        return found[:1]
    return tuple(sorted(identified, key=lambda c: -c.log_likelihood_gain))


def only_place(state: FittedState, component: VarianceComponent) -> str | None:
    """Return the place at which a random error explains the scatter clearly better than an identified component, or None.

    Args:
        state: The state with all effects that were found.
        component: The identified component.

    Returns:
        The name of a joint (``q4``), ``sensor`` or ``base``; None if no place is better by ``settings.selection.confounded_margin`` [nats].
    """
    residuals, model = state.residuals, state.model
    sensor_kernels = _kernels_of_sensor(state)
    background = state.background_within_scans()

    def log_likelihood(kernel: Array) -> float:
        """Return the restricted log likelihood [nats] with a random error that adds ``kernel`` ``(N, m, m)`` to the covariance of the rows."""
        return fit_components(background, [kernel, *sensor_kernels]).log_likelihood

    of_component = log_likelihood(component.kernel)
    found = {
        place: log_likelihood(column[:, :, None] * column[:, None, :])
        for place, column in columns_by_place(residuals, model)
    }
    likeliest = max(found, key=lambda place: found[place])
    clearly = found[likeliest] > of_component + state.settings.selection.confounded_margin
    return likeliest.split(".")[0] if clearly else None


def _kernels_of_sensor(state: FittedState) -> list[Array]:
    """Return covariances ``(N, m, m)`` of the sensor's noise: of independent errors, and of those that extend over a whole pose."""
    residuals, model = state.residuals, state.model
    T_base_sensor = residuals.kinematics(model).T_base_sensor
    m = residuals.measurement.rows_per_pose
    independent = np.broadcast_to(np.eye(m), (len(T_base_sensor), m, m))
    extended = residuals.measurement.covariance_of_extended_errors(T_base_sensor, model.target)
    if extended is None and not residuals.measurement.scans:
        shift = residuals.measurement.common_error(T_base_sensor, model.target)
        extended = shift @ np.swapaxes(shift, 1, 2) if m > shift.shape[2] else None
    return [independent] if extended is None else [independent, extended]
