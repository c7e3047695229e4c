"""Messages of ``scalar correct`` on poses that it could not correct, and on those that it corrected."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from scalar.cli.pose_lines import MOST_SHOWN, first_lines, lines_on_limits
from scalar.errors import Fault
from scalar.units import DEG, MM, unit_of_joint

if TYPE_CHECKING:
    from scalar.data.joint_convention import JointConvention
    from scalar.estimation.correction import Correction, Sensitivity
    from scalar.geometry.robot import Robot
    from scalar.geometry.se3 import Array

_LEAST_SHOWN = 1e-3  # mm or deg; smaller values are shown as "less than" this
# Chosen, of the singular value by which nearness is judged: below it, 1 mm at the sensor of an arm of 1 m takes more than half a degree of a joint.
_LARGE_TURNS = 0.1
_MOST_TURN = 180.0  # deg or mm for a shift of 1 mm: larger values are shown as "more than" this
_TAKEN = "ask for an orientation that it can take, as `scalar predict` writes them"
_EMPTY, _NEAREST = "without joint angles (corrected = 0)", "as near as it comes, with corrected = 0"


@dataclass(frozen=True)
class Uncorrected:
    """A pose that could not be corrected.

    Attributes:
        pose: Number of the pose.
        why: The reason, a clause.
        how_written: How its row is written, a phrase.
        remedy: What to do, a clause.
    """

    pose: int
    why: str
    how_written: str
    remedy: str

    def fault(self, file: str, is_written: bool) -> Fault:
        """Return the fault of the pose; ``is_written`` says whether its row is written."""
        how = f"not corrected, and written {self.how_written}: " if is_written else ""
        return Fault(file, f"pose {self.pose}: {how}{self.why}; {self.remedy}")


def no_posture(pose: int) -> Uncorrected:
    """Return the record of a pose for whose frame no joint angles were found."""
    remedy = "move it, or give q1..qn of a posture near it"
    return Uncorrected(pose, "out of reach within the joint limits", _EMPTY, remedy)


def cannot_take(pose: int, found: Correction, i: int) -> Uncorrected:
    """Return the record of a pose whose frame the calibrated arm cannot take."""
    from scalar.estimation.correction import CorrectionSettings

    if missed := _orientation_missed(found, i):
        return Uncorrected(pose, missed, _EMPTY, _TAKEN)
    if found.position_error[i] > MM * 1e-3 or found.orientation_error[i] > 1e-6:
        off = f"the nearest is {found.position_error[i] / MM:.3g} mm and {found.orientation_error[i] / DEG:.3g} deg away"
    else:
        off = "only joint angles far from those given reach it"
    # The end of the reach is a singularity too, and then the reach is the reason.
    far = found.position_error[i] > CorrectionSettings().near_enough
    where = "probably beyond its reach" if far else _where(found, i)
    why = f"the calibrated arm cannot take it ({where}: {off})"
    return Uncorrected(pose, why, _EMPTY, "move the pose")


def brought_as_near(pose: int, found: Correction, given: Correction | None, i: int) -> Uncorrected:
    """Return the record of a pose that is written with the joint angles near by that come nearest.

    Args:
        pose: Number of the pose.
        found: The correction with these joint angles.
        given: The same with the joint angles as they were given; None if a frame was wanted.
        i: Row of the pose in both.
    """
    if given is None and (missed := _orientation_missed(found, i)):
        return Uncorrected(pose, missed, _NEAREST, _TAKEN)
    uncorrected = "" if given is None else f" (uncorrected by {_errors(given, i)})"
    joints = "no small change of the joints takes" if given is not None else "no joint angles near by take"
    why = f"{_where(found, i)}, {joints} the arm there exactly: it errs by {_errors(found, i)}{uncorrected}"
    return Uncorrected(pose, why, _NEAREST, "move the pose a few degrees away if it has to be exact")


def _orientation_missed(found: Correction, i: int) -> str:
    """Return a clause if an arm with fewer than six joints takes the wanted place, and not the orientation; else an empty text."""
    from scalar.estimation.correction import CorrectionSettings, takes_whole_poses

    settings, n_joints = CorrectionSettings(), found.q.shape[1]
    there = found.position_error[i] <= settings.position
    if (
        takes_whole_poses(n_joints)
        or not there
        or found.orientation_error[i] <= settings.most_turn_of_few_joints
    ):
        return ""
    return f"an arm with {n_joints} joints cannot take every orientation: this one is missed by {_at_least(found.orientation_error[i] / DEG)} deg"


def _errors(found: Correction, i: int) -> str:
    return (
        f"{_at_least(found.position_error[i] / MM)} mm and {_at_least(found.orientation_error[i] / DEG)} deg"
    )


def _at_least(size: float) -> str:
    if size >= 10:
        return f"{size:.0f}"
    return f"{size:.2g}" if size >= _LEAST_SHOWN else f"less than {_LEAST_SHOWN:g}"


def _where(found: Correction, i: int) -> str:
    # A lower bound at the start of the search; `is_near_singular` takes the exact value at the angles that were found.
    return (
        "near a singularity"
        if found.near_singular[i]
        else "not near a singularity; perhaps at the edge of its reach"
    )


def faults_of(uncorrected: Sequence[Uncorrected], file: str, *, is_written: bool = True) -> list[Fault]:
    """Return a fault for each of the first few poses, and one that counts the others; ``is_written``: whether their rows are."""
    faults = [one.fault(file, is_written) for one in uncorrected[:MOST_SHOWN]]
    more = len(uncorrected) - MOST_SHOWN
    if more > 0:
        marked = " (corrected = 0)" if is_written else ""
        faults.append(Fault(file, f"{more} more poses cannot be corrected{marked}; look for a common cause"))
    return faults


def lines_on_left_out(uncorrected: Sequence[Uncorrected]) -> list[str]:
    """Return a line for each of the first few poses that are left out, and one that counts the others."""
    return first_lines([f"  left out: pose {one.pose}: {one.why}" for one in uncorrected])


def warnings_on_written(
    robot: Robot,
    ids: Array,
    found: Correction,
    sensitivity: Sensitivity,
    convention: JointConvention | None = None,
) -> list[str]:
    """Return the warnings on poses that are written: joints beyond their limits, and singularities near by.

    Args:
        robot: The arm, for the limits.
        ids: ``(N,)``, the numbers of the poses in the table.
        found: The corrected joint angles.
        sensitivity: How far each pose is from a singularity.
        convention: How the controller counts the joints; None if as the dataset does.
    """
    import numpy as np

    singular = [
        f"  pose {ids[i]}: near a singularity ({_how_near(robot, sensitivity, int(i))})"
        for i in np.flatnonzero(is_near_singular(sensitivity))
    ]
    return [*lines_on_limits(robot, ids, found.q, convention), *first_lines(singular)]


def is_near_singular(sensitivity: Sensitivity) -> Array:
    """Return which poses are called near a singularity ``(N,)`` bool."""
    from scalar.estimation.correction import CorrectionSettings

    return sensitivity.singular_value < CorrectionSettings().near_singular


def takes_large_turns(sensitivity: Sensitivity) -> Array:
    """Return at which poses ``(N,)`` bool a small correction of the sensor takes a large turn of a joint: near a singularity, and well before it."""
    return sensitivity.singular_value < _LARGE_TURNS


def _how_near(robot: Robot, sensitivity: Sensitivity, i: int) -> str:
    """Return in words how far one joint has to move for a small shift of the sensor at pose i."""
    import numpy as np

    from scalar.estimation.correction import arm_length

    # A travel counts as the turn, at half the arm's length, that moves as far; the joint that moves most is named.
    moves = sensitivity.travel[i] * MM
    joint = int(np.argmax(moves / np.where(robot.slides, arm_length(robot), 1.0)))
    unit, size = unit_of_joint(joint in robot.prismatic)
    move = moves[joint] / size
    size_of_move = f"{move:.2g}" if move < 99.5 else f"{move:.0f}"  # two digits of 170 would read 1.7e+02
    moved = f"up to {size_of_move} {unit}" if move < _MOST_TURN else f"more than {_MOST_TURN:.0f} {unit}"
    return f"smallest singular value {sensitivity.singular_value[i]:.2g}: to shift the sensor by 1 mm, joint {joint + 1} moves by {moved}"


def lines_on_tool(gauge: Sequence[Mapping[str, Any]], robot: Robot) -> list[str]:
    """Return a line on what corrected joint angles leave open of the flange; none if nothing is open. Arguments as in `unknown_of_flange`."""
    unknown = unknown_of_flange(gauge, robot)
    return [
        f"  the sensor is taken where it is wanted; {of_flange}, so another tool may be off by a constant: teach its centre point again with "
        "corrected joint angles"
        for of_flange in unknown
    ]


def line_on_wanted_frames(T_flange_sensor: Array) -> str:
    """Return the line that says whose frames the wanted ones are: those of a tool, taken for the sensor's, put the sensor where the tool belongs.

    Args:
        T_flange_sensor: ``(4, 4)``, the calibrated pose of the sensor.
    """
    x, y, z = (f"{length / MM:.1f}" for length in T_flange_sensor[:3, 3])
    return (
        f"  the wanted frames are taken for those of the sensor, which sits at {x}, {y}, {z} mm on the flange, in the base frame of the table of "
        "joints. If they are those of another tool, give the nominal joint angles of these poses in their place: the flange then goes where the "
        "nominal arm has it"
    )


def unknown_of_flange(gauge: Sequence[Mapping[str, Any]], robot: Robot) -> list[str]:
    """Return a clause on what a calibration does not know of the flange, if it fixed a parameter of the last joint; else none.

    The pose of the sensor on the flange contains the error of such a parameter, which is constant on the flange.

    Args:
        gauge: Of the calibration.
        robot: The nominal arm.
    """
    from scalar.effects.wording import listed
    from scalar.geometry.robot import GEOMETRY
    from scalar.geometry.standard_dh import as_stated

    of_last = [f"{kind}_{robot.n_joints}" for kind in GEOMETRY]
    fixed = [as_stated(str(entry["held"]), robot) for entry in gauge if entry["held"] in of_last]
    if not fixed:
        return []
    are = "is" if len(fixed) == 1 else "are"
    return [f"of the flange itself {listed(fixed)} {are} not known (confounded with the pose of the sensor)"]
