"""The initial estimate of sensor and target: from the stated pose of the sensor, and from the guesses that the measurement gives.

Each kind of sensor has its own way to guess its pose (``first_guesses`` of ``scalar.sensors.protocol``). Every proposal is fitted
together with the target, the arm being fixed at its nominal geometry, and the one with the least misfit is taken. A direction in which the sensor may
be shifted without a change of any residual (along the axes of a SCARA, all of which are parallel) keeps its stated place: the fit may end
anywhere along it, metres away.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from scalar.errors import Undetermined
from scalar.estimation.least_squares import Fit, fit
from scalar.estimation.model import SENSOR_PARAMETERS, Model
from scalar.estimation.residuals import Residuals
from scalar.estimation.settings import DEFAULTS
from scalar.geometry.parallel_axes import with_parallel_axes
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import Array
from scalar.sensors.target import held_as_guessed, is_stated

COARSE = 1e-6  # relative tolerance of fits from which other fits start
_UNSEEN_SHIFT = 1e-6  # of the motion of the sensor: a shift of which the target leaves a smaller part unexplained changes no residual


@dataclass(frozen=True, eq=False)
class InitialEstimate:
    """Sensor and target as first estimated, and how well they fit with the nominal arm.

    Attributes:
        model: Sensor and target fitted, robot nominal.
        rms: Root mean square distance [m].
        origin: Where the fit of sensor and target started: at the ``nominal pose`` of the sensor or at a ``linear guess``.
    """

    model: Model
    rms: float
    origin: str


def estimate_initially(
    residuals: Residuals, robot: Robot, target: Any, T_flange_sensor: Array | None, held: Collection[str] = ()
) -> InitialEstimate:
    """Return the initial estimate with the least misfit, from the stated nominal pose, if there is one, and from linear guesses.

    Args:
        residuals: Of the dataset, without effects.
        robot: Nominal.
        target: At its initial guess.
        T_flange_sensor: ``(4, 4)``, the sensor's nominal pose, or None.
        held: Names of parameters to hold. Those of the sensor keep their values of the nominal pose, if there is one; it is then the only start.
            Those of planes keep their values of the initial guess.

    Raises:
        Undetermined: No pose is stated, and the data determine no linear guess.
    """
    measurement = residuals.measurement
    best: tuple[str, Fit] | None = None
    starts = proposals(measurement, robot, residuals.poses.q, target, T_flange_sensor)
    stated = set(target.parameter_names) if is_stated(target) else set()
    if T_flange_sensor is not None:
        stated |= set(SENSOR_PARAMETERS)
        if not set(held).isdisjoint(SENSOR_PARAMETERS):
            starts = starts[:1]
    held = stated & set(held)
    for origin, T, start in starts:
        model = Model.at(robot, T, held_as_guessed(start, target, held))
        found = _refined(residuals, model, _may_move(model, held))
        if best is None or found.chi_squared < best[1].chi_squared:
            best = origin, found
    assert best is not None
    place = np.zeros(3) if T_flange_sensor is None else T_flange_sensor[:3, 3]
    model = best[1].model.rebased()
    model = _unseen_shifts_undone(residuals, model, place, _may_move(model, held))
    return InitialEstimate(model, residuals.rms(model), best[0])


def proposals(
    measurement: Any, robot: Robot, q: Array, target: Any, T_flange_sensor: Array | None
) -> list[tuple[str, Array, Any]]:
    """Return where a fit may start: for each start its origin, the sensor's pose on the flange ``(4, 4)`` and the target.

    Args:
        measurement: The dataset as rows.
        robot: Nominal.
        q: ``(N, n)`` [rad], joint angles.
        target: At its initial guess.
        T_flange_sensor: ``(4, 4)``, the sensor's nominal pose, or None.

    Raises:
        Undetermined: No pose is stated, and the data determine no linear guess.
    """
    T_base_flange = robot.flange(q)
    found: list[tuple[str, Array, Any]] = []
    if T_flange_sensor is not None:
        start = measurement.fitted_target(T_base_flange @ T_flange_sensor, target)
        found.append(("nominal pose", T_flange_sensor, start))
    try:
        guesses = measurement.first_guesses(
            T_base_flange, target, robot.gravity, thorough=T_flange_sensor is None
        )
    except Undetermined:
        if not found:
            raise
        return found
    for T, refits_target in guesses:
        start = measurement.fitted_target(T_base_flange @ T, target) if refits_target else target
        found.append(("linear guess", T, start))
    return found


def sensor_and_target(residuals: Residuals, model: Model) -> Array:
    """Return which coordinates ``(P,)`` bool are the target's or the sensor's; the sensor's orientation counts only if it is observed."""
    free = np.zeros(len(model.vector), dtype=bool)
    free[model.blocks["target"]] = True
    sensor = model.blocks["sensor"].start
    free[sensor : sensor + (6 if residuals.measurement.observes_orientation else 3)] = True
    return free


