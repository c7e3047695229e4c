"""Lines about poses of a table: about the first few of a kind and a count of the others, or one about all of them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scalar.units import DEG, MM, unit_of_joint

if TYPE_CHECKING:
    from collections.abc import Sequence

    import pandas as pd

    from scalar.data.joint_convention import JointConvention
    from scalar.data.table_units import TableUnits
    from scalar.effects import Effect
    from scalar.estimation.result import Calibration
    from scalar.geometry.robot import Robot
    from scalar.geometry.se3 import Array

MOST_SHOWN = 10
"""Most poses that are listed one by one."""
_FEW_ROWS = 3  # chosen: so few poses may all be near zero
_SMALL_TRAVEL = 10.0  # mm, chosen: if no travel in a program is larger, its numbers are probably metres
# What a calibration may doubt in the table of joints.
_OF_THE_TABLE = "robot", "joint_zero", "joint_reading", "length_unit", "stretched_lengths"
_LARGE_TURN, _LARGE_TRAVEL = 1 * DEG, 10 * MM
"""Chosen: ten times what the errors of an arm usually take away from singularities."""
_MOST_JOINTS = 3  # named in the line on measured ranges, those with the most poses outside first


def first_lines(lines: list[str]) -> list[str]:
    """Return the first lines, and one that counts the others."""
    more = len(lines) - MOST_SHOWN
    return [*lines[:MOST_SHOWN], f"  and {more} more poses likewise"] if more > 0 else lines


def lines_on_limits(
    robot: Robot, ids: Array, q: Array, convention: JointConvention | None = None
) -> list[str]:
    """Return a line for each of the first few poses at which joints are beyond their limits, with each such joint, and one that counts the others.

    Args:
        robot: Whose limits count; a revolute joint without stated limits has half a turn on either side of zero.
        ids: ``(N,)``, numbers of the poses.
        q: ``(N, n)`` [rad; m of a joint that slides].
        convention: How the controller counts the joints, which the lines then name as it does; None for the joints of the dataset.
    """
    import numpy as np

    beyond = (q < robot.limits[:, 0]) | (q > robot.limits[:, 1])
    there = np.flatnonzero(beyond.any(axis=1))
    shown, limits = q, np.broadcast_to(robot.limits, (*q.shape, 2))
    if convention is not None:
        shown, limits = convention.to_controller(q), convention.limits_at(q, robot.limits)
    lines = []
    for i in there:
        clauses = []
        for joint in np.flatnonzero(beyond[i]):
            unit, size = unit_of_joint(joint in robot.prismatic)
            low, high = limits[i, joint] / size
            clauses.append(
                f"joint {joint + 1} at {shown[i, joint] / size:.3f} {unit} is beyond its limits {low:.1f} to {high:.1f} {unit}"
            )
        lines.append(f"  pose {ids[i]}: {'; '.join(clauses)}")
    return first_lines(lines)


def lines_on_small_degrees(robot: Robot, q: Array, unit: str) -> list[str]:
    """Return one line if all joint angles of a table in degrees are so small that they are probably radians; else none.

    Args:
        robot: Whose joints slide or turn.
        q: ``(N, n)`` [rad; m of a joint that slides].
        unit: The unit of the angles in the table.
    """
    import numpy as np

    turning = [i for i in range(robot.n_joints) if i not in robot.prismatic]
    numbers = np.abs(q[:, turning]) / unit_of_joint(slides=False)[1]
    if unit != "deg" or len(numbers) < _FEW_ROWS or numbers.max(initial=0.0) > 2.0 * np.pi:
        return []
    if np.count_nonzero(numbers.max(axis=0) > 1.0) < 2:  # poses near the zeros of all joints
        return []
    return [
        f"  check the units: no joint angle of these {len(numbers)} poses is larger than {numbers.max():.3g} deg; if they are radians, "
        "say --units rad or rad,mm, or rename columns that end in _deg"
    ]


def lines_on_small_travels(robot: Robot, q: Array, columns: Sequence[str], units: TableUnits) -> list[str]:
    """Return a line for each joint that slides whose travels, read in millimetres, are all so small that they are probably metres.

    Args:
        robot: Whose joints slide or turn.
        q: ``(N, n)`` [rad; m of a joint that slides].
        columns: Names in the first line of the table.
        units: Units of the columns whose names state none.
    """
    import numpy as np

    lines = []
    for joint in robot.prismatic:
        name = f"q{joint + 1}"
        in_mm = units.length == "mm" if name in columns else f"{name}_mm" in columns
        numbers = q[:, joint] / MM
        low, high = robot.limits[joint]
        largest = np.abs(numbers).max(initial=0.0)
        if not in_mm or not 0.0 < largest < _SMALL_TRAVEL or numbers.min() < low or numbers.max() > high:
            continue  # as metres they would be beyond the limits
        say = f"name the column {name}_m" if name in columns else f"rename the column {name}_mm to {name}_m"
        lines.append(
            f"  check the units: joint {joint + 1} slides, and its largest travel in this table is {largest:.3g} mm; if the column {name} is in "
            f"metres, {say}"
        )
    return lines


def lines_on_setup(calibration: Calibration) -> list[str]:
    """Return a line for each doubt of the calibration about its table of joints, by which the joint angles of a program are understood."""
    return [
        f"  check the table of joints first: {doubt['sentence']}. The joint angles of this program are read by that table: if the controller has "
        "another number, and it is the right one, the corrections are wrong by the difference"
        for doubt in _doubts(calibration)
        if doubt["what"] in _OF_THE_TABLE
    ]


def lines_on_doubts(calibration: Calibration) -> list[str]:
    """Return a line for each doubt of the calibration about how the set-up is described, since whoever reads its file has not seen them."""
    return [
        f"  the calibration has a doubt about its set-up: {doubt['sentence']}"
        for doubt in _doubts(calibration)
    ]


def _doubts(calibration: Calibration) -> list[dict[str, Any]]:
    """Return what the calibration doubts in its set-up, but for the robot's name: the numbers in the table fit the measurements."""
    return [doubt for doubt in calibration.summary.get("setup", ()) if doubt.get("where") != "robot.name"]


