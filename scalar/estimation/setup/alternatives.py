"""Alternative readings of a set-up: the same measurements with one change of a sign, a zero, a convention, a unit, labels or the order.

Each alternative is a whole dataset. Those that concern the robot alone change its table of joints, so that a corrected ``dataset.yaml``
can be written. The others change the tables of measurements, which the user has to correct at their source.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from scalar.data.dataset import Dataset
from scalar.estimation.setup.length_units import LENGTH_UNITS
from scalar.estimation.setup.mirror_image import or_wrong_signs
from scalar.estimation.setup.other_angles import angles_replaced, shifted, swapped_columns, with_angles_of
from scalar.geometry.angles import within_half_turn
from scalar.geometry.robot import GEOMETRY, Robot, link_end
from scalar.geometry.se3 import Array
from scalar.geometry.standard_dh import read_as_modified, read_as_standard
from scalar.sensors import kind_of
from scalar.units import DEG, MM

# Step between the zeros of a joint that are tried: from half of it away, a fit still converges.
ZERO_STEP = 30 * DEG
CORRECT_TABLE = "correct the table of joints in dataset.yaml"
_OR_THE_MAPPING = (
    CORRECT_TABLE + "; where 'scalar import' made the tables, change {} in the mapping, and import again"
)
CORRECT_JOINT = _OR_THE_MAPPING.format("sign or offset of this joint")
CORRECT_SIGNS = _OR_THE_MAPPING.format("the signs of these joints")
A, ALPHA, D, THETA, BETA = range(len(GEOMETRY))


@dataclass(frozen=True, eq=False)
class Alternative:
    """One other reading of a set-up.

    Attributes:
        what: ``joint_sign``, ``joint_zero``, ``convention``, ``swapped_joints``, ``angle_unit``, ``length_unit``, ``swapped_planes``,
            ``shifted_poses``, ``reversed_poses``, ``mirrored``, ``coupled_joints``, ``twist_sign``, ``length_sign``, ``length_digit``,
            ``length_scale``, ``strange_target``, ``sign_and_zero``, ``earlier_link``, ``lost_row``, ``moved_target``, ``exchanged_target``,
            ``exchanged_names``, ``exchanged_columns`` or ``other_arm``.
        where: What it concerns, as a person names it: ``joint 4``, ``planes floor and wall``.
        says: What is wrong with the description if this reading is right, as a clause: ``joint 4 counts the other way``.
        changed: Under which change the residual was computed, for the message: ``with its sign changed``.
        remedy: What to do.
        dataset: The measurements under this reading.
        file: The file that has to be corrected, as in ``Suspicion``.
        corrects_robot: Whether ``dataset.robot`` is all that differs.
        zeros: The joints, from 1, that have another zero in this reading, each with what was added to its theta [rad].
        counts_back: Whether those joints count the other way as well.
        scale: Factor by which the measured lengths were multiplied; a residual that shrinks by the same factor proves nothing.
        motion: Factor by which the joint angles were multiplied, where the arm hardly moves as described or under this reading. An arm that hardly
            moves leaves a residual that is smaller by as much, whatever is measured.
        may_leave: Residual [m] that it may leave and explain the data; None for what the effects of an arm may leave.
    """

    what: str
    where: str
    says: str
    changed: str
    remedy: str
    dataset: Dataset
    file: str = ""
    corrects_robot: bool = False
    zeros: tuple[tuple[int, float], ...] = ()
    counts_back: bool = False
    scale: float = 1.0
    motion: float = 1.0
    may_leave: float | None = None


def alternatives(dataset: Dataset) -> Iterator[Alternative]:
    """Yield the alternatives of signs, zeros, convention, order, labels and lengths, the simplest first."""
    n = dataset.robot.n_joints
    moving = [j for j in range(n) if np.ptp(dataset.q[:, j]) > 0]
    for j in moving:
        yield with_robot(
            dataset,
            with_sign_changed(dataset.robot, j),
            "joint_sign",
            f"joint {j + 1}",
            f"joint {j + 1} counts the other way",
            "with its sign changed",
            CORRECT_JOINT,
        )
    yield from _planes_swapped(dataset)
    yield from _measurements_otherwise(dataset)
    yield from _convention(dataset)
    slides = dataset.robot.slides
    for i, j in itertools.combinations(moving, 2):
        if slides[i] != slides[j]:
            continue
        yield with_angles(
            dataset,
            swapped_columns(dataset.q, i, j),
            "swapped_joints",
            f"joints {i + 1} and {j + 1}",
            f"the columns q{i + 1} and q{j + 1} of poses.csv are swapped",
            "with the two columns exchanged",
            "exchange the two columns in poses.csv; where 'scalar import' made it, exchange them in the mapping, and import again",
        )
    for j in moving:
        if j not in dataset.robot.prismatic:  # a wrong zero of a travel is taken up by the geometry
            yield from _zeros(dataset, j)


def with_sign_changed(robot: Robot, joint: int) -> Robot:
    """Return the arm whose joint (from 0) counts the other way: ``Rz(-q + theta) Tz(d) = Rx(pi) Rz(q - theta) Tz(-d) Rx(-pi)``.

    The same holds for a travel, ``Rz(theta) Tz(-q + d)``.
    Hayati's angle beta lies between the two rotations about x, so its sign changes as well: ``Ry(beta) Rx(pi) = Rx(pi) Ry(-beta)``.
    """
    geometry = robot.geometry.copy()
    geometry[ALPHA, joint] = within_half_turn(geometry[ALPHA, joint] + np.pi)
    for kind in (D, THETA, BETA):
        geometry[kind, joint] = -geometry[kind, joint]
    T_n_flange, end = robot.T_n_flange, robot.standard_end
    if joint + 1 < robot.n_joints:
        geometry[ALPHA, joint + 1] = within_half_turn(geometry[ALPHA, joint + 1] - np.pi)
    else:
        T_n_flange = link_end(0.0, -np.pi) @ T_n_flange
        end = None if end is None else (end[0], float(within_half_turn(end[1] - np.pi)))
    return replace(robot, geometry=geometry, T_n_flange=T_n_flange, standard_end=end)


def with_limits_counted_back(robot: Robot, q: Array) -> Robot:
    """Return the arm with those limits counted the other way that contain the measured positions of their joint ``(N, n)`` only then."""
    back = -robot.limits[:, ::-1]
    within, within_back = (
        np.all((q >= limits[:, 0]) & (q <= limits[:, 1]), axis=0) for limits in (robot.limits, back)
    )
    return replace(robot, limits=np.where((within_back & ~within)[:, None], back, robot.limits))


def with_zero_moved(robot: Robot, joint: int, angle: float) -> Robot:
    """Return the arm whose joint (from 0) has its zero elsewhere: ``angle`` [rad] is added to its theta."""
    geometry = robot.geometry.copy()
    geometry[THETA, joint] = within_half_turn(geometry[THETA, joint] + angle)
    return robot.with_geometry(geometry)


def _convention(dataset: Dataset) -> Iterator[Alternative]:
    """Yield the alternative in which the table of joints follows the other convention of Denavit and Hartenberg; none with a parameter beta."""
    robot = dataset.robot
    if robot.geometry[BETA].any():
        return
    says, other = (
        ("the table of joints is modified DH", read_as_modified)
        if robot.standard_dh
        else ("the table of joints is standard DH", read_as_standard)
    )
    changed = "with the table read that way"
    yield with_robot(dataset, other(robot), "convention", "robot.convention", says, changed)


def _zeros(dataset: Dataset, joint: int) -> Iterator[Alternative]:
    """Yield the alternatives in which the zero of a joint, from 0, is elsewhere, in steps of ``ZERO_STEP``."""
    for k in range(1, round(2 * np.pi / ZERO_STEP)):
        angle = float(within_half_turn(k * ZERO_STEP))
        yield replace(
            with_robot(
                dataset,
                with_zero_moved(dataset.robot, joint, angle),
                "joint_zero",
                f"joint {joint + 1}",
                f"the zero of joint {joint + 1} is off",
                "with its zero moved",
                CORRECT_JOINT,
            ),
            zeros=((joint + 1, angle),),
        )


def _planes_swapped(dataset: Dataset) -> Iterator[Alternative]:
    """Yield the alternatives in which the labels of two target planes are exchanged."""
    names = [plane.name for plane in dataset.planes]
    if "plane" not in dataset.poses.columns:
        return
    labels = dataset.poses["plane"].to_numpy(dtype=object)
    for a, b in itertools.combinations([n for n in names if n in set(labels)], 2):
        exchanged = np.where(labels == a, b, np.where(labels == b, a, labels))
        yield Alternative(
            "swapped_planes",
            f"planes {a} and {b}",
            f"the labels '{a}' and '{b}' are exchanged in poses.csv",
            "with the two exchanged",
            f"exchange '{a}' and '{b}' in the column plane of poses.csv; where 'scalar import' made it, look at column and names of the plane in the "
            "mapping",
            replace(dataset, poses=dataset.poses.assign(plane=exchanged)),
            file="poses.csv",
        )


def _measurements_otherwise(dataset: Dataset) -> Iterator[Alternative]:
    """Yield the measured points in other units, mirrored, and assigned to the previous or next pose."""
    file = kind_of(dataset).format.measured_in
    if len(dataset.points):
        for unit, factor in LENGTH_UNITS.items():
            as_metres = ((unit, factor * MM),) if factor * MM < 1.0 else ()
            for name, scale in (
                (unit, factor),
                (f"millimetres where {unit} are meant", 1.0 / factor),
                *as_metres,
            ):
                yield Alternative(
                    "length_unit",
                    file,
                    f"the lengths in {file} are {scale:g} times too small"
                    if scale > 1
                    else f"the lengths in {file} are {1 / scale:g} times too large",
                    f"with {file} multiplied by {scale:.6g}",
                    f"look at the unit of {file} ({name}?) and write metres",
                    replace(dataset, points=dataset.points * scale),
                    scale=scale,
                )
        if dataset.points.shape[1] == 3:
            yield Alternative(
                "mirrored",
                file,
                f"the frame of {file} is left-handed",
                "with y counted the other way",
                f"change the sign of one column of {file}, or exchange two{or_wrong_signs(dataset.robot)}",
                replace(dataset, points=dataset.points * np.array([1.0, -1.0, 1.0])),
            )
    for labels_go_along in readings_of_labels(dataset):
        yield Alternative(
            "reversed_poses",
            "poses.csv",
            "the measurements are listed in the reverse order of the poses, the last one first",
            "with the joint angles in reverse order",
            "write angles and measurements in one order",
            with_angles_of(dataset, dataset.poses.iloc[::-1], labels_go_along),
        )
        for shift in (1, -1):
            if dataset.n_poses > 2:
                yield Alternative(
                    "shifted_poses",
                    "poses.csv",
                    f"each measurement belongs to the pose {'before' if shift > 0 else 'after'} the one that it is listed with",
                    "with the joint angles moved by one row",
                    "look where the rows of angles and of measurements were joined",
                    shifted(dataset, np.full(dataset.n_poses, shift), labels_go_along),
                )


def readings_of_labels(dataset: Dataset) -> tuple[bool, ...]:
    """Return whether the label of the plane may stand with the joint angles, where these belong to another measurement: both are tried.

    The measurement of a touch probe is its label and nothing else: if it stood with the angles, moved rows would only be rows left out, and the
    residual would fall wherever these contradict all others.
    """
    return (False, True) if dataset.planes and len(dataset.points) else (False,)


def with_robot(
    dataset: Dataset,
    robot: Robot,
    what: str,
    where: str,
    says: str,
    changed: str,
    remedy: str = CORRECT_TABLE,
) -> Alternative:
    """Return the alternative in which the arm alone is another one; arguments as the attributes of ``Alternative``."""
    return Alternative(what, where, says, changed, remedy, replace(dataset, robot=robot), corrects_robot=True)


def with_angles(
    dataset: Dataset, q: Array, what: str, where: str, says: str, changed: str, remedy: str
) -> Alternative:
    """Return the alternative in which poses.csv has other joint positions; ``q`` as in ``angles_replaced``, the rest as in ``Alternative``."""
    return Alternative(what, where, says, changed, remedy, angles_replaced(dataset, q), file="poses.csv")
