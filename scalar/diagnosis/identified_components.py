"""Identify the variance components of the arm or of the scans: those that explain the scatter better than the sensor's own noise.

Whole poses scatter by more than the noise of their points if the joints do not repeat, or if each scan has an error of its own. They do so too if
the noise of the points is larger than it appears, in all rows alike, or if its cause is common to a whole scan (a surface with waves longer than a
scan, slow speckle). All four are fitted together by restricted likelihood, and a component of the arm or of the scans is identified only if it
explains what the two of the sensor do not. Joints that repeat better than any data sheet states are taken as given and are no finding.

A component of all joints alike, or of the range, is not named where a random error at one place explains the scatter clearly better: something
unknown that acts on one joint, on the sensor's mount or on the base.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.stats import chi2

from scalar.diagnosis.fitted_state import FittedState
from scalar.diagnosis.restricted_likelihood import fit_components
from scalar.diagnosis.variance_components import VarianceComponent, columns_by_place, directions
from scalar.geometry.se3 import Array


def identified_components(state: FittedState) -> tuple[VarianceComponent, ...]:
    """Return the variance components of a state that the sensor's own noise does not explain, the likeliest first.

    For a sensor that has no such noise of its own, all components are returned unchanged.
    """
    residuals, model = state.residuals, state.model
    found = tuple(state.variance_components)
    uneven = residuals.measurement.uneven_rows(residuals.kinematics(model).T_base_sensor, model.target)
    if not found or uneven is None:
        return found
    background = state.background_within_scans()
    own = _of_the_sensor(uneven)
    kernels = {name: D @ np.swapaxes(D, 1, 2) for name, D in directions(residuals, model)}
    settings = state.settings
    usual = {
        c.name
        for c in found
        if c.name == "pose_jitter" and c.std < settings.variance_components.least_repeatability
    }
    own += [kernels[name] for name in usual]
    without = fit_components(background, own).log_likelihood
    identified: list[VarianceComponent] = []
    for component in found:
        if component.name in usual:
            continue
        gain = fit_components(background, [kernels[component.name], *own]).log_likelihood - without
        p_value = float(0.5 * chi2.sf(2 * max(gain, 0.0), 1))
        if p_value < settings.selection.alpha_unnamed:
            identified.append(replace(component, log_likelihood_gain=gain, p_value=p_value))
    return tuple(sorted(identified, key=lambda c: -c.log_likelihood_gain))


def only_place(state: FittedState, component: VarianceComponent) -> str | None:
    """Return the one place at which a random error explains the scatter clearly better than a component: a joint, ``sensor`` or ``base``; else None.

    Args:
        state: With all effects that were found.
        component: That was identified.
    """
    residuals, model = state.residuals, state.model
    T_base_sensor = residuals.kinematics(model).T_base_sensor
    uneven = residuals.measurement.uneven_rows(T_base_sensor, model.target)
    own = [] if uneven is None else _of_the_sensor(uneven)
    background = state.background_within_scans()

    def likelihood(columns: Array) -> float:
        return fit_components(background, [columns @ np.swapaxes(columns, 1, 2), *own]).log_likelihood

    named = likelihood(dict(directions(residuals, model))[component.name])
    found = {place: likelihood(column[:, :, None]) for place, column in columns_by_place(residuals, model)}
    likeliest = max(found, key=lambda place: found[place])
    clearly = found[likeliest] > named + state.settings.selection.confounded_margin
    return likeliest.split(".")[0] if clearly else None


def _of_the_sensor(uneven: Array) -> list[Array]:
    """Return the covariances ``(N, m, m)`` of the noise of a scan's points: alike in all rows, and in some rows more."""
    return [np.broadcast_to(np.eye(uneven.shape[1]), uneven.shape), uneven]
