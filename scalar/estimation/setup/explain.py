"""Why a set-up does not fit: the alternatives that explain the data far better than the description in dataset.yaml.

Nothing is corrected automatically. What is found is reported in one sentence with the residual before and after, for the user to correct.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from scalar.data.dataset import Dataset
from scalar.estimation.settings import DEFAULTS
from scalar.estimation.setup.alternatives import Alternative, alternatives, with_limits_counted_back
from scalar.estimation.setup.arm.angle_units import angle_units
from scalar.estimation.setup.arm.coupled_joints import coupled_drives, coupled_joints
from scalar.estimation.setup.arm.far_lengths import far_length_in_words, with_lengths_near_table
from scalar.estimation.setup.arm.moved_zeros import as_described, with_zeros_of, zeros_in_words
from scalar.estimation.setup.arm.other_arms import other_arms, stays_that_arm
from scalar.estimation.setup.arm.several_signs import MOST_SIGNS, many_signs, several_signs
from scalar.estimation.setup.arm.sign_and_zero import fitted_zeros, signs_and_zeros
from scalar.estimation.setup.arm.slide_units import slide_units
from scalar.estimation.setup.arm.two_zeros import two_zeros
from scalar.estimation.setup.sensor.earlier_link import earlier_links
from scalar.estimation.setup.sensor.exchanged_target import exchanged_targets
from scalar.estimation.setup.sensor.measured_scale import measured_scale
from scalar.estimation.setup.sensor.strange_target import strange_targets
from scalar.estimation.setup.sessions.moved_target import moved_targets
from scalar.estimation.setup.suspicion import Suspicion, in_mm
from scalar.estimation.setup.tables.column_units import column_units
from scalar.estimation.setup.tables.displaced_column import displaced_ends, displaced_slides
from scalar.estimation.setup.tables.exchanged_columns import exchanged_beside_orientations, exchanged_columns
from scalar.estimation.setup.tables.lost_row import lost_rows
from scalar.estimation.setup.tables.mistyped_numbers import length_signs, slipped_digits, twist_signs
from scalar.estimation.setup.tables.unrelated_rows import rows_apart, unrelated, unrelated_in_words
from scalar.estimation.setup.trial import NominalFit, Trial, full_fit, nominal_fit
from scalar.estimation.turned_orientations import not_turned
from scalar.units import DEG, MM

FALLS_TO = 0.2  # ratio of the residual after a fit to that of the set-up as described: an alternative with a larger one explains nothing
WORTH_FITTING = 0.6  # the same ratio before a fit; it is less strict, because both residuals contain the errors of the nominal arm
MOST_LEFT = 3 * MM
"""Largest residual after a fit if the set-up is described correctly: effects on arms cause tenths of a millimetre."""
# The same before a fit, with the nominal arm, whose own errors are several millimetres.
NOMINAL_LEFT = 30 * MM
AS_GOOD = 3.0  # two residuals count as equally good if neither exceeds the other by more than this factor
ALIKE = 1.2  # two nominal fits are alike if one residual exceeds the other by less than this factor
# A fit is near to dataset.yaml if nothing turns farther: an initial guess of a plane or of the sensor may be wrong by as much.
NEAR = 30 * DEG
# Of two corrections that fit equally well, the one that is nearer to dataset.yaml by so much is taken.
CLEARLY_NEARER = 20 * DEG
NEAR_SHIFT = 50 * MM  # the same for places, which are measured by hand
CLEARLY_NEARER_SHIFT = 30 * MM  # the same for places
# Places may be guessed badly: to be taken, a correction has to be nearer by this factor as well.
TIMES_NEARER = 2.0
SINGLE = (
    alternatives,
    twist_signs,
    length_signs,
    slipped_digits,
    angle_units,
    coupled_joints,
    exchanged_columns,
    exchanged_beside_orientations,
    column_units,
    displaced_slides,
    slide_units,
    rows_apart,
)
"""What yields the alternatives with one change."""
RARER = (coupled_drives, displaced_ends, earlier_links)
"""The same of changes that are rarer; they are tried where none of the others explains the data."""
LAST = (measured_scale, lost_rows, moved_targets, exchanged_targets, strange_targets)
"""What yields those that hold from a pose on, for one target, or with a factor to be found; they are tried where no other explains the data."""
MOST_FITTED = 4  # alternatives that are fitted in full


def explain(dataset: Dataset) -> tuple[Suspicion, ...]:
    """Return which errors in the description of the set-up would explain a dataset that does not fit it; none if nothing explains it.

    If the data do not distinguish several alternatives, all are returned. If measurements have nothing to do with the angles, and not because tracker
    or base moved, that is returned. Poses whose orientation alone is far from the arm's are left out.
    """
    alike = not_turned(dataset, np.ones(dataset.n_poses, dtype=bool), DEFAULTS.gross_errors)
    dataset = dataset if alike.all() else dataset.subset(alike)
    described = nominal_fit(dataset)
    before = _residual(full_fit(dataset), described)
    found = _first_explaining(dataset, described, before)
    if found is None:
        return (Suspicion("unrelated_rows", "poses.csv", unrelated_in_words(dataset), before),)
    likely = _likely(with_lengths_near_table(found) or found)
    return tuple(_suspicion(alternative, before, trial, one_of=len(likely)) for alternative, trial in likely)


def _first_explaining(
    dataset: Dataset, described: NominalFit, before: float | None
) -> list[tuple[NominalFit, Alternative, Trial]] | None:
    """Return the alternatives that explain the data among the simplest kinds of which any does; None if measurements and angles are unrelated.

    Places before and after a move of tracker or base are in different frames, and after a lost row they belong to other angles, so that measurements
    and angles seem unrelated: these are tried.
    Every alternative is compared with the arm nominal. The few with the smallest residuals, and with sensor and planes nearest to where
    dataset.yaml has them, are fitted in full. After the single alternatives, pairs of signs are tried, and three signs at once if nothing so far
    explains the data with sensor and planes near their stated places. A zero between the steps, and a sign and a zero of one joint, are tried before
    the pairs, where no single alternative explains the data; more signs, two zeros, the other arms of the library, and errors from a pose on, last.

    Args:
        dataset: The measurements as described.
        described: The nominal fit of the set-up as described.
        before: Residual of the set-up as described [m], or None if it could not be fitted.
    """
    found: list[tuple[NominalFit, Alternative, Trial]] = []
    for count in range(1, MOST_SIGNS + 1):
        single = itertools.chain(*(each(dataset) for each in SINGLE))
        tried = single if count == 1 else several_signs(dataset, count)
        found += _explaining(tried, described, before)
        if count == 1 and not found:
            found += _explaining(itertools.chain(*(each(dataset) for each in RARER)), described, before)
        if count == 1 and not found:
            if unrelated(dataset):
                from_a_pose_on = itertools.chain(lost_rows(dataset), moved_targets(dataset))
                return _explaining_fully(dataset, from_a_pose_on, before) or None
            zeros = itertools.chain(fitted_zeros(dataset), signs_and_zeros(dataset))
            found += _explaining(zeros, described, before)
        # A pair is reported together with a single alternative that explains the data as well; three signs are then not tried.
        if count > 1 and any(
            nominal.turn <= NEAR and nominal.shift <= NEAR_SHIFT
            for nominal, _, _ in with_lengths_near_table(found)
        ):
            break
    if not with_lengths_near_table(found):
        found += _explaining(itertools.chain(many_signs(dataset), two_zeros(dataset)), described, before)
    if not with_lengths_near_table(found):
        fitting = _explaining(other_arms(dataset), described, before)
        found += [entry for entry in fitting if stays_that_arm(entry[1], entry[2].model.robot)]
    for alternatives_of in LAST:
        found = found or _explaining_fully(dataset, alternatives_of(dataset), before)
    return found


def _likely(found: list[tuple[NominalFit, Alternative, Trial]]) -> list[tuple[Alternative, Trial]]:
    """Return the alternatives that fit about as well as the best one, with sensor and planes about as near to dataset.yaml as the nearest."""
    if not found:
        return []
    lowest = min(trial.rms for _, _, trial in found)
    turn = min(nominal.turn for nominal, _, _ in found)
    shift = min(nominal.shift for nominal, _, _ in found)
    return _without_repetitions(
        (alternative, trial)
        for nominal, alternative, trial in found
        if trial.rms <= AS_GOOD * lowest
        and nominal.turn <= turn + CLEARLY_NEARER
        and nominal.shift <= max(shift + CLEARLY_NEARER_SHIFT, TIMES_NEARER * shift)
    )


def _without_repetitions(likely: Iterable[tuple[Alternative, Trial]]) -> list[tuple[Alternative, Trial]]:
    """Return the alternatives, only the first of those that say the same: from two starts, a fit may come to one zero of a joint."""
    first: dict[tuple[str, ...], tuple[Alternative, Trial]] = {}
    for alternative, trial in likely:
        says = zeros_in_words(alternative, trial.model.robot) if alternative.zeros else alternative.says
        first.setdefault((alternative.where, says), (alternative, trial))
    return list(first.values())


def _explaining(
    tried: Iterable[Alternative], described: NominalFit, before: float | None
) -> list[tuple[NominalFit, Alternative, Trial]]:
    """Return the alternatives that explain the data, those nearest to dataset.yaml first.

    Args:
        tried: The alternatives.
        described: The nominal fit of the set-up as described.
        before: Residual of the set-up as described [m], or None if it could not be fitted.
    """
    nominals = [(nominal_fit(alternative.dataset), alternative) for alternative in tried]
    least = min((nominal.rms / a.motion for nominal, a in nominals), default=np.inf)
    limit = max(AS_GOOD * least, 2 * MM)
    worth = [
        (nominal, a)
        for nominal, a in nominals
        if nominal.rms / max(a.motion, 1.0) <= limit
        and nominal.rms <= NOMINAL_LEFT
        and _better(nominal, a, described)
    ]
    worth.sort(key=lambda entry: _order(*entry, least))
    found: list[tuple[NominalFit, Alternative, Trial]] = []
    for nominal, alternative in worth[:MOST_FITTED]:
        if found and nominal.turn > found[0][0].turn + CLEARLY_NEARER:
            break
        trial = full_fit(alternative.dataset)
        if trial is None or as_described(alternative, trial.model.robot):
            continue
        if _explains(nominal, alternative, trial, described, before):
            found.append((nominal, alternative, trial))
    return found


def _order(nominal: NominalFit, alternative: Alternative, least: float) -> tuple[int, int]:
    """Return the key by which alternatives are sorted: how far sensor and planes turn, then the residual in steps of ``ALIKE``.

    Where no orientation is observed, nothing turns; those that explain more are then among the few that are fitted. Alternatives that say the same
    in other words leave the same residual, and stay in the order of the list, the simplest first.
    """
    tiny = 1e-9  # [m]
    ratio = (nominal.rms / max(alternative.motion, 1.0) + tiny) / (least + tiny)
    return round(nominal.turn / DEG), round(float(np.log(ratio) / np.log(ALIKE)))


def _explaining_fully(
    dataset: Dataset, tried: Iterable[Alternative], before: float | None
) -> list[tuple[NominalFit, Alternative, Trial]]:
    """Return those of a few alternatives that leave a far smaller residual, whatever the nominal arm leaves of them.

    Errors of the nominal arm may hide a change by centimetres that holds from some pose on. An alternative has to be better also than the set-up as
    described with the arm that was fitted to the alternative, in case the set-up as described has no fit of its own.
    """
    found: list[tuple[NominalFit, Alternative, Trial]] = []
    for alternative in tried:
        trial = full_fit(alternative.dataset)
        if trial is None or trial.rms > (alternative.may_leave or MOST_LEFT):
            continue
        without = nominal_fit(replace(dataset, robot=trial.model.robot)).rms
        if trial.rms <= FALLS_TO * min(without, np.inf if before is None else before):
            found.append((nominal_fit(alternative.dataset), alternative, trial))
    return found


def _better(nominal: NominalFit, alternative: Alternative, described: NominalFit) -> bool:
    """Return whether an alternative leaves a far smaller residual, or one as small with sensor and planes nearer to their stated places."""
    left = nominal.rms / min(alternative.scale, 1.0) / max(alternative.motion, 1.0)
    return left <= WORTH_FITTING * described.rms or (
        left <= AS_GOOD * described.rms and _nearer(nominal, described)
    )


def _nearer(nominal: NominalFit, described: NominalFit) -> bool:
    """Return whether sensor and planes are near their stated places under an alternative, and clearly farther away without it."""
    return nominal.turn <= min(NEAR, described.turn - CLEARLY_NEARER)


def _explains(
    nominal: NominalFit, alternative: Alternative, trial: Trial, described: NominalFit, before: float | None
) -> bool:
    """Return whether the fit of an alternative leaves a far smaller residual than the set-up as described, or is far nearer to dataset.yaml."""
    if trial.rms > MOST_LEFT:
        return False
    return (
        _nearer(nominal, described)
        or before is None
        or trial.rms / min(alternative.scale, 1.0) / max(alternative.motion, 1.0) <= FALLS_TO * before
    )


def _residual(trial: Trial | None, nominal: NominalFit) -> float | None:
    """Return the smaller residual of a full and a nominal fit of one set-up [m]; None if neither was possible."""
    rms = nominal.rms if trial is None else min(trial.rms, nominal.rms)
    return float(rms) if np.isfinite(rms) else None


def _suspicion(alternative: Alternative, before: float | None, trial: Trial, *, one_of: int) -> Suspicion:
    """Return the suspicion for an alternative that explains the data.

    Args:
        alternative: The other reading.
        before: Residual of the set-up as described [m], or None if it could not be fitted.
        trial: The fit of the alternative.
        one_of: Number of alternatives that explain the data equally well.
    """
    says, changed, robot = alternative.says, alternative.changed, alternative.dataset.robot
    if alternative.zeros:
        says = zeros_in_words(alternative, trial.model.robot)
        robot = with_zeros_of(alternative, trial.model.robot)
    if alternative.what == "joint_sign":
        robot = with_limits_counted_back(robot, alternative.dataset.q)
    far = far_length_in_words(alternative.dataset.robot, trial.model.robot)
    figures = f"the residual is {trial.rms / MM:.2g} mm {changed} (median of the poses)"
    if before is not None and before > trial.rms / FALLS_TO:
        figures = f"{changed} the residual falls from {in_mm(before)} to {in_mm(trial.rms)} mm (medians of the poses)"
    among = "" if one_of == 1 else f"one of {one_of} possible mistakes, which these data do not distinguish: "
    return Suspicion(
        alternative.what,
        alternative.where,
        f"{among}{says}: {figures}; {alternative.remedy}{far}",
        before,
        trial.rms,
        robot if alternative.corrects_robot and not far else None,
        alternative.file,
    )
