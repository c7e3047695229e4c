"""Another sign or zero of a joint under which lengths, zeros and the sensor come out where dataset.yaml has them, where a fit ended far from it.

Where a joint of the wrist counts the other way and moves little, or where the target lies on the last axis, a fit with the wrong sign or zero
leaves hardly any residual: another zero, a length or the target's place takes the error up. The number that comes out far off is then not the
one that is wrong. With planes, whose places are only guessed, the same holds if all joints count the other way, or all twists of the table have the
wrong sign: then the mirror image of the arm stands before the mirror images of the planes, and a guess of a plane may be all that comes out far off.
If some of several readings also bring the planes to where they were guessed, only these are kept.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from scalar.data.dataset import Dataset
from scalar.estimation.model import Model
from scalar.estimation.setup.alternatives import CORRECT_TABLE, THETA, with_sign_changed, with_zero_moved
from scalar.estimation.setup.arm.far_lengths import most_of_a_link
from scalar.estimation.setup.arm.lengths import ROBOT
from scalar.estimation.setup.arm.several_signs import all_signs
from scalar.estimation.setup.other_angles import angles_replaced, swapped_columns
from scalar.estimation.setup.planes.plane_guesses import far_guesses
from scalar.estimation.setup.plausibility import SENSOR_SHIFT, ZERO
from scalar.estimation.setup.sensor.earlier_link import EARLIER_LINK, on_link_before
from scalar.estimation.setup.suspicion import Suspicion
from scalar.estimation.setup.tables.mistyped_numbers import with_all_twists_back
from scalar.estimation.setup.trial import full_fit
from scalar.geometry.angles import within_half_turn
from scalar.geometry.robot import GEOMETRY, LENGTHS, Robot
from scalar.sensors import measure
from scalar.units import DEG, MM

FAR_OFF = frozenset({ROBOT, "joint_zero"})
"""What a fit that ended far from the table of joints is suspected of. A sensor that alone sits elsewhere is rather a rough ``nominal_pose``."""
QUARTER_TURNS = (90 * DEG, -90 * DEG, 180 * DEG)
"""Zeros that conventions differ by; a fit that starts there finds the rest."""
AS_GOOD = 1.2
"""Most by which the residual of a plainer reading may exceed that of the description."""

MOST_FITTED_POSES = 200
"""Poses, evenly over the acquisition, that readings are compared with: the arm is fitted some thirty times."""
ALL, TWISTS = -1, -2
"""In place of a joint: all that move, and the twists of all links."""
WHOLE_ARM = {
    ALL: (
        "all joints",
        "all joints count the other way",
        "which way the joints turn when their angles grow",
    ),
    TWISTS: (
        "alpha",
        "all twists alpha of the table have the wrong sign",
        "which way the axes of the joints are turned to one another",
    ),
}
"""What each of them concerns, what is wrong, and what to check at the arm."""
PLANE_GUESS = "plane_guess"  # as a suspicion names a plane that was found far from its guess
MOST_READINGS = 3
"""With more readings that are as plain, the data tell nothing of signs and zeros."""


def plainer_reading(
    dataset: Dataset, model: Model, entries: Sequence[Mapping[str, Any]]
) -> tuple[Suspicion, ...]:
    """Return the suspicion that a joint has another sign or zero, in place of what a fit is suspected of; none if nothing is plainer.

    Args:
        dataset: What was measured.
        model: Where its fit ended.
        entries: What is suspected, as ``setup`` of a calibration's summary has it.
    """
    far = [entry for entry in entries if entry["what"] in FAR_OFF and entry["where"] != "robot.name"]
    mirrored = not far or _is_plain(model, dataset)  # what is far off may be the guess of a plane alone
    if mirrored:
        far = [entry for entry in entries if entry["what"] == PLANE_GUESS]
    if not far:
        return ()
    if dataset.n_poses > MOST_FITTED_POSES:
        dataset = dataset.subset(np.linspace(0, dataset.n_poses - 1, MOST_FITTED_POSES).round().astype(int))
    described = full_fit(dataset)
    if described is None or (not mirrored and _is_plain(described.model, dataset)):
        return ()
    found, at_guesses = [], []
    for joint, angle, read in _of_whole_arm(dataset) if mirrored else _readings(dataset):
        trial = full_fit(read)
        elsewhere = angle is not None and np.isinf(
            angle
        )  # then it is nowhere near its stated place on the flange
        if (
            trial is not None
            and trial.rms <= AS_GOOD * described.rms
            and _is_plain(trial.model, read, anywhere=elsewhere)
        ):
            words = _in_words(joint, angle, trial.model, read.robot)
            found.append((trial.rms, joint, words, elsewhere))
            if not far_guesses(read, trial.model, measure(read).initial_target(read)):
                at_guesses.append(found[-1])
    found = at_guesses if mirrored else at_guesses or found
    if not 0 < len(found) <= MOST_READINGS:
        return ()
    least, joint, _, elsewhere = min(found)
    sensor = "" if elsewhere else ", the sensor"
    words = ", or ".join(words for _, _, words, _ in sorted(found))
    sentence = (
        f"{far[0]['sentence'].split(':')[0]}. But all zeros{', all planes' if mirrored else ''}{sensor} and all lengths come out where "
        f"dataset.yaml has them if {words}; "
        f"the residual is {least / MM:.2g} mm then, and {described.rms / MM:.2g} mm as described (medians of the poses). "
        f"This is the plainer explanation: look {_where_to_look(joint, elsewhere)}"
    )
    where = WHOLE_ARM[joint][0] if joint in WHOLE_ARM else f"joint {joint + 1}"
    what = EARLIER_LINK if elsewhere else "joint_reading"
    return (Suspicion(what, where, sentence, described.rms, least),)


def _where_to_look(joint: int, elsewhere: bool) -> str:
    """Return a clause on what to check at the arm and to correct, for a reading of a joint (from 0), of the whole arm, or of where the target is."""
    if elsewhere:
        return "where the target or the sensor is mounted, and put it on the flange, or describe the arm without the joints behind it"
    if joint in WHOLE_ARM:
        look = WHOLE_ARM[joint][2]
    else:
        look = "which way the joint turns, where it has its zero and which column is its"
    return f"{look}, and {CORRECT_TABLE}, or the mapping of the import"


def instead(entries: Sequence[Mapping[str, Any]]) -> list[Mapping[str, Any]]:
    """Return the entries of ``setup`` that a plainer reading leaves: those that do not say that a fit ended far off."""
    return [entry for entry in entries if entry["what"] not in FAR_OFF | {"sensor_pose", PLANE_GUESS}]


def _readings(dataset: Dataset) -> Iterator[tuple[int, float | None, Dataset]]:
    """Yield the data with another sign (angle None) or zero [rad] of each joint (from 0) that turns and moves.

    After these follow the data with the columns of the joint and the next one exchanged (angle NaN), those in which the joint and those
    after it do not move what is measured (angle infinite), and last ``_of_whole_arm``.
    """
    q = dataset.q
    moving = [
        int(joint) for joint in np.flatnonzero(np.ptp(q, axis=0) > 0) if joint not in dataset.robot.prismatic
    ]
    for joint in moving:
        yield joint, None, replace(dataset, robot=with_sign_changed(dataset.robot, joint))
        for angle in QUARTER_TURNS if joint > 0 else ():  # the zero of joint 1 turns with the base
            yield joint, angle, replace(dataset, robot=with_zero_moved(dataset.robot, joint, angle))
        if joint + 1 in moving:
            yield joint, np.nan, angles_replaced(dataset, swapped_columns(q, joint, joint + 1))
    for joint in moving[2:][::-1]:
        yield joint, np.inf, on_link_before(dataset, joint).dataset
    yield from _of_whole_arm(dataset)


def _of_whole_arm(dataset: Dataset) -> Iterator[tuple[int, float | None, Dataset]]:
    """Yield the data with all joints that move counting the other way (none with three joints or fewer), and with all twists of the other sign."""
    for alternative in all_signs(dataset):
        yield ALL, None, alternative.dataset
    yield TWISTS, None, replace(dataset, robot=with_all_twists_back(dataset.robot))


def _is_plain(model: Model, dataset: Dataset, *, anywhere: bool = False) -> bool:
    """Return whether lengths, zeros and the sensor's place, unless it may be anywhere, are near those of the description."""
    nominal, fitted = dataset.robot.geometry, model.robot.geometry
    lengths = [k for k, kind in enumerate(GEOMETRY) if kind in LENGTHS]
    change = np.abs(fitted - nominal)
    change[:, dataset.robot.slides] = 0.0
    turned = np.abs(within_half_turn(fitted - nominal))[THETA]
    turned[dataset.robot.slides] = 0.0
    T = None if anywhere else dataset.sensor.T_flange_sensor
    shift = 0.0 if T is None else float(np.linalg.norm(model.T_flange_sensor[:3, 3] - T[:3, 3]))
    return bool(
        change[lengths].max() <= most_of_a_link(dataset.robot)
        and turned.max() <= ZERO
        and shift <= SENSOR_SHIFT
    )


def _in_words(joint: int, angle: float | None, model: Model, robot: Robot) -> str:
    """Return the reading as a clause."""
    if joint in WHOLE_ARM:
        return WHOLE_ARM[joint][1]
    if angle is None:
        return f"joint {joint + 1} counts the other way"
    if np.isnan(angle):
        return f"the columns q{joint + 1} and q{joint + 2} of poses.csv are swapped"
    if np.isinf(angle):
        after = (
            f"joint {joint + 1} does"
            if joint + 1 == robot.n_joints
            else f"joints {joint + 1} to {robot.n_joints} do"
        )
        return f"{after} not move what is measured, which then is not on the flange, but on the link before joint {joint + 1}"
    off = angle + model.robot.geometry[THETA, joint] - robot.geometry[THETA, joint]
    return f"the zero of joint {joint + 1} is off by {within_half_turn(off) / DEG:.0f} degrees"
