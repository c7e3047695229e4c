"""Draw the pictures of the two random errors: residuals of simulated scans in standard deviations of the noise without and with the component."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from study.plots.style import styled

from docs.site.catalogue import NOISES, simulated
from scalar.diagnosis.fit.fitted_state import refit
from scalar.diagnosis.fit.variance_components import JITTER, directions, whitening_for
from scalar.estimation.geometry_fit import geometry_fit
from scalar.units import DEG

POSES_PER_PLANE = 100
JITTER_SHOWN = 0.01 * DEG  # rad, by which the horizontal axis is scaled
ORANGE, DOT = "#d55e00", "#5b6770"
BAND = 1.96  # standard deviations, to each side, within which 95 % of a Gaussian error lie


def noise_figure(name: str) -> Figure:
    """Return a figure with two panels: the residual of each scan, with the noise within scans alone and with the component.

    Their horizontal axis is what a jitter of every joint would make of each scan: an error of the joints scatters more to the right, and one of the
    scanner does not.

    Args:
        name: ``pose_jitter`` or ``scan_bias``.
    """
    dataset = simulated(NOISES[name], poses_per_plane=POSES_PER_PLANE)
    model, prepared = geometry_fit(dataset)
    state = refit(dataset, model, prepared.free, ())
    component = next(found for found in state.variance_components if found.name == name)
    measurement = state.residuals.measurement
    N, m, shift = dataset.n_poses, measurement.rows_per_pose, measurement.shift_rows
    rows = state.linearised()[0][: N * m].reshape(N, m)
    white = np.einsum("nij,nj->ni", whitening_for(component), rows)
    by_angle = dict(directions(state.residuals, state.model))[JITTER]
    lever = JITTER_SHOWN * np.linalg.norm(by_angle, axis=2)[:, shift].ravel()
    expected = BAND * np.sqrt(np.diagonal(component.covariance, axis1=1, axis2=2))[:, shift].ravel()
    with styled():
        figure = Figure(figsize=(8.4, 3.2), layout="constrained")
        axes = figure.subplots(1, 2, sharex=True, sharey=True)
        titles = ("noise within scans alone", "random error in the model")
        for ax, values, title in zip(axes, (rows, white), titles, strict=True):
            ax.axhspan(-BAND, BAND, color=ORANGE, alpha=0.25, linewidth=0)
            ax.plot(lever, values[:, shift].ravel(), ".", color=DOT, markersize=3, alpha=0.7)
            ax.set_title(title, fontsize=9)
            ax.set_xlabel("what 0.01° in every joint adds [standard deviations]")
        for bound in (-expected, expected):
            axes[0].plot(lever, bound, ".", color=ORANGE, markersize=2)
        axes[0].set_ylabel("residual [standard deviations]")
    return figure
