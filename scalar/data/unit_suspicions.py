"""Numbers that are valid but implausible, because their unit is probably wrong: degrees for radians, millimetres for metres.

The limits are magnitudes that no real workcell reaches in SI and that the same workcell passes by far in degrees or
millimetres. They leave room for large arms (4 m of reach), trackers far away, lidars, wrists that turn
several times, and axes that turn without end where their limits say so.
"""

from collections.abc import Callable

import numpy as np

from scalar.data.description import DESCRIPTION, Description, KeyPath
from scalar.data.located_table import Table
from scalar.data.scanner_marks import mark_beyond, suspect_marks, suspect_origins
from scalar.data.sensor_formats import MeasuredTable
from scalar.errors import Fault, InvalidInput
from scalar.geometry.robot import DEFAULT_LIMIT
from scalar.units import MM

TURN = 2.0 * np.pi

MAX_ANGLE_PARAMETER = TURN + 0.01  # rad; alpha, theta, beta and rotation vectors need no more than a turn
MANY_TURNS = 4.0 * TURN  # rad; one joint on its own, where its limits do not say that it turns further
SEVERAL_TURNS = 1.5 * TURN  # rad; several joints at once; real wrists reach 1.25 turns (450 degrees)
MAX_TRAVEL = 100.0  # m; a prismatic joint, where its limits do not say that it goes farther
TRAVEL_OVER_LIMIT = 20.0  # a travel more than this many times the largest limit is taken for millimetres
MAX_LINK = 8.0  # m; a single a or d
MIN_CHAIN = 0.05  # m; all a and d together, of an arm whose joints all turn
MAX_CHAIN = 20.0  # m; all a and d together
MAX_BASE = 200.0  # m; the base's transform, in the coordinates of a factory hall
MAX_TOOL = 5.0  # m; the flange's transform, and that of the sensor on the flange
MAX_PLANE = 50.0  # m; distance of a plane from the robot
MAX_NOISE = 0.05  # m; one standard deviation of a point of a scan: lidars have 0.01 to 0.03
# Largest plausible standard deviation of a single point [m]: trackers and probes have 1e-5 to 1e-4, cameras 1e-3 to 8e-3.
MAX_POINT_NOISE = 1e-2
MAX_NORMAL_STD = 0.5  # rad; one standard deviation of a direction
UNIT_DOUBTS = ("are these millimetres?", "are these degrees?")
"""What messages ask where metres or radians are expected."""
GIVE_LIMITS = f"give its limits in {DESCRIPTION}"
GRAVITY = (1.0, 20.0)  # m/s^2


def write_si(unit: str) -> str:
    """Return what to do where a number looks like millimetres and should be metres (``m``), or like degrees and should be radians (``rad``)."""
    millimetres, degrees = UNIT_DOUBTS
    return f"{millimetres} write metres" if unit == "m" else f"{degrees} write radians"


