"""From a dataset to a calibration: start, decide what can be seen, fit everything at once, say how sure.

The one objective is the squared whitened residual of ``scalar.residuals``; robot, sensor, target and effects are fitted together. What the
data cannot show is held, derived for the robot and the poses at hand (``scalar.identifiability``), never listed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.stats import chi2

from scalar import initial
from scalar.calibration import Calibration, reporting, sensor_mapping
from scalar.checks import check_data, check_guess, check_lines, check_parameters, check_span
from scalar.effects.effect import Effect
from scalar.errors import Fault, InvalidInput, NotConverged, Undetermined
from scalar.identifiability import Identifiability, analyse, anchors, near_parallel_joints
from scalar.least_squares import RANK_TOLERANCE, Fit, covariance_and_step, fit
from scalar.model import Model
from scalar.residuals import Residuals
from scalar.robot import GEOMETRY
from scalar.se3 import Array
from scalar.sensors import measure
from scalar.sensors.line_laser import LineLaser
from scalar.units import MM

if TYPE_CHECKING:
    from scalar.dataset import Dataset

MAX_REWEIGHTINGS = 6
SETTLED = 0.02  # standard deviations: reweighting that moves the optimum by less is over
MISFIT_P_VALUE = 1e-3  # a residual less likely than this under the noise says that the model lacks something


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


def calibrate(
    dataset: Dataset,
    *,
    effects: Sequence[Effect] = (),
    held_effects: Sequence[Effect] = (),
    hold: Sequence[str] = (),
) -> Calibration:
    """Return the calibration of a dataset: robot, sensor, target and effects at once.

    Args:
        dataset: What was measured.
        effects: To estimate, from where their coefficients stand.
        held_effects: To apply as they are.
        hold: Further parameters to hold at their nominal values, by name.

    Raises:
        InvalidInput: The data contradict themselves.
        Undetermined: The data cannot determine the model, or the fit did not converge.
    """
    prepared = prepare(dataset, hold)
    try:
        found, residuals = fit_all(dataset, prepared, effects, held_effects)
    except NotConverged:
        _refuse_gross_errors(dataset)
        raise
    squares, counts = residuals.squared_distances(found.model)
    distances = np.sqrt(squares / counts)
    if distances.max() > GROSS_ERROR:
        _refuse_gross_errors(dataset)
    if distances.max() > GROSS_ERROR:
        worst = int(dataset.pose_ids[np.argmax(distances)])
        raise Undetermined(
            [f"the best fit is still {residuals.rms(found.model) / MM:.0f} mm RMS off, pose {worst} most of all: this is not "
             "the robot, the sensor or the planes that dataset.yaml describes; check conventions, units and plane labels; "
             "'scalar diagnose' can say more"]
        )  # fmt: skip
    return conclude(dataset, prepared, found, residuals)


GROSS_ERROR = (
    10 * MM
)  # of a pose after the fit: no effect on an arm makes it, a wrong label or a wrong pose does


def _refuse_gross_errors(dataset: Dataset) -> None:
    """Refuse a dataset with poses that contradict the rest, naming them.

    Raises:
        InvalidInput: Poses lie on another plane than said, or on none.
        Undetermined: So many contradict each other that none can be trusted.
    """
    # The diagnosis builds on this module; what it sets aside, a plain calibration refuses.
    from scalar.diagnosis.cleaning import clean

    cleaned = clean(dataset)
    rows = {int(pose): row for row, pose in enumerate(dataset.pose_ids)}
    faults = [
        Fault(
            "poses.csv",
            f"pose {pose} is said to lie on '{dataset.poses['plane'].iloc[rows[pose]]}' and lies on '{plane}': correct its plane",
            None,
            "plane",
        )
        for pose, plane in cleaned.mislabelled_poses
    ]
    faults += [
        Fault(
            "poses.csv",
            f"pose {pose} contradicts all others: remove it, or let 'scalar diagnose' set it aside",
            None,
            "pose",
        )
        for pose in cleaned.outlier_poses
    ]
    if faults:
        raise InvalidInput(faults)


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


def _why_held(name: str, is_effect: bool) -> str:
    if name.startswith("beta_"):
        return "nominal; the effect axis_nonparallel frees it"
    return "held, or it leaves no residual beside the other parameters" if is_effect else "held as asked"


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


def conclude(dataset: Dataset, prepared: Prepared, found: Fit, residuals: Residuals) -> Calibration:
    """Return the calibration of a converged fit: reporting coordinates, standard errors, what was held and why.

    The covariance is that of the noise, widened where the residual is larger than the noise explains.
    """
    guess = residuals.measurement.initial_target(dataset)
    model = reporting(found.model, guess)
    residual, jacobian = residuals.linearise(model)
    _check_rank(model, jacobian[:, found.free], found.free)
    covariance, _ = covariance_and_step(jacobian[:, found.free], residual)
    spread = misfit(residuals, model, int(found.free.sum()))
    names = model.names
    held = {h.name: h.reason for h in prepared.identifiability.held}
    for name, is_free in zip(names, found.free, strict=True):
        if not is_free and name not in held:
            held[name] = _why_held(name, "." in name and name not in prepared.start.model.names)
    summary: dict[str, Any] = {
        "poses": dataset.n_poses,
        "points": len(dataset.points) if len(dataset.points) else dataset.n_poses,
        "sigma_m": residuals.measurement.sigma,
        "sigma_stated": residuals.measurement.sigma_stated,
        "misfit": spread.ratio,
        "misfit_p_value": spread.p_value,
        "started_from": prepared.start.origin,
        "start_rms_m": prepared.start.rms,
        "evaluations": found.evaluations,
        "chi_squared": found.chi_squared,
        "kept_near_data_sheet": {a.name: a.reason for a in model.anchors if a.reason},
        "singular_values": [float(s) for s in prepared.identifiability.singular_values],
    }
    _check_plausible(model)
    return Calibration(
        model=model,
        sensor=sensor_mapping(dataset),
        free=tuple(name for name, is_free in zip(names, found.free, strict=True) if is_free),
        covariance=covariance * spread.inflation,
        held=held,
        gauge=tuple(
            {"held": h.name, "reason": h.reason, "moves_with": list(h.moves_with), "cause": h.cause}
            for h in prepared.identifiability.held
        ),
        residual_rms=residuals.rms(model),
        summary=summary,
    )


@dataclass(frozen=True)
class Misfit:
    """How the residual compares with the noise.

    Attributes:
        ratio: Root of the residual's mean square over what the noise explains; about 1 for a complete model.
        p_value: Chance of a residual this large from noise alone; None where the noise is not known independently.
        inflation: Factor on the covariance.
    """

    ratio: float
    p_value: float | None
    inflation: float


def misfit(residuals: Residuals, model: Model, n_free: int) -> Misfit:
    """Return how far the residual exceeds the noise, the scatter within scans set apart.

    A scan's scatter about its own line holds no news of the model, and there is much of it: left in, it would drown what the model
    lacks. What remains are two numbers a scan (one a contact, three a tracked point).
    """
    measurement = residuals.measurement
    squared = float(np.sum(residuals.residual(model) ** 2))
    N = len(residuals.poses)
    freedom = measurement.rows_per_pose * N - n_free
    if isinstance(measurement, LineLaser):
        T = residuals.kinematics(model).T_base_sensor
        within, _ = measurement.scatter(T, model.target, residuals.point_effects(model))
        squared -= float(within.sum())
        lines = np.minimum(np.diff(measurement.starts), measurement.equations_per_pose)
        freedom = int(lines.sum()) - n_free
    if residuals.known is not None:
        known = residuals.known
        freedom += 2 * int(np.isfinite(known.normal_std).sum()) + int(np.isfinite(known.distance_std).sum())
    if freedom <= 0:
        return Misfit(1.0, None, 1.0)
    ratio = squared / freedom
    if isinstance(measurement, LineLaser) or measurement.sigma_stated:
        p_value = float(chi2.sf(squared, freedom))
        return Misfit(float(np.sqrt(ratio)), p_value, ratio if p_value < MISFIT_P_VALUE else 1.0)
    return Misfit(float(np.sqrt(ratio)), None, ratio)


def _check_rank(model: Model, J: Array, free: Array) -> None:
    """Refuse error bars for what the data do not determine.

    Raises:
        Undetermined: With the parameters that move together unseen.
    """
    scale = np.linalg.norm(J, axis=0)
    _, s, Vt = np.linalg.svd(np.linalg.qr(J / np.where(scale > 0, scale, 1.0), mode="r"))
    if s[-1] > RANK_TOLERANCE * s[0]:
        return
    names = np.array(model.names)[free]
    largest = names[np.argsort(-np.abs(Vt[-1]))[:4]]
    raise Undetermined(
        [
            f"the data do not tell {', '.join(largest)} apart: measure more poses that differ in all joints, or hold one (--hold)"
        ]
    )


_LARGEST_LENGTH_CHANGE = 0.5  # m
_LARGEST_ANGLE_CHANGE = 1.5  # rad


def _check_plausible(model: Model) -> None:
    """Refuse a robot that no workshop could have built from its data sheet.

    Raises:
        Undetermined: A length or an angle ran away from its nominal value.
    """
    change = np.abs(model.robot.geometry - model.nominal.geometry)
    reasons = []
    for k, kind in enumerate(GEOMETRY):
        bound, unit, factor = (
            (_LARGEST_LENGTH_CHANGE, "mm", 1e3)
            if kind in ("a", "d")
            else (_LARGEST_ANGLE_CHANGE, "deg", 180 / np.pi)
        )
        for i in np.flatnonzero(change[k] > bound):
            reasons.append(
                f"{kind}_{i + 1} ran {change[k, i] * factor:.0f} {unit} away from its nominal value, past the bound of "
                f"{bound * factor:.0f} {unit}: the poses hardly see it, or the nominal robot is not this one"
            )
    if reasons:
        raise Undetermined(reasons)


__all__ = ["NotConverged", "calibrate", "conclude", "fit_all", "misfit", "prepare"]