def lines_on_large_changes(
    robot: Robot, ids: Array, nominal: Array, corrected: Array, takes_large_turns: Array
) -> list[str]:
    """Return one line on the joint positions that a correction changes by more than a degree or 10 mm; none if it changes none by as much.

    Args:
        robot: Whose joints slide or turn.
        ids: ``(N,)``, numbers of the poses.
        nominal: ``(N, n)`` [rad; m of a joint that slides], as given.
        corrected: ``(N, n)``, to be commanded.
        takes_large_turns: ``(N,)`` bool, the poses so near a singularity that a small correction of the sensor takes a large turn of a joint.
    """
    import numpy as np

    change = np.abs(corrected - nominal)
    most = np.array([_LARGE_TRAVEL if i in robot.prismatic else _LARGE_TURN for i in range(robot.n_joints)])
    size = np.nan_to_num((change / most).max(axis=1))
    large = [int(i) for i in np.argsort(-size, kind="stable") if size[i] > 1.0]
    if not large:
        return []

    def words(i: int) -> str:
        joint = int(np.nanargmax(change[i] / most))
        unit, one = unit_of_joint(joint in robot.prismatic)
        return f"pose {ids[i]} (joint {joint + 1} by {change[i, joint] / one:.1f} {unit})"

    named = ", ".join(words(i) for i in large[:_MOST_JOINTS])
    more = f" and {len(large) - _MOST_JOINTS} more" if len(large) > _MOST_JOINTS else ""
    why = "; near a singularity a small correction of the sensor takes a large turn of a joint"
    if not takes_large_turns[large].all():
        why = ", and not only near singularities: is the calibration that of this robot, and was the program made with the same table of joints?"
    return [f"  look at these before they run: the correction moves a joint far in {named}{more}{why}"]


def lines_on_measured_columns(calibration: Calibration, table: pd.DataFrame) -> list[str]:
    """Return a line for each column that effects follow, such as a temperature, with values clearly outside of those that were measured.

    Args:
        calibration: Which states the ranges over its poses, unless an earlier release has written it.
        table: The poses, with their columns.
    """
    import numpy as np

    from scalar.estimation.measured_ranges import clearly_outside, measured_columns

    lines = []
    for name, limits in measured_columns(calibration.summary).items():
        if name not in table.columns:
            continue
        values = table[name].to_numpy(dtype=float)
        count = int(np.count_nonzero(clearly_outside(limits[None], values[:, None])))
        if count:
            lines.append(
                f"  {count} {'pose has' if count == 1 else 'poses have'} a {name} outside of what was measured ({limits[0]:g} to {limits[1]:g}; here "
                f"{values.min():g} to {values.max():g}): no measurement shows that the effect continues in the same way there; check the unit of the "
                "column too"
            )
    return lines