def suspect_description(description: Description, advice: Callable[[str], str] = write_si) -> None:
    """Add numbers of dataset.yaml that look like other units to ``description.faults``.

    Args:
        description: The description.
        advice: What to do, by the unit that is expected; a mapping states units of its own.
    """
    as_metres, as_radians = advice("m"), advice("rad")
    _suspect_joints(description, as_metres, as_radians)
    limits = {"base": MAX_BASE, "flange": MAX_TOOL}
    transforms = [(("robot", key), limit) for key, limit in limits.items()]
    for path, limit in [*transforms, (("sensor", "nominal_pose"), MAX_TOOL)]:
        _suspect_transform(description, path, limit, as_metres, as_radians)
    gravity = description.vector("robot", "gravity")
    if gravity is not None and not GRAVITY[0] <= (size := float(np.linalg.norm(gravity))) <= GRAVITY[1]:
        message = f"suspect: gravity of {size:g} m/s^2; write about 9.81 m/s^2, downwards in the base frame"
        description.fault(("robot", "gravity"), message)
    noise = description.number("sensor", "noise")
    scans = description.sensor_format is not None and description.sensor_format.scans
    if noise is not None and noise >= (MAX_NOISE if scans else MAX_POINT_NOISE):
        message = f"suspect: a noise of {noise:g} m is {noise / MM:g} mm; {as_metres}, as in 1.0e-4"
        description.fault(("sensor", "noise"), message)
    base = description.vector("robot", "base", "translation")
    far = MAX_PLANE + (0.0 if base is None else float(np.linalg.norm(base)))
    for i in range(len(description.items("planes"))):
        distance = description.number("planes", i, "distance")
        if distance is not None and abs(distance) > far:
            description.fault(("planes", i, "distance"), f"suspect: a plane at {distance:g} m; {as_metres}")
        normal_std = description.number("planes", i, "known", "normal_std")
        if normal_std is not None and normal_std > MAX_NORMAL_STD:
            message = f"suspect: a normal known to {normal_std:g} rad; {as_radians}"
            description.fault(("planes", i, "known", "normal_std"), message)


def _suspect_joints(description: Description, as_metres: str, as_radians: str) -> None:
    joints = range(description.n_joints)
    lengths = []
    for i in joints:
        path: KeyPath = ("robot", "joints", i)
        for key in ("alpha", "theta", "beta"):
            angle = description.number(*path, key)
            if angle is not None and abs(angle) > MAX_ANGLE_PARAMETER:
                description.fault((*path, key), f"suspect: {angle:g} rad is more than a turn; {as_radians}")
        for key in ("a", "d"):
            length = description.number(*path, key) or 0.0
            lengths.append(abs(length))
            if abs(length) > MAX_LINK:
                description.fault((*path, key), f"suspect: a link of {length:g} m; {as_metres}")
    if sum(lengths) > MAX_CHAIN and not max(lengths) > MAX_LINK:
        message = f"suspect: the links add up to {sum(lengths):g} m; {as_metres}"
        description.fault(("robot", "joints"), message)
    _suspect_short(description, sum(lengths))
    largest = {}
    for i in joints:
        limits = description.vector("robot", "joints", i, "limits", size=2)
        if limits is None:
            continue
        size = float(np.abs(limits).max())
        if not description.slides(i):
            largest[i] = size
        elif size > MAX_TRAVEL:
            description.fault(
                ("robot", "joints", i, "limits"), f"suspect: a travel of {size:g} m; {as_metres}"
            )
    wide = {i for i, angle in largest.items() if angle > SEVERAL_TURNS}
    # A single axis may turn without end; its limits are suspect if they look like whole degrees.
    if not _several(len(wide), len(joints)):
        wide = {i for i in wide if largest[i] > MANY_TURNS and largest[i] == round(largest[i])}
    for i in sorted(wide):
        message = f"suspect: limits of {largest[i]:g} rad are {largest[i] / TURN:.1f} turns; {as_radians}"
        description.fault(("robot", "joints", i, "limits"), message)


def _suspect_short(description: Description, chain: float) -> None:
    """Add a fault if the arm is too short, as when metres were taken for millimetres.

    The flange's transform counts as reach. An arm with a prismatic joint is not checked, since its travel is reach as well.
    """
    flange = description.vector("robot", "flange", "translation")
    reach = chain + (0.0 if flange is None else float(np.linalg.norm(flange)))
    if 0.0 < chain and reach < MIN_CHAIN and not any(map(description.slides, range(description.n_joints))):
        message = (
            f"suspect: the links add up to {chain:g} m; were metres taken for millimetres? In metres the arm would have {chain / MM:g} m; "
            "write metres"
        )
        description.fault(("robot", "joints"), message)


