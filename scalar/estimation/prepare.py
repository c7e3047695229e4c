"""A dataset at its start: where the fit begins, what the poses can show, and a first fit of everything."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from scalar.data.dataset import Dataset
from scalar.errors import Fault, InvalidInput, Undetermined
from scalar.estimation import start as initial
from scalar.estimation.identifiability import Identifiability, analyse, anchors, near_parallel_joints
from scalar.estimation.least_squares import Fit, fit
from scalar.estimation.model import Model
from scalar.estimation.residuals import Residuals
from scalar.estimation.sufficiency import check_data, check_guess, check_lines, check_parameters, check_span
from scalar.geometry.robot import GEOMETRY
from scalar.geometry.se3 import Array
from scalar.sensors import measure
from scalar.units import MM

GROSS_ERROR = (
    10 * MM
)  # of a pose after the fit: no effect on an arm makes it, a wrong label or a wrong pose does


@dataclass(frozen=True, eq=False)
class Prepared:
    """A dataset at its start, with what can be seen of it.

    Attributes:
        residuals: Whitened at the start.
        start: Model, its misfit and where it comes from; the arm is nominal.
        near: The model near its optimum, from which fits go on; the start itself where the poses hardly determine the arm.
        identifiability: What to hold, and why.
        free: ``(P,)`` bool.
    """

    residuals: Residuals
    start: initial.Start
    near: Model
    identifiability: Identifiability
    free: Array


def prepare(dataset: Dataset, hold: Sequence[str] = ()) -> Prepared:
    """Return a dataset at its start: sensor and target found with the arm nominal, a first fit of all, and what to hold.

    What the poses can show is a matter of the arm as it is, and the nominal one may be degrees off: it is asked at the start, and again
    where the first fit ends if axes turn out to be near-parallel there that were not, or no longer are.

    Args:
        dataset: What was measured.
        hold: Further parameters to hold at their nominal values, by name.

    Raises:
        InvalidInput: A rough plane is wrong beyond repair.
        Undetermined: The data cannot determine the model.
    """
    measurement = measure(dataset)
    guess = measurement.initial_target(dataset)
    check_data(dataset, measurement, guess)
    T = dataset.sensor.T_flange_sensor
    residuals = Residuals.of(
        dataset, Model.at(dataset.robot, np.eye(4) if T is None else T, guess), measurement
    )
    start = initial.start(residuals, dataset.robot, guess, T)
    check_lines(residuals, start.model)
    residuals = residuals.reweighted(start.model)
    candidates = candidate_mask(start.model, hold)
    try:
        identifiability, free = _what_is_seen(
            dataset, residuals, start.model, _symmetric(start.model, T), candidates
        )
    except Undetermined:
        check_span(residuals, start.model)  # parallel planes hide much else
        raise
    found = fit(residuals, start.model, free, tolerance=initial.COARSE)
    if near_parallel_joints(found.model.robot) != near_parallel_joints(dataset.robot):
        identifiability, free, found = _asked_again(
            dataset, residuals, start.model, candidates, (identifiability, free, found)
        )
    check_guess(found.model, guess)
    check_span(residuals, found.model)
    model = replace(start.model, anchors=anchors(residuals, start.model, free, found.model))
    near = model if model.anchors else found.model.rebased()
    return Prepared(residuals, replace(start, model=model), near, identifiability, free)


def _what_is_seen(
    dataset: Dataset, residuals: Residuals, start: Model, where: Model, candidates: Array
) -> tuple[Identifiability, Array]:
    """Return what the poses show at a model, and which coordinates are free because of it.

    Raises:
        Undetermined: The poses are too few, or hide what no held joint explains.
    """
    identifiability = analyse(residuals, where, candidates)
    free = candidates & ~np.isin(start.names, identifiability.held_names)
    check_parameters(dataset, residuals, start, identifiability, int(free.sum()))
    return identifiability, free


def _asked_again(
    dataset: Dataset,
    residuals: Residuals,
    start: Model,
    candidates: Array,
    first: tuple[Identifiability, Array, Fit],
) -> tuple[Identifiability, Array, Fit]:
    """Return what the poses show where the first fit ended, and the fit from the start that goes with it.

    The first answer stays where the second leads nowhere: then the first fit was not near the arm.
    """
    found = first[2]
    try:
        identifiability, free = _what_is_seen(dataset, residuals, start, found.model, candidates)
    except Undetermined:
        return first
    again = fit(residuals, start, free, tolerance=initial.COARSE)
    if residuals.rms(again.model) > max(GROSS_ERROR, residuals.rms(found.model)):
        return first
    return identifiability, free, again


_ALREADY_NOMINAL = (
    0.02  # m: a sensor found this near its nominal place is taken to have the symmetry of the nominal one
)


def _symmetric(model: Model, T_nominal: Array | None) -> Model:
    """Return the model with the sensor at its nominal place where the start confirms it.

    A tool that is drawn on the axis of the flange hides parameters that a millimetre beside it would pretend to show.
    """
    if (
        T_nominal is None
        or np.linalg.norm(model.T_flange_sensor[:3, 3] - T_nominal[:3, 3]) > _ALREADY_NOMINAL
    ):
        return model
    return Model.at(model.robot, T_nominal, model.target)


def candidate_mask(model: Model, hold: Sequence[str] = ()) -> Array:
    """Return which coordinates would be free if they could be seen: all but beta and what is asked to be held."""
    unknown = sorted(set(hold) - set(model.names))
    if unknown:
        known = ", ".join(model.names)
        raise InvalidInput(Fault("--hold", f"no parameter '{name}'; there are {known}") for name in unknown)
    return np.array([not name.startswith(f"{GEOMETRY[4]}_") and name not in hold for name in model.names])
