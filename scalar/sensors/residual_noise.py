"""The noise of a sensor that takes few readings at a pose: it is estimated from what a model leaves.

Where a noise is stated, it is kept as long as the residual is not clearly smaller. A larger residual proves nothing, since the model may lack an
effect. A smaller one proves that the noise is stated too large, and such a statement would hide effects and keep the arm at its data sheet.

Several targets on one flange move as a rigid body, whatever the arm does. What remains of their residuals without any rigid motion is noise alone,
and shows its size whether it is stated or not.
"""

from __future__ import annotations

import numpy as np

from scalar.geometry.se3 import Array
from scalar.sensors.pose_noise import POSITION_NOISE, NoiseComponent
from scalar.units import MM

_ENOUGH = 20  # degrees of freedom from which the size of a residual says something: 16 % standard error
_CLEARLY_SMALLER = 0.8  # an estimate above this share of the stated noise differs from it no more than data sheets of one instrument do
_CLEARLY_DIFFERENT = 1.25  # ratio of a noise that is measured within poses to the stated one, or its inverse
# The residual has to be smaller by as many standard errors, too; by chance one dataset in 30,000 is.
_STANDARD_ERRORS = 4.0
_LEAST_SIZE = 1e-6  # singular values of a rigid motion, over the largest: the turn of two points about their line is none
_OF_A_MEDIAN = 1.6  # its standard error over that of a root mean square
UNCHANGED = 1e-3  # a smaller relative change of an estimated noise is not applied


def noise_factor(rms: float, rows: int, unknowns: int, *, stated: bool) -> float:
    """Return the factor by which an assumed noise is multiplied to agree with a residual; 1 where it is kept.

    Args:
        rms: Root mean square of the residual, in standard deviations of the assumed noise, scaled up for the parameters of the fit.
        rows: Number of measured rows.
        unknowns: Approximate number of parameters that the fit estimates.
        stated: Whether the assumed noise is stated.
    """
    freedom = rows - unknowns
    if freedom < _ENOUGH:
        return 1.0
    smaller = rms < min(_CLEARLY_SMALLER, 1.0 - _STANDARD_ERRORS / np.sqrt(2.0 * freedom))
    if (stated and not smaller) or abs(rms - 1.0) < UNCHANGED:
        return 1.0
    return rms


def factor_within_poses(residual: Array, moved: Array, measured: Array, *, stated: bool) -> float | None:
    """Return the same factor from what no rigid motion of whole poses explains, whether that is more or less; None if too few rows remain.

    The median over the poses is taken, so that gross errors of some poses do not matter.

    Args:
        residual: ``(N, m)``, in standard deviations of the assumed noise.
        moved: ``(N, m, 6)``, derivatives of the rows by a rigid motion.
        measured: ``(N, m)`` bool; rows that were not measured are zero.
        stated: Whether the assumed noise is stated; it is then kept unless the factor clearly differs from 1.
    """
    from scipy.stats import chi2  # here: checking a dataset needs no SciPy

    U, sizes, _ = np.linalg.svd(moved, full_matrices=False)
    counted = sizes > _LEAST_SIZE * sizes[:, :1]
    along = np.einsum("nmk,nm->nk", U, residual) * counted
    left = residual - np.einsum("nmk,nk->nm", U, along)
    freedom = measured.sum(axis=1) - counted.sum(axis=1)
    poses = freedom > 0
    if freedom[poses].sum() < _ENOUGH:
        return None
    # Each pose is divided by the median for its own degrees of freedom: a pose that shows fewer targets has a smaller one for each degree.
    degrees, which = np.unique(freedom[poses], return_inverse=True)
    typical = chi2.ppf(0.5, degrees)[which]
    factor = float(np.sqrt(np.median(np.sum(left[poses] ** 2, axis=1) / typical)))
    by_chance = np.log1p(_STANDARD_ERRORS * _OF_A_MEDIAN / np.sqrt(2.0 * freedom[poses].sum()))
    differs = abs(np.log(max(factor, 1e-300))) > max(np.log(_CLEARLY_DIFFERENT), by_chance)
    return factor if differs or not stated else 1.0


def rows_within_poses(seen: Array) -> float:
    """Return of how many rows a root mean square would be as exact as the median of ``factor_within_poses`` is.

    Args:
        seen: ``(N, K)`` bool, which targets each pose shows, not on one line if they are three or more. A rigid motion takes 3 of the rows of
            one target, 5 of those of two, and 6 of those of more.
    """
    targets = seen.sum(axis=1)
    freedom = 3 * targets - np.where(targets == 2, 5, np.where(targets > 2, 6, 3 * targets))
    return float(freedom.sum()) / _OF_A_MEDIAN**2


def scaled_up(rms: float, rows: int, unknowns: int) -> float:
    """Return the root mean square of a residual, scaled up because a fit adapts its parameters to the noise (Förstner's estimator)."""
    return rms * float(np.sqrt(rows / max(rows - unknowns, rows / 2)))


def estimated_position_noise(value: float, rows: float, stated: float | None) -> NoiseComponent:
    """Return an estimated noise of positions as files list it.

    Args:
        value: Its standard deviation [m], of a coordinate or a contact.
        rows: Number of rows whose root mean square would be as exact.
        stated: What was stated [m], or None.
    """
    sentence = (
        f"the noise of a measured position is estimated from what the model leaves, {value / MM:.3g} mm"
    )
    if stated is not None:
        sentence += f"; the stated {stated / MM:.3g} mm are too large"
    return NoiseComponent(POSITION_NOISE, {}, value, value / float(np.sqrt(2.0 * rows)), "m", sentence)