def _suspect_transform(
    description: Description, path: KeyPath, limit: float, as_metres: str, as_radians: str
) -> None:
    translation = description.vector(*path, "translation")
    if translation is not None and (size := float(np.linalg.norm(translation))) > limit:
        description.fault((*path, "translation"), f"suspect: a length of {size:g} m; {as_metres}")
    rotation = description.vector(*path, "rotation_vector")
    if rotation is not None and (size := float(np.linalg.norm(rotation))) > MAX_ANGLE_PARAMETER:
        message = f"suspect: a rotation by {size:g} rad is more than a turn; {as_radians}"
        description.fault((*path, "rotation_vector"), message)


def _several(n: int, n_joints: int) -> bool:
    """Return whether n joints are too many for all of them to be external axes or wrists that turn several times."""
    return n >= 2 and 3 * n >= n_joints


def suspect_joint_angles(
    poses: Table,
    description: Description,
    faults: list[Fault],
    advice: Callable[[str, str], str] = lambda unit, _: write_si(unit),
    give_limits: str = GIVE_LIMITS,
) -> None:
    """Add joint angles that look like degrees: one joint far beyond its limits, or several beyond 1.5 turns; and travels in millimetres.

    Each such joint gives one fault, with its largest angle and the number of its angles out of bounds.

    Args:
        poses: The table of poses.
        description: The description, with the joints' limits.
        faults: What is found is added here.
        advice: What to do, by the unit that is expected and the column.
        give_limits: What to do if a joint really goes so far.
    """
    bounds, wide = {}, []
    for i in range(description.n_joints):
        name = f"q{i + 1}"
        if name not in poses.columns or not poses.n_rows:
            continue
        limits = description.vector("robot", "joints", i, "limits", size=2)
        if description.slides(i):
            _suspect_travel(
                poses,
                name,
                limits,
                faults,
                f"{advice('m', name)}, or, if it really goes so far, {give_limits}",
            )
            continue
        declared = 0.0 if limits is None else 1.01 * float(np.abs(limits).max())
        bounds[name] = max(MANY_TURNS, declared)
        if np.nanmax(np.abs(_finite(poses.columns[name])), initial=0.0) > max(SEVERAL_TURNS, declared):
            wide.append(name)
    several = _several(len(wide), description.n_joints)
    for name, bound in bounds.items():
        bound = SEVERAL_TURNS if several and name in wide else bound
        beyond, worst, value = _beyond(poses.columns[name], bound)
        if beyond:
            message = (
                f"suspect: {value:g} rad is {abs(value) / TURN:.1f} turns, and "
                f"{beyond} of {poses.n_rows} angles{_in_rows(poses, name, bound)} are beyond {bound:.1f} rad; {advice('rad', name)} (grads, of which "
                f"400 are a turn, look alike), or, if it really turns so far, {give_limits}"
            )
            faults.append(Fault(poses.file, message, int(poses.line_numbers()[worst]), name))


def refuse_degrees(q: np.ndarray, limits: np.ndarray, slides: np.ndarray) -> None:
    """Refuse joint positions in an array that can hardly be radians (or metres), like ``suspect_joint_angles`` those in a table.

    An angle that exceeds both limits of its joint by more than a turn cannot be reached. For joints without stated limits, the bounds for
    tables apply. Small angles in degrees are not noticed.

    Args:
        q: ``(N, n)``, joint positions.
        limits: ``(n, 2)`` [rad; m where a joint slides]; a half turn to both sides where none are stated.
        slides: ``(n,)`` bool.

    Raises:
        InvalidInput: One fault for each joint.
    """
    farthest = np.abs(limits).max(axis=1)
    largest = np.abs(q).max(axis=0, initial=0.0)
    stated = np.abs(farthest - DEFAULT_LIMIT) > 1e-9
    wide = ~slides & ~stated & (largest > SEVERAL_TURNS)
    unstated = SEVERAL_TURNS if _several(int(wide.sum()), len(wide)) else MANY_TURNS
    bounds = np.where(slides, TRAVEL_OVER_LIMIT * farthest, np.where(stated, farthest + TURN, unstated))
    worst = np.argmax(np.abs(q), axis=0) if len(q) else np.zeros(q.shape[1], dtype=int)
    faults = []
    for j in np.flatnonzero(largest > bounds):
        unit = "m" if slides[j] else "rad"
        range_ = f"the limits of joint {j + 1} are {limits[j, 0]:g} and {limits[j, 1]:g} {unit}"
        message = f"suspect: {q[worst[j], j]:g} {unit}, and {range_}; {write_si(unit)}"
        faults.append(Fault("poses", message, None, f"q{j + 1}"))
    if faults:
        raise InvalidInput(faults)


