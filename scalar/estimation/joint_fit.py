"""Fit robot, sensor, target and effects at once, and recompute the weights until they no longer change the optimum."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.linalg.lapack import dpotrf  # pyright: ignore[reportAttributeAccessIssue]

from scalar.data.dataset import Dataset
from scalar.effects.effect import Effect
from scalar.errors import NotConverged
from scalar.estimation.data_sheet_priors import fit_near_data_sheet, misfit_ratio
from scalar.estimation.initial_estimate import COARSE
from scalar.estimation.least_squares import Fit, covariance_and_step, fit
from scalar.estimation.model import Model
from scalar.estimation.prepare import Prepared
from scalar.estimation.residuals import Residuals
from scalar.estimation.settings import DEFAULTS, EstimationSettings
from scalar.estimation.sufficiency import check_effects
from scalar.geometry.se3 import Array

_DEPENDENT = 1e-5  # of a column's length: normal equations of columns of which less remains given the others have lost too many digits
_ROUNDS = 6  # of fitting and recomputing the weights; usually two suffice


def fit_all(
    dataset: Dataset,
    prepared: Prepared,
    effects: Sequence[Effect] = (),
    fixed_effects: Sequence[Effect] = (),
    settings: EstimationSettings = DEFAULTS,
) -> tuple[Fit, Residuals]:
    """Return the joint fit of everything that the data determine, and the residuals whitened at its optimum.

    Args:
        dataset: What was measured.
        prepared: The same dataset, prepared for the fit.
        effects: Effects to estimate; the fit starts from their coefficients.
        fixed_effects: Effects to apply with their coefficients as they are.
        settings: Thresholds.

    Raises:
        TooManyUnknowns: With the effects there are as many unknowns as equations.
        NotConverged: A fit stopped before it reached an optimum.
    """
    model = replace(prepared.coarse, effects=(*fixed_effects, *effects))
    n_fixed = sum(len(effect.coefficients) for effect in fixed_effects)
    n_free = sum(len(effect.coefficients) for effect in effects)
    free = np.r_[prepared.free, np.zeros(n_fixed, dtype=bool), np.ones(n_free, dtype=bool)]
    residuals = prepared.residuals
    if model.effects:
        residuals = Residuals.of(dataset, model).reweighted(model)
        free &= ~unobservable_coefficients(residuals, model, free, settings.fit.unseen_share)
        check_effects(dataset, residuals.measurement, int(free.sum()))
    model = fit(residuals, model, free, tolerance=COARSE).model
    if model.effects:  # the coarse fit had no effects, and their errors decided how much its priors weigh
        model = fit_near_data_sheet(residuals, model.rebased(), free, settings, near_optimum=True)
    return fit_from(dataset, model, free, residuals, settings)


def fit_from(
    dataset: Dataset,
    model: Model,
    free: Array,
    residuals: Residuals | None = None,
    settings: EstimationSettings = DEFAULTS,
) -> tuple[Fit, Residuals]:
    """Return the fit from a model near the optimum, and the residuals whitened at its optimum.

    The weights are recomputed after each fit until they move the optimum by less than ``settings.fit.settled_step``.

    Args:
        dataset: What was measured.
        model: Where to start.
        free: ``(P,)`` bool.
        residuals: Of the dataset for this model, or None to take them from the dataset.
        settings: Thresholds.

    Raises:
        NotConverged: It stopped before it reached an optimum.
    """
    if residuals is None:
        residuals = Residuals.of(dataset, model)
    found: Fit | None = None
    settled, again = False, residuals
    for _ in range(_ROUNDS):
        if found is None:
            model = model.rebased()
            residuals = residuals.reweighted(model)
        else:
            model, residuals = found.model.rebased(), again
        if model.priors:
            model = model.with_priors(model.priors, misfit_ratio(residuals, model, free, settings))
        found = fit(residuals, model, free)
        again = residuals.reweighted(found.model)
        settled = remaining_step(again, found.model, free) < settings.fit.settled_step
        if settled:
            break
    assert found is not None
    # The columns of effects may be accurate to some per cent only. The fit then cannot reach the last hundredth of a standard error.
    if not (settled or found.converged):
        raise NotConverged(
            [f"the fit did not converge: it stopped after {found.evaluations} evaluations short of an optimum; "
             f"check {'plane labels and ' if dataset.planes else ''}the nominal robot, or remove poses that are far off ('scalar diagnose' "
             "lists them)"]
        )  # fmt: skip
    return found, residuals


def remaining_step(residuals: Residuals, model: Model, free: Array) -> float:
    """Return the length of the remaining Gauss-Newton step in standard deviations, as ``covariance_and_step`` counts it."""
    step = None
    if not model.priors:
        step = residuals.normal_equations(model, free).step()
    if step is None:
        residual, jacobian = residuals.linearise(model)
        step = covariance_and_step(jacobian[:, free], residual)[1]
    return step


def unobservable_coefficients(
    residuals: Residuals, model: Model, free: Array, least_share: float = DEFAULTS.fit.unseen_share
) -> Array:
    """Return which free coefficients of effects ``(P,)`` act as combinations of the parameters and coefficients before them.

    The measurements alone decide. Priors of the geometry would make a gain of the range observable, which no measurement distinguishes from the size
    of the arm: it would then take up what the priors are wrong by.

    Args:
        residuals: Of the dataset.
        model: Where the columns are taken.
        free: ``(P,)`` bool.
        least_share: A coefficient is observable if what remains of its column, these combinations projected out, is longer than this share
            of the column.
    """
    J = residuals.linearise(model)[1]
    J = J[: len(J) - len(model.priors)]  # the rows of priors are the last
    where = model.blocks["effects"]
    columns = np.flatnonzero(free)
    n_before = int(free[: where.start].sum())
    if _clearly_observable(J[:, columns], n_before, least_share):
        return np.zeros(len(free), dtype=bool)
    # The triangular factor has the same lengths and angles as the columns, and as few rows as there are columns.
    R = np.asarray(np.linalg.qr(J[:, columns], mode="r"))
    basis = np.zeros((len(R), len(columns)))
    basis[:, :n_before] = np.linalg.qr(R[:, :n_before])[0]
    known = n_before
    unobservable = np.zeros(len(free), dtype=bool)
    for i, column in zip(columns[n_before:], R.T[n_before:], strict=True):
        rest = column - basis[:, :known] @ (basis[:, :known].T @ column)
        rest -= basis[:, :known] @ (basis[:, :known].T @ rest)
        if np.linalg.norm(rest) <= least_share * np.linalg.norm(column):
            unobservable[i] = True
        else:
            basis[:, known] = rest / np.linalg.norm(rest)
            known += 1
    return unobservable


def _clearly_observable(columns: Array, n_before: int, least_share: float) -> bool:
    """Return whether more than twice ``least_share`` of each column remains if what the columns before it span is projected out.

    Normal equations tell, in a fraction of the time of an orthogonal factorisation: the diagonal of their Cholesky factor holds what remains of each
    column, as a share of its length. Where some column almost depends on others, they are too inaccurate, and the answer is no.

    Args:
        columns: ``(R, F)``.
        n_before: Number of columns, the first ones, of which this is not asked.
        least_share: As a share of a column's length.
    """
    lengths = np.linalg.norm(columns, axis=0)
    if not np.all(lengths > 0):
        return False
    factor, failed = dpotrf((columns.T @ columns) / np.outer(lengths, lengths))
    if failed:
        return False
    left = factor.diagonal()
    return bool(np.all(left > _DEPENDENT) and np.all(left[n_before:] > 2.0 * least_share))
