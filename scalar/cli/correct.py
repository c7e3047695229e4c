"""``scalar correct``: joint angles that take the real arm where it is wanted."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from scalar.cli.group import cli
from scalar.cli.options import EFFECTS_MODULE, PATH, UNITS, advice_on_units, load_effects
from scalar.cli.outputs import FORCE, refuse_foreign, table_with
from scalar.cli.terminal import say
from scalar.errors import Fault, InvalidInput
from scalar.units import DEG, MM

if TYPE_CHECKING:
    import pandas as pd

    from scalar.data.table_units import TableUnits
    from scalar.estimation.correction import Correction, Sensitivity
    from scalar.estimation.model import Model
    from scalar.geometry.robot import Robot
    from scalar.geometry.se3 import Array

_FRAME = ("x", "y", "z", "rx", "ry", "rz")
_MOST_SHOWN = 10
_FAR = 20.0  # times all links together: a hand's breadth in millimetres is farther
_MOST_TURN = 180.0  # deg or mm for a shift of 1 mm: beyond it a number says no more than that
_REMEDY = "; move the pose, or leave it out with --leave-out"


@cli.command()
@click.argument("calibration", type=PATH)
@click.argument("targets", type=PATH)
@click.option("-o", "--output", type=PATH, required=True, help="CSV file to write.")
@UNITS
@click.option(
    "--leave-out",
    is_flag=True,
    help="Leave out poses that cannot be corrected, instead of marking or refusing them.",
)
@FORCE
@EFFECTS_MODULE
def correct(
    calibration: Path,
    targets: Path,
    output: Path,
    units: str | None,
    leave_out: bool,
    force: bool,
    effects_modules: Sequence[Path],
) -> None:
    """Correct joint angles so that the real arm stands where it is wanted.

    The table TARGETS says what is wanted, a row a pose:

    \b
      pose,q1..qn         nominal joint angles: the real flange goes where the nominal arm has it
      pose,x,y,z,rx,ry,rz  frames of the sensor in the base frame, as `scalar predict` writes them; with q1..qn
                          beside them, these give the posture, else it is chosen near that of the row before

    pose is a whole number. Angles are in rad, lengths and the travel of joints that slide in m (see --units). All calibrated effects are
    applied; what they need (approach1..n, temperature, time, order) stands in columns of TARGETS.

    The output has pose,q1..qn, the joint angles to command, and every other column of TARGETS as it is (a speed, a tool's number), but not
    what is said of the wanted frame: x..rz, and their standard deviations and correlations as `scalar predict --std` writes them. Four columns
    follow: corrected, 1, or 0 where the row could not be corrected; beyond_limits, the number of joints beyond their limits;
    near_singular, 1 near a singularity; and smallest_singular_value, how near: 0 is
    singular, and below 0.02 is called near (of the Jacobian, lengths in units of the arm's). `scalar predict` gives the wanted frames
    for these joint angles to 1e-6 m.

    A row of joint angles that cannot be corrected, as a home pose at a singularity, is written as it was given, with corrected = 0. All
    other rows are corrected; the exit status is then 2, and a line for each such row says how far the arm errs there. Wanted frames that the arm
    cannot take are refused, and nothing is written. With --leave-out such rows are left out of the output, in both cases.

    \b
    Example:
      scalar correct out/calibration.json program.csv -o corrected.csv --units deg,mm
    """
    import numpy as np

    from scalar.data.pose_tables import read_pose_table
    from scalar.data.poses import Poses
    from scalar.data.table_units import base_name, columns_of, units_named, units_to_write
    from scalar.estimation.correction import correct_table, kept_as_given, sensitivity
    from scalar.estimation.result import load_calibration

    in_units = units_named(units)
    refuse_foreign([(output, table_with("pose", "q1", "near_singular"))], force, [calibration, targets])
    load_effects(effects_modules)
    model = load_calibration(calibration).model
    robot = model.robot
    columns = columns_of(targets)
    named = {base_name(column) for column in columns}
    frames_wanted = bool(named & set(_FRAME))
    with_joints = "q1" in named or not frames_wanted
    with advice_on_units():
        table = read_pose_table(
            targets,
            robot.n_joints,
            _FRAME if frames_wanted else (),
            robot.limits,
            units=in_units,
            joints_needed=with_joints,
            prismatic=robot.prismatic,
            columns=columns,
        )
    T = None
    if frames_wanted:
        T = _frames(table)
        _check_reach(robot, T, targets.name)
        if not with_joints:
            table = _with_postures(model, table, T, str(targets), leave_out)
            T = _frames(table)
    found = correct_table(model, table, T)
    ids = table["pose"].to_numpy()
    poses = Poses.from_frame(table, robot.n_joints, order_is_row=False)
    wrong = np.flatnonzero(~found.reached)
    kept = np.arange(len(ids)) if T is None and not leave_out else np.flatnonzero(found.reached)
    as_given: list[Fault] = []
    if len(kept) == len(ids):
        found = kept_as_given(model, poses, found)
        as_given = _few([_left_as_given(str(targets), ids[i], found, int(i)) for i in wrong], str(targets))
    elif not leave_out or not len(kept):
        raise InvalidInput(_cannot(str(targets), ids[wrong], found, wrong))
    else:
        for fault in _cannot(str(targets), ids[wrong], found, wrong):
            say(f"  left out: {fault.message.partition(_REMEDY)[0]}")
    near = sensitivity(model, poses, found.q)
    for line in _said(robot, ids, found, near, kept):
        say(line)
    out_units = units_to_write(units, columns)
    _write(output, table, found, near, kept, out_units.sliding(robot.prismatic))
    corrected = int(found.reached[kept].sum())
    say(f"written: {output}, {len(kept)} poses" + (f", {corrected} of them corrected" if as_given else ""))
    if as_given:
        raise InvalidInput(as_given)


def _frames(table: pd.DataFrame) -> Array:
    from scalar.geometry.se3 import transform_from_rotation_vector

    values = table[list(_FRAME)].to_numpy(dtype=float)
    return transform_from_rotation_vector(values[:, :3], values[:, 3:])


def _check_reach(robot: Robot, T: Array, file: str) -> None:
    """Refuse places that are all so far away that another unit must be meant."""
    import numpy as np

    links = float(np.abs(robot.geometry[[0, 2]]).sum() + np.linalg.norm(robot.T_base_0[:3, 3]))
    nearest = float(np.min(np.linalg.norm(T[:, :3, 3], axis=1), initial=np.inf))
    if nearest > _FAR * links:
        message = (
            f"every place is {nearest:.4g} m from the base or more, and all links together are {links:.3g} m; "
            "are these millimetres? say --units mm, or write metres"
        )
        raise InvalidInput(Fault(file, message))


def _with_postures(model: Model, table: pd.DataFrame, T: Array, file: str, leave_out: bool) -> pd.DataFrame:
    """Return the table with joint angles of the rigid arm; poses that it cannot take are left out or refused."""
    import numpy as np

    from scalar.estimation.correction import postures_for

    q, there = postures_for(model, T)
    ids = table["pose"].to_numpy()
    missing = np.flatnonzero(~there)
    faults = [
        Fault(
            file,
            f"pose {pose}: out of reach within the joint limits; correct it, or give q1..qn of a posture near it",
        )
        for pose in ids[missing]
    ]
    if faults and (not leave_out or len(faults) == len(ids)):
        raise InvalidInput(_few(faults, file))
    for fault in _few(faults, file) if faults else ():
        say(f"  left out: {fault.message.partition(';')[0]}")
    joints = {f"q{i + 1}": q[there, i] for i in range(q.shape[1])}
    return table[there].reset_index(drop=True).assign(**joints)


def _cannot(file: str, ids: Array, found: Correction, wrong: Array) -> list[Fault]:
    """Return a fault for each pose that the arm does not reach."""
    faults = []
    for pose, i in zip(ids, wrong, strict=True):
        if found.position_error[i] > MM * 1e-3 or found.orientation_error[i] > 1e-6:
            off = f"the nearest is {found.position_error[i] / MM:.3g} mm and {found.orientation_error[i] / DEG:.3g} deg away"
        else:
            off = "it takes another posture"
        why = "near a singularity" if found.near_singular[i] else "at the edge of its reach"
        message = f"pose {pose}: the calibrated arm cannot take it ({why}: {off}){_REMEDY}"
        faults.append(Fault(file, message))
    return _few(faults, file)


def _left_as_given(file: str, pose: int, found: Correction, i: int) -> Fault:
    """Return what is said of a row of joint angles that is written as it was given."""
    why = "near a singularity" if found.near_singular[i] else "at the edge of its reach"
    off = f"{found.position_error[i] / MM:.2g} mm and {found.orientation_error[i] / DEG:.2g} deg"
    message = (
        f"pose {pose}: not corrected, and written as it was given with corrected = 0: {why}, no small change of the joints takes the arm "
        f"there, and uncorrected it errs by {off}; move the pose a few degrees away if it has to be exact, or keep it, as for a home pose"
    )
    return Fault(file, message, None, "q1..qn")


def _few(faults: list[Fault], file: str) -> list[Fault]:
    if len(faults) <= _MOST_SHOWN:
        return faults
    more = Fault(file, f"{len(faults) - _MOST_SHOWN} more poses with the same fault; look for a common cause")
    return [*faults[:_MOST_SHOWN], more]


def _said(robot: Robot, ids: Array, found: Correction, near: Sensitivity, kept: Array) -> list[str]:
    """Return what a user has to know of the poses that are written."""
    import numpy as np

    lines = []
    for i in kept[found.beyond_limits[kept].any(axis=1)]:
        joint = int(np.argmax(found.beyond_limits[i]))
        size, unit = (MM, "mm") if joint in robot.prismatic else (DEG, "deg")
        low, high = robot.limits[joint] / size
        stands = found.q[i, joint] / size
        lines.append(
            f"  pose {ids[i]}: joint {joint + 1} at {stands:.3f} {unit} is beyond its limits {low:.1f} to {high:.1f} {unit}"
        )
    shown = _some(lines)
    singular = [
        f"  pose {ids[i]}: near a singularity ({_how_near(robot, near, i)})" for i in kept[_near(near)[kept]]
    ]
    return [*shown, *_some(singular)]


def _near(near: Sensitivity) -> Array:
    """Return which poses are called near a singularity ``(N,)`` bool."""
    from scalar.estimation.correction import CorrectionSettings

    return near.singular_value < CorrectionSettings().near_singular


def _how_near(robot: Robot, near: Sensitivity, i: int) -> str:
    """Return by how much a joint moves for a small shift there."""
    import numpy as np

    # Of joints that turn and such that slide the largest number of degrees or millimetres is named.
    units = [("mm", MM) if joint in robot.prismatic else ("deg", DEG) for joint in range(robot.n_joints)]
    moves = near.travel[i] * MM / np.array([size for _, size in units])
    joint = int(np.argmax(moves))
    unit = units[joint][0]
    moved = (
        f"up to {moves[joint]:.2g} {unit}"
        if moves[joint] < _MOST_TURN
        else f"more than {_MOST_TURN:.0f} {unit}"
    )
    return f"smallest singular value {near.singular_value[i]:.2g}: to shift the sensor by 1 mm, joint {joint + 1} moves by {moved}"


def _some(lines: list[str]) -> list[str]:
    more = len(lines) - _MOST_SHOWN
    return [*lines[:_MOST_SHOWN], f"  and {more} more poses likewise"] if more > 0 else lines


def _write(
    path: Path, table: pd.DataFrame, found: Correction, near: Sensitivity, kept: Array, units: TableUnits
) -> None:
    """Write the joint angles, with the other columns of the table and what is to be known of each pose."""
    import pandas as pd

    from scalar.data.io.atomic import atomic_write
    from scalar.estimation.frame_tables import tells_of_frame

    n = found.q.shape[1]
    columns = {"pose": table["pose"].to_numpy()[kept]}
    for i in range(n):
        name = f"q{i + 1}"
        columns[units.named(name)] = found.q[kept, i] / units.of(name)[1]
    own = {
        "corrected": found.reached[kept].astype(int),
        "beyond_limits": found.beyond_limits[kept].sum(axis=1),
        "near_singular": _near(near)[kept].astype(int),
        "smallest_singular_value": near.singular_value[kept],
    }
    joints = {f"q{i + 1}" for i in range(n)}
    for name in table.columns:
        if name not in ("pose", *joints, *own) and not tells_of_frame(str(name)):
            columns[name] = table[name].to_numpy()[kept]
    columns |= own
    with atomic_write(path) as temporary:
        pd.DataFrame(columns).to_csv(temporary, index=False, float_format="%.15g")