def _suspect_travel(
    poses: Table, name: str, limits: np.ndarray | None, faults: list[Fault], remedy: str
) -> None:
    """Add the travels of a prismatic joint that look like millimetres: one fault, with the largest travel."""
    bound = MAX_TRAVEL if limits is None else TRAVEL_OVER_LIMIT * float(np.abs(limits).max())
    beyond, worst, value = _beyond(poses.columns[name], bound)
    if beyond:
        message = f"suspect: a travel of {value:g} m, and {beyond} of {poses.n_rows} are beyond {bound:g} m; {remedy}"
        faults.append(Fault(poses.file, message, int(poses.line_numbers()[worst]), name))


def suspect_points(
    points: Table,
    layout: MeasuredTable,
    faults: list[Fault],
    advice: Callable[[str, str], str] = lambda unit, _: write_si(unit),
) -> None:
    """Add a fault for each column of points that looks like millimetres or degrees, or that holds a scanner's mark for "no value".

    A fault is added as well if a tracker wrote zeros in place of measurements (``suspect_origins``).

    Args:
        points: The table of points.
        layout: Its columns, with their units.
        faults: What is found is added here.
        advice: What to do, by the unit that is expected and the column.
    """
    if not points.n_rows:
        return
    for name, unit in (*layout.units.items(), *layout.optional.items()):
        if name not in points.columns:
            continue
        if name in layout.noises:
            limit = MAX_POINT_NOISE if unit == "m" else MAX_NORMAL_STD
        else:
            limit = layout.largest if unit == "m" else MAX_ANGLE_PARAMETER
        beyond, worst, value = _beyond(points.columns[name], limit)
        if beyond:
            message = mark_beyond(_finite(points.columns[name]), unit, limit) if layout.several_rows else ""
            message = message or (
                f"suspect: {value:g} {unit}, and {beyond} of {points.n_rows} numbers{_in_rows(points, name, limit)} are "
                f"beyond {limit:.4g} {unit}; {advice(unit, name)}, or remove the points"
            )
            faults.append(Fault(points.file, message, int(points.line_numbers()[worst]), name))
    if layout.several_rows and layout.item is None and points.good("pose"):
        suspect_marks(points, layout, faults)
    elif not layout.several_rows:
        suspect_origins(points, layout, faults)


def _beyond(values: np.ndarray, bound: float) -> tuple[int, int, float]:
    """Return how many of a column's numbers are larger than a bound, the index of the largest, and that number with its sign."""
    sizes = np.abs(_finite(values))
    worst = int(np.argmax(sizes))
    return int(np.count_nonzero(sizes > bound)), worst, float(values[worst])


def _in_rows(table: Table, name: str, bound: float) -> str:
    """Return where the numbers of a column that are larger than a bound begin and end, as where its unit changes; empty if all are, or one is."""
    rows = table.line_numbers()[np.abs(_finite(table.columns[name])) > bound]
    return "" if not 1 < len(rows) < table.n_rows else f", in rows {min(rows)} to {max(rows)},"


def _finite(values: np.ndarray) -> np.ndarray:
    """Return the values with 0 in place of those that are not finite and reported as such already."""
    return np.where(np.isfinite(values), values, 0.0)