def lines_on_moves(calibration: Calibration, table: pd.DataFrame) -> list[str]:
    """Return a line for each effect of the moves before a pose that the table does not tell, so that it is left out, with what that may cost.

    Args:
        calibration: With its effects.
        table: The poses, with their columns.
    """
    lines = []
    for effect in calibration.model.effects:
        if not effect.moves_from or any(name in table.columns for name in effect.moves_from):
            continue
        moved = _moved_by_side(calibration, table, effect)
        cost = f", which moves positions by up to {moved / MM:.2g} mm to either side" if moved else ""
        lines.append(
            f"  {effect.title} is not corrected{cost}: it depends on how the arm came to the pose. Add the column {' or '.join(effect.moves_from)}"
        )
    return lines


def _moved_by_side(calibration: Calibration, table: pd.DataFrame, effect: Effect) -> float:
    """Return how far an effect moves the position of a pose of a table at most [m], if a recorded direction of approach would tell it; else 0."""
    import numpy as np

    told = [name for name in effect.moves_from if name.startswith("approach")]
    if not told or "q1" not in table.columns:  # as in a table of wanted frames
        return 0.0
    joints = [f"q{i + 1}" for i in range(calibration.model.robot.n_joints)]
    table = table.dropna(subset=joints)  # of wanted frames that the arm cannot take
    above, below = (
        frames_if(calibration, table, **dict.fromkeys(told, side))[:, :3, 3] for side in (1.0, -1.0)
    )
    return float(np.linalg.norm(above - below, axis=1).max(initial=0.0)) / 2.0


def frames_if(calibration: Calibration, table: pd.DataFrame, **columns: float) -> Array:
    """Return the frames ``(N, 4, 4)`` that are predicted for the poses of a table if some columns had one value each in all rows.

    Args:
        calibration: With its effects.
        table: With q1..qn, the columns that the effects need, and any others, which are passed over where a cell is no number.
        columns: The values.
    """
    import numpy as np

    from scalar.data.moves import joint_angles

    q = joint_angles(table, calibration.model.robot.n_joints)
    numeric = table.select_dtypes("number").drop(columns=["q", "target"], errors="ignore")
    recorded = {name: numeric[name].to_numpy() for name in numeric if np.isfinite(numeric[name]).all()}
    return calibration.predict(q, **{**recorded, **columns})


def lines_on_measured_ranges(calibration: Calibration, q: Array) -> list[str]:
    """Return one line if poses lie clearly outside the joint positions that were measured: how many, and at which joints; else none.

    Args:
        calibration: Which states the ranges over its poses, unless an earlier release has written it.
        q: ``(N, n)`` [rad; m of a joint that slides].
    """
    import numpy as np

    from scalar.estimation.measured_ranges import clearly_outside, measured_ranges

    ranges = measured_ranges(calibration.summary)
    if ranges is None:
        return []
    outside = clearly_outside(ranges, q)
    n_poses = int(outside.any(axis=1).sum())
    if not n_poses:
        return []
    by_joint = outside.sum(axis=0)
    joints = []
    for j in [int(j) for j in np.argsort(-by_joint, kind="stable") if by_joint[j]][:_MOST_JOINTS]:
        unit, size = unit_of_joint(j in calibration.model.robot.prismatic)
        (low, high), here = ranges[j] / size, q[:, j] / size
        joints.append(
            f"joint {j + 1} was measured from {low:.0f} to {high:.0f} {unit} and goes from {here.min():.0f} to {here.max():.0f} {unit}"
        )
    has_effects = bool(calibration.model.effects)
    what = "what was found there may not hold here" if has_effects else "a gear error here could not be seen"
    lie = "1 pose lies" if n_poses == 1 else f"{n_poses} poses lie"
    return [
        f"  {lie} clearly outside the ranges of the joints that were measured ({'; '.join(joints)}): no measurement shows how far the arm errs, "
        f"and {what}; measure poses there too"
    ]
