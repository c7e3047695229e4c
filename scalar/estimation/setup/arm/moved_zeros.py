"""Other zeros of joints: where quick fits have them, and where the fit of an alternative does, in words and as a table of joints."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

from scalar.data.dataset import Dataset
from scalar.estimation.setup.alternatives import THETA, ZERO_STEP, Alternative, with_zero_moved
from scalar.estimation.setup.trial import quick_fit
from scalar.geometry.angles import within_half_turn
from scalar.geometry.robot import Robot
from scalar.units import DEG

ROUNDED = 1 * DEG  # zeros of a corrected table: the rest is an error of the arm, which a calibration finds


def best_zeros(
    dataset: Dataset, joints: Sequence[int], starts: Iterable[Sequence[float]]
) -> tuple[float, ...]:
    """Return what has to be added to theta of k joints (from 0) [rad], by the best of several quick fits.

    Args:
        dataset: What was measured.
        joints: ``(k,)``, joints that turn.
        starts: From which angles ``(k,)`` [rad], added to theta, each fit starts.
    """
    found: list[tuple[float, tuple[float, ...]]] = []
    for start in starts:
        robot = dataset.robot
        for joint, angle in zip(joints, start, strict=True):
            robot = with_zero_moved(robot, joint, angle)
        nominal, model = quick_fit(replace(dataset, robot=robot), joints)
        fitted = (robot if model is None else model.robot).geometry - dataset.robot.geometry
        found.append((nominal.rms, tuple(float(fitted[THETA, joint]) for joint in joints)))
    return min(found)[1]


def zeros_moved(alternative: Alternative, fitted: Robot) -> list[float]:
    """Return how far the fitted zeros of an alternative's joints are from those as described [rad], each within half a turn.

    Args:
        alternative: With k joints whose zeros it moves.
        fitted: The arm of its fit.

    Returns:
        k angles that are to be added to the angles of the joints, as these count in the alternative.
    """
    nominal = alternative.dataset.robot.geometry[THETA]
    angles = [fitted.geometry[THETA, j - 1] - (nominal[j - 1] - added) for j, added in alternative.zeros]
    return [float(within_half_turn(angle)) for angle in angles]


def as_described(alternative: Alternative, fitted: Robot) -> bool:
    """Return whether the fit of another zero has returned to a zero as described: to where its own fit would have converged.

    The set-up as described may have no fit of its own, because fewer parameters were found to be determined at its initial estimate.
    """
    return any(abs(angle) < ZERO_STEP / 2 for angle in zeros_moved(alternative, fitted))


def with_zeros_of(alternative: Alternative, fitted: Robot) -> Robot:
    """Return the arm of an alternative with its zeros where the fit has them, to a degree."""
    robot = alternative.dataset.robot
    for (joint, added), angle in zip(alternative.zeros, zeros_moved(alternative, fitted), strict=True):
        robot = with_zero_moved(robot, joint - 1, ROUNDED * round(angle / ROUNDED) - added)
    return robot


def zeros_in_words(alternative: Alternative, fitted: Robot) -> str:
    """Return what is wrong with zeros, and with the sense of counting if that is, as a clause with the fitted angles."""
    joints = [str(joint) for joint, _ in alternative.zeros]
    sign = -1.0 if alternative.counts_back else 1.0
    degrees = [sign * angle / DEG for angle in zeros_moved(alternative, fitted)]
    if alternative.counts_back:
        (joint,), (off,) = joints, degrees
        angle = f"-q{joint} {'-' if off < 0 else '+'} {abs(off):.1f}"
        return f"joint {joint} counts the other way and its zero is off by {off:.1f} degrees (its angle is {angle} degrees)"
    if len(joints) == 1:
        return f"the zero of joint {joints[0]} is off by {degrees[0]:.1f} degrees"
    return f"the zeros of joints {' and '.join(joints)} are off by {' and '.join(f'{off:.1f}' for off in degrees)} degrees"