def _may_move(model: Model, held: Collection[str]) -> Array:
    """Return which coordinates ``(P,)`` bool are not among those to hold."""
    if not held:  # as in most calibrations, which are spared the names
        return np.ones(model.blocks["effects"].stop, dtype=bool)
    return np.array([name not in held for name in model.names])


def _refined(residuals: Residuals, model: Model, may_move: Array) -> Fit:
    return fit(residuals, model, sensor_and_target(residuals, model) & may_move, tolerance=COARSE)


def _unseen_shifts_undone(residuals: Residuals, model: Model, place: Array, may_move: Array) -> Model:
    """Return the model with its sensor as near to where it is stated as shifts allow that a motion of the target makes up for.

    A shift counts as made up for as well if the data determine it to a standard error, by the residual's size, that is larger than a stated place may
    be wrong. If the sensor points to the same side at all poses but for some thousandths of a degree, for example, errors of the arm move it by
    metres along that direction: a reflector had been placed 23 m above the flange, and the tracker 25 m below the floor.

    Args:
        residuals: Of the dataset, without effects.
        model: As fitted.
        place: ``(3,)`` [m], of the sensor on the flange, as stated.
        may_move: ``(P,)`` bool, coordinates that are not held.
    """
    parallel = replace(model, robot=with_parallel_axes(model.robot))
    residual, J = residuals.linearise(parallel)
    misfit = max(1.0, float(np.sqrt(np.mean(residual**2))))
    index = np.arange(len(may_move))
    shifts, target = (index[block][may_move[block]] for block in (_place(model), model.blocks["target"]))
    # The triangular factor has the same lengths and angles as the columns, and as few rows as there are columns.
    factor = np.asarray(np.linalg.qr(J[:, [*target, *shifts]], mode="r"))
    by_target, by_shift = factor[:, : len(target)], factor[:, len(target) :]
    determined = misfit / DEFAULTS.identifiability.plausible_sensor_place
    least = max(_UNSEEN_SHIFT * np.linalg.norm(by_shift), determined)
    # Its last block is what no motion of the target makes up for; most data determine all shifts clearly.
    if len(factor) == factor.shape[1] and np.all(
        np.linalg.svd(by_shift[len(target) :], compute_uv=False) > 2 * least
    ):
        return model
    made_up = np.linalg.lstsq(by_target, by_shift, rcond=None)[0]
    _, lengths, directions = np.linalg.svd(by_shift - by_target @ made_up, full_matrices=False)
    unseen = directions[lengths < least]
    if not len(unseen):
        return model
    vector = model.vector
    shift = unseen.T @ (unseen @ (place[may_move[_place(model)]] - vector[shifts]))
    vector[shifts] += shift
    vector[target] -= made_up @ shift
    return model.with_vector(vector)


def _place(model: Model) -> slice:
    """Return the coordinates of the sensor's place on the flange."""
    start = model.blocks["sensor"].start
    return slice(start, start + 3)
