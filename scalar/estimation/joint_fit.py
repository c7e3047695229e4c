"""Fit robot, sensor, target and effects at once, reweighted until the weights change nothing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from scalar.data.dataset import Dataset
from scalar.effects.effect import Effect
from scalar.errors import NotConverged
from scalar.estimation import start as initial
from scalar.estimation.least_squares import Fit, covariance_and_step, fit
from scalar.estimation.model import Model
from scalar.estimation.prepare import Prepared
from scalar.estimation.residuals import Residuals
from scalar.geometry.se3 import Array

MAX_REWEIGHTINGS = 6
SETTLED = 0.02  # standard deviations: reweighting that moves the optimum by less is over


def fit_all(
    dataset: Dataset, prepared: Prepared, effects: Sequence[Effect] = (), held_effects: Sequence[Effect] = ()
) -> tuple[Fit, Residuals]:
    """Return the joint fit of everything that can be seen, and the residuals whitened where it ended.

    Raises:
        NotConverged: A fit ended elsewhere than at an optimum.
    """
    model = replace(prepared.near, effects=(*held_effects, *effects))
    n_held = sum(len(effect.coefficients) for effect in held_effects)
    n_free = sum(len(effect.coefficients) for effect in effects)
    free = np.r_[prepared.free, np.zeros(n_held, dtype=bool), np.ones(n_free, dtype=bool)]
    residuals = prepared.residuals
    if model.effects:
        residuals = Residuals.of(dataset, model).reweighted(model)
        free &= ~unseen_effects(residuals, model, free)
    found = fit(residuals, model, free, tolerance=initial.COARSE)
    return fit_from(dataset, found.model, free, residuals)


def fit_from(
    dataset: Dataset, model: Model, free: Array, residuals: Residuals | None = None
) -> tuple[Fit, Residuals]:
    """Return the fit from a model near the optimum, reweighted until that changes nothing, and the residuals where it ended.

    Args:
        dataset: What was measured.
        model: Where to start.
        free: ``(P,)`` bool.
        residuals: Of the dataset for this model, or None to take them from the dataset.

    Raises:
        NotConverged: It ended elsewhere than at an optimum.
    """
    if residuals is None:
        residuals = Residuals.of(dataset, model)
    found: Fit | None = None
    for _ in range(MAX_REWEIGHTINGS):
        model = (model if found is None else found.model).rebased()
        residuals = residuals.reweighted(model)
        found = fit(residuals, model, free)
        again = residuals.reweighted(found.model)
        residual, jacobian = again.linearise(found.model)
        if covariance_and_step(jacobian[:, free], residual)[1] < SETTLED:
            break
    assert found is not None
    if not found.converged:
        raise NotConverged(
            [f"the fit did not converge: it stopped after {found.evaluations} evaluations short of an optimum; "
             "check plane labels and the nominal robot, or remove poses that are far off ('scalar diagnose' lists them)"]
        )  # fmt: skip
    return found, residuals


_UNSEEN_SHARE = 3e-3  # of a column's length: with less left beside everything else an effect is as good as silent, and may run away


def unseen_effects(residuals: Residuals, model: Model, free: Array) -> Array:
    """Return which free coefficients of effects ``(P,)`` are combinations of parameters and coefficients before them."""
    J = residuals.linearise(model)[1]
    where = model.blocks["effects"]
    columns = np.flatnonzero(free)
    # The triangular factor has the same lengths and angles as the columns, and as few rows as there are columns.
    R = np.asarray(np.linalg.qr(J[:, columns], mode="r"))
    n_before = int(free[: where.start].sum())
    basis = np.zeros((len(R), len(columns)))
    basis[:, :n_before] = np.linalg.qr(R[:, :n_before])[0]
    known = n_before
    unseen = np.zeros(len(free), dtype=bool)
    for i, column in zip(columns[n_before:], R.T[n_before:], strict=True):
        rest = column - basis[:, :known] @ (basis[:, :known].T @ column)
        rest -= basis[:, :known] @ (basis[:, :known].T @ rest)
        if np.linalg.norm(rest) <= _UNSEEN_SHARE * np.linalg.norm(column):
            unseen[i] = True
        else:
            basis[:, known] = rest / np.linalg.norm(rest)
            known += 1
    return unseen
