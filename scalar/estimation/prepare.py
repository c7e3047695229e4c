"""Prepare a dataset for the fit: an initial estimate, which parameters the poses determine, and a coarse fit of everything."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from scalar.data.dataset import Dataset
from scalar.errors import Fault, InvalidInput, Undetermined
from scalar.estimation.data_sheet_priors import fit_near_data_sheet
from scalar.estimation.identifiability import Identifiability, analyse
from scalar.estimation.initial_estimate import InitialEstimate, estimate_initially
from scalar.estimation.model import Model
from scalar.estimation.ran_away import ran_away
from scalar.estimation.residuals import Residuals
from scalar.estimation.settings import DEFAULTS, EstimationSettings
from scalar.estimation.sufficiency import (
    FitFailed,
    check_data,
    check_equations,
    check_guess,
    check_lines,
    check_setup,
    check_span,
)
from scalar.estimation.unseen_directions import check_one_plane
from scalar.geometry.parallel_axes import near_parallel_joints
from scalar.geometry.robot import GEOMETRY, LENGTHS
from scalar.geometry.se3 import Array
from scalar.geometry.standard_dh import as_stated
from scalar.sensors import Target, measure
from scalar.units import MM

_ELSEWHERE = 20 * MM  # from the table: lengths of real arms are off by a few millimetres


@dataclass(frozen=True, eq=False)
class Prepared:
    """A dataset that is ready to be fitted.

    Attributes:
        residuals: Whitened at the initial estimate.
        guess: The initial guesses of the planes, or the tracker's frames.
        initial: The initial estimate, with the arm nominal.
        coarse: The coarse fit at which later fits start, with priors from the data sheet where the poses hardly determine the arm.
        identifiability: Which parameters to fix, and why.
        free: ``(P,)`` bool, which coordinates of the model are free.
    """

    residuals: Residuals
    guess: Target
    initial: InitialEstimate
    coarse: Model
    identifiability: Identifiability
    free: Array


def prepare(
    dataset: Dataset,
    fix: Sequence[str] = (),
    settings: EstimationSettings = DEFAULTS,
    *,
    effects_follow: bool = False,
) -> Prepared:
    """Return a dataset that is ready to be fitted: sensor and target estimated with the arm nominal, and a coarse fit of everything.

    Which parameters the poses determine depends on the true arm, and the nominal one may be degrees off. The analysis is made at
    the initial estimate, and again at the coarse fit if other axes are near-parallel there, or if a length ended far from the table: with a length
    that is wrongly 0 there, two axes are one, and zeros and offsets are confounded that the true arm distinguishes.

    Args:
        dataset: What was measured.
        fix: Further parameters to fix at their nominal values, by name.
        settings: Thresholds.
        effects_follow: Whether effects are added to the model after the coarse fit. Their errors, which its residual still contains, must then
            not increase the weight of the priors.

    Raises:
        InvalidInput: The initial guess of a plane is too far off for the fit.
        Undetermined: The data cannot determine the model.
    """
    measurement = measure(dataset)
    guess = measurement.initial_target(dataset)
    check_data(dataset, measurement, guess)
    if dataset.robot.tolerance is not None:
        check_setup(dataset, measurement, guess, settings.sufficiency)
    T = dataset.sensor.T_flange_sensor
    residuals = Residuals.of(
        dataset, Model.at(dataset.robot, np.eye(4) if T is None else T, guess), measurement
    )
    initial = estimate_initially(residuals, dataset.robot, guess, T, fix)
    check_lines(residuals, initial.model, settings.sufficiency)
    residuals = residuals.reweighted(initial.model)
    candidates = candidate_mask(initial.model, fix)
    try:
        identifiability, free = _identify(
            dataset, residuals, initial.model, initial.model, candidates, settings
        )
    except Undetermined:
        # If the planes are parallel, that is the reason to state.
        check_span(dataset, residuals, initial.model, settings.sufficiency)
        raise
    coarse = fit_near_data_sheet(residuals, initial.model, free, settings, effects_follow=effects_follow)
    if near_parallel_joints(coarse.robot) != near_parallel_joints(dataset.robot) or _far_length(coarse):
        identifiability, free, coarse = _identify_again(
            dataset,
            residuals,
            initial.model,
            candidates,
            (identifiability, free, coarse),
            settings,
            effects_follow,
        )
    try:
        check_guess(coarse, guess, settings.sufficiency)
        check_span(dataset, residuals, coarse, settings.sufficiency)
    except (InvalidInput, Undetermined) as error:
        # A fit that failed, or in which the arm collapsed until all planes are one, shows nothing of the planes.
        if residuals.rms(coarse) > settings.sufficiency.gross_error or ran_away(coarse, settings.fit):
            raise FitFailed(dataset.q) from error
        raise
    check_one_plane(dataset, coarse)
    return Prepared(residuals, guess, initial, coarse, identifiability, free)


def _identify(
    dataset: Dataset,
    residuals: Residuals,
    initial: Model,
    where: Model,
    candidates: Array,
    settings: EstimationSettings,
) -> tuple[Identifiability, Array]:
    """Return the identifiability at a model, and which coordinates are free because of it.

    Raises:
        Undetermined: Without a stated tolerance, the poses give fewer equations than there are free parameters; or no pose reaches its target.
    """
    identifiability = analyse(residuals, where, candidates, settings.identifiability, gauge_alone=True)
    fixed = set(identifiability.fixed_names)
    free = candidates & np.array([name not in fixed for name in initial.names])
    if dataset.robot.tolerance is None:
        check_equations(dataset, residuals.measurement, int(free.sum()))
    return identifiability, free


def _far_length(model: Model) -> bool:
    """Return whether a length of the arm is so far from the table that its axes are elsewhere."""
    change = np.abs(model.robot.geometry - model.nominal.geometry)
    return any(change[k].max() > _ELSEWHERE for k, kind in enumerate(GEOMETRY) if kind in LENGTHS)


def _identify_again(
    dataset: Dataset,
    residuals: Residuals,
    initial: Model,
    candidates: Array,
    first: tuple[Identifiability, Array, Model],
    settings: EstimationSettings,
    effects_follow: bool,
) -> tuple[Identifiability, Array, Model]:
    """Return the identifiability at the coarse fit, the coordinates that are free because of it, and a new coarse fit of these.

    Args:
        dataset: What was measured.
        residuals: Whitened at the initial estimate.
        initial: The initial estimate.
        candidates: ``(P,)`` bool, as ``candidate_mask`` returns it.
        first: The same three results, from the initial estimate. They are returned if the second analysis fails or the second fit is worse:
            the first coarse fit then did not end near the true arm.
        settings: Thresholds.
        effects_follow: As in ``prepare``.
    """
    found = first[2]
    try:
        identifiability, free = _identify(dataset, residuals, initial, found, candidates, settings)
    except Undetermined:
        return first
    again = fit_near_data_sheet(residuals, initial, free, settings, effects_follow=effects_follow)
    if residuals.rms(again) > max(settings.sufficiency.gross_error, residuals.rms(found)):
        return first
    return identifiability, free, again


def candidate_mask(model: Model, fix: Sequence[str] = ()) -> Array:
    """Return which coordinates ``(P,)`` bool would be free if the data determined them: all but beta and those to be fixed.

    Raises:
        InvalidInput: A name in ``fix`` is no parameter.
    """
    unknown = sorted(set(fix) - set(model.names))
    if unknown:
        known = as_stated(", ".join(model.names), model.nominal)
        raise InvalidInput(Fault("--hold", f"no parameter '{name}'; there are {known}") for name in unknown)
    beta = f"{GEOMETRY[4]}_"
    return np.array([not name.startswith(beta) and name not in fix for name in model.names])
