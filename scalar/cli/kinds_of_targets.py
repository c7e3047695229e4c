"""Refuse tables of targets that hold something else than is needed: frames for joint angles, rows of both kinds, degrees, places far away."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from scalar.errors import Fault, InvalidInput
from scalar.units import unit_of_joint

if TYPE_CHECKING:
    import pandas as pd

    from scalar.geometry.robot import Robot
    from scalar.geometry.se3 import Array

_OF_MAKERS = (
    ({"a", "b", "c"}, "A, B, C of a KUKA are yaw, pitch, roll"),
    ({"w", "p", "r"}, "W, P, R of a FANUC are roll, pitch, yaw"),
    ({"q1", "q2", "q3", "q4"}, "q1, q2, q3, q4 of an orientation in RAPID (ABB) are qw, qx, qy, qz"),
)
"""How makers call the columns of an orientation, and what these are here."""
_FAR = 20.0  # chosen: times the length of all links: places farther away were probably given in millimetres and read as metres
_A_TURN = 6.3  # rad; a little more than 2 pi, since angles are rounded
_MANY = 0.25  # chosen: share of the poses; in a few, a controller may count whole turns


def refuse_frames(columns: Sequence[str], file: str) -> None:
    """Refuse a table of frames, without any joint angle, where joint angles are needed.

    Args:
        columns: Names of its columns.
        file: Name of the table.

    Raises:
        InvalidInput: It is such a table.
    """
    joints, frame = _of_joints_and_frame(columns)
    if frame and not joints:
        message = (
            "a table of frames, and `scalar predict` takes joint angles, pose,q1,q2,...; "
            "for the joint angles at which the arm takes these frames, use `scalar correct`"
        )
        raise InvalidInput(Fault(file, message, 1))


def refuse_without_orientation(columns: Sequence[str], file: str) -> None:
    """Refuse a table of wanted places without any column of an orientation, or in capitals, and say in which forms one may be written.

    Args:
        columns: Names of its columns.
        file: Name of the table.

    Raises:
        InvalidInput: It is such a table.
    """
    from scalar.data.located_table import of_the_same_joint
    from scalar.data.table_units import base_name
    from scalar.estimation.frame_tables import ORIENTATIONS, PLACE, VECTOR

    named = {base_name(column) for column in columns}
    forms = [VECTOR, *ORIENTATIONS.values()]
    capitals = [name for name in named if name.lower() in PLACE and name not in PLACE]
    if len(capitals) == len(PLACE) and "q1" not in named and not of_the_same_joint("q1", list(named)):
        message = (
            f"the columns {', '.join(sorted(capitals))} of a place are called x, y, z here, in small letters (x_mm, y_mm, z_mm where they are in "
            f"millimetres){_of_maker(named) or ': rename them'}"
        )
        raise InvalidInput(Fault(file, message, 1))
    if not named.issuperset(PLACE) or any(named.intersection(form) for form in forms):
        return
    message = (
        "the columns of an orientation are missing; write a rotation vector rx,ry,rz, or roll,pitch,yaw (R = Rz(yaw) Ry(pitch) Rx(roll)), or a "
        f"quaternion qw,qx,qy,qz{_of_maker(named)}"
    )
    raise InvalidInput(Fault(file, message, 1))


def _of_maker(named: Iterable[str]) -> str:
    """Return what the columns of an orientation are that a maker calls otherwise, to be added to a message; empty if they are none of these."""
    lower = {name.lower() for name in named}
    if "q5" in lower:  # joint angles, which give the posture
        lower -= {f"q{i}" for i in range(1, 5)}
    return next((f"; {says}: rename them" for their, says in _OF_MAKERS if their <= lower), "")


def refuse_large_turns(table: pd.DataFrame, form: Sequence[str], file: str) -> None:
    """Refuse a table in which many orientations are more than a turn: these are degrees that were read as radians.

    Args:
        table: The table, with angles in rad.
        form: The columns of its orientations, as ``form_of_orientation`` names them.
        file: Name of the table.

    Raises:
        InvalidInput: It is such a table.
    """
    from scalar.estimation.frame_tables import ORIENTATIONS

    if form == ORIENTATIONS["quaternion"]:
        return
    largest = table[list(form)].abs().max(axis=1)
    if (largest > _A_TURN).mean() > _MANY:
        message = (
            f"an orientation of {largest.max():.4g} rad (pose {table['pose'][largest.idxmax()]}), and of more than a turn in "
            f"{int((largest > _A_TURN).sum())} of {len(table)} poses; are these degrees? say --units deg, or name the columns "
            f"{', '.join(f'{name}_deg' for name in form)}"
        )
        raise InvalidInput(Fault(file, message, column=",".join(form)))


def refuse_far_places(robot: Robot, T: Array, file: str, angle: str = "rad") -> None:
    """Refuse wanted places that are all so far away that they must be in another unit.

    Args:
        robot: The nominal robot.
        T: ``(N, 4, 4)`` [m], the wanted frames.
        file: Name of the table.
        angle: The unit in which the angles of the table were read, which the message keeps.

    Raises:
        InvalidInput: They are.
    """
    import numpy as np

    links = float(np.abs(robot.geometry[[0, 2]]).sum() + np.linalg.norm(robot.T_base_0[:3, 3]))
    nearest = float(np.min(np.linalg.norm(T[:, :3, 3], axis=1), initial=np.inf))
    if nearest > _FAR * links:
        message = (
            f"every place is {nearest:.4g} m from the base or more, and all links together are {links:.3g} m; "
            f"are these millimetres? say --units {'mm' if angle == 'rad' else f'{angle},mm'}, or write metres"
        )
        raise InvalidInput(Fault(file, message))


@contextmanager
def naming_table(file: str) -> Iterator[None]:
    """Where the poses of a table are refused within the block, because they lack a column that an effect needs, name the table.

    Args:
        file: Name of the table.
    """
    try:
        yield
    except InvalidInput as error:
        raise InvalidInput(
            [replace(f, file=file) if f.file == "poses" else f for f in error.faults]
        ) from None


@contextmanager
def naming_cells(table: pd.DataFrame, robot: Robot) -> Iterator[None]:
    """Where a column that is there is refused within the block, say what is wrong with its cells.

    A column that an effect needs, and that is called missing, has other cells than numbers. A joint's position that the arm cannot reach is named
    with its pose and with the limits of the calibration.

    Args:
        table: The table of poses; q1..qn in radians and metres.
        robot: The arm of the calibration.
    """
    try:
        yield
    except InvalidInput as error:
        raise InvalidInput([_of_cells(fault, table, robot) for fault in error.faults]) from None


def _of_cells(fault: Fault, table: pd.DataFrame, robot: Robot) -> Fault:
    """Return a fault of a column with what is wrong with its cells; one of a column that is missing as it is."""
    from scalar.data.poses import is_joint

    if fault.column is None or fault.column not in table.columns:
        return fault
    joint = int(fault.column[1:]) - 1 if is_joint(fault.column) else -1
    if not 0 <= joint < robot.n_joints:
        said = "the calibrated effects need this column, and not all of its cells are numbers; write a number in each row"
        return replace(fault, message=said)
    numbers = table[fault.column].to_numpy(dtype=float)
    row = int(abs(numbers).argmax())
    unit, size = unit_of_joint(slides=bool(robot.slides[joint]))
    low, high = robot.limits[joint] / size
    said = (
        f"pose {table['pose'].iloc[row]}: {numbers[row] / size:.6g} {unit} is far beyond the limits of joint {joint + 1} in the calibration "
        f"({low:.4g} to {high:.4g} {unit}): look at the units of the table; if the joint can stand there, correct its limits in dataset.yaml and "
        "calibrate again, or leave this row out"
    )
    return replace(fault, message=said)


@contextmanager
def naming_mixed_rows(path: Path, columns: Sequence[str]) -> Iterator[None]:
    """Where a table is refused, within the block, because some rows hold joint angles alone or frames alone, say just this.

    Args:
        path: The table.
        columns: Names of its columns.
    """
    try:
        yield
    except InvalidInput:
        faults = _mixed_rows(path, columns)
        if not faults:
            raise
        raise InvalidInput(faults) from None


def _of_joints_and_frame(columns: Sequence[str]) -> tuple[list[int], list[int]]:
    """Return which columns hold joint angles, and which a wanted frame."""
    from scalar.data.table_units import base_name
    from scalar.estimation.frame_tables import PLACE, form_of_orientation

    named = [base_name(column) for column in columns]
    frame = (*PLACE, *form_of_orientation(named))
    joints = [i for i, name in enumerate(named) if re.fullmatch(r"q[1-9][0-9]*", name)]
    return joints, [i for i, name in enumerate(named) if name in frame]


def _mixed_rows(path: Path, columns: Sequence[str]) -> list[Fault]:
    """Return a fault for the rows without any joint angle, and one for those without any number of a frame, if the table has columns of both."""
    from scalar.data.io.semicolons import text_with_commas

    joints, frame = _of_joints_and_frame(columns)
    if not joints or not frame:
        return []
    reader = csv.reader(io.StringIO(text_with_commas(path), newline=""))
    next(reader, None)
    rows = [(reader.line_num, cells) for cells in reader if any(cell.strip() for cell in cells)]

    def without(these: list[int], others: list[int]) -> list[int]:
        """Return the lines that have no cell in one set of columns, and all in the other."""

        def filled(cells: list[str], i: int) -> bool:
            return i < len(cells) and bool(cells[i].strip())

        return [
            line
            for line, cells in rows
            if not any(filled(cells, i) for i in these) and all(filled(cells, i) for i in others)
        ]

    faults: list[Fault] = []
    for lines, has, lacks in (
        (without(joints, frame), "a wanted frame and no joint angles", f"{columns[joints[0]]}, ..."),
        (without(frame, joints), "joint angles and no wanted frame", f"{columns[frame[0]]}, ..."),
    ):
        if lines:
            count = f"{len(lines)} row{'s have' if len(lines) > 1 else ' has'}"
            message = f"{count} {has}, the last in row {lines[-1]}; write such rows into a table of their own, without the columns {lacks}"
            faults.append(Fault(path.name, message, lines[0]))
    return faults
