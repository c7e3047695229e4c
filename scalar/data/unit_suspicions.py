"""Numbers that are valid but implausible, because their unit is probably wrong: degrees for radians, millimetres for metres.

The limits are magnitudes that no real workcell reaches in SI and that the same workcell passes by far in degrees or
millimetres. They leave room for large arms (4 m of reach), trackers far away, lidars, wrists that turn
several times, and axes that turn without end where their limits say so.
"""

import numpy as np

from scalar.data.description import DESCRIPTION, Description, KeyPath
from scalar.data.located_table import Table
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
MAX_POINT_NOISE = (
    5e-3  # m; one standard deviation of a single point: trackers and probes have 1e-5 to 1e-4, cameras 1e-3
)
MAX_NORMAL_STD = 0.5  # rad; one standard deviation of a direction
LEAST_MARKED_SCANS = 3  # with a number that may stand for "no value"; in fewer, it may be a coincidence
DISTINCT = 0.2  # least share of distinct numbers in a column of which one may be such a mark
FAR_MARK = 0.1  # least distance of such a number from all others of its column, as a share of their range
GRAVITY = (1.0, 20.0)  # m/s^2

_AS_METRES = "are these millimetres? write metres"
_AS_RADIANS = "are these degrees? write radians"


def suspect_description(description: Description) -> None:
    """Add numbers of dataset.yaml that look like other units to ``description.faults``."""
    _suspect_joints(description)
    limits = {"base": MAX_BASE, "flange": MAX_TOOL}
    transforms = [(("robot", key), limit) for key, limit in limits.items()]
    for path, limit in [*transforms, (("sensor", "nominal_pose"), MAX_TOOL)]:
        _suspect_transform(description, path, limit)
    gravity = description.vector("robot", "gravity")
    if gravity is not None and not GRAVITY[0] <= (size := float(np.linalg.norm(gravity))) <= GRAVITY[1]:
        message = f"suspect: gravity of {size:g} m/s^2; write about 9.81 m/s^2, downwards in the base frame"
        description.fault(("robot", "gravity"), message)
    noise = description.number("sensor", "noise")
    scans = description.sensor_format is not None and description.sensor_format.scans
    if noise is not None and noise >= (MAX_NOISE if scans else MAX_POINT_NOISE):
        message = f"suspect: a noise of {noise:g} m is {noise / MM:g} mm; {_AS_METRES}, as in 1.0e-4"
        description.fault(("sensor", "noise"), message)
    base = description.vector("robot", "base", "translation")
    far = MAX_PLANE + (0.0 if base is None else float(np.linalg.norm(base)))
    for i in range(len(description.items("planes"))):
        distance = description.number("planes", i, "distance")
        if distance is not None and abs(distance) > far:
            description.fault(("planes", i, "distance"), f"suspect: a plane at {distance:g} m; {_AS_METRES}")
        normal_std = description.number("planes", i, "known", "normal_std")
        if normal_std is not None and normal_std > MAX_NORMAL_STD:
            message = f"suspect: a normal known to {normal_std:g} rad; {_AS_RADIANS}"
            description.fault(("planes", i, "known", "normal_std"), message)


def _suspect_joints(description: Description) -> None:
    joints = range(description.n_joints)
    lengths = []
    for i in joints:
        path: KeyPath = ("robot", "joints", i)
        for key in ("alpha", "theta", "beta"):
            angle = description.number(*path, key)
            if angle is not None and abs(angle) > MAX_ANGLE_PARAMETER:
                description.fault((*path, key), f"suspect: {angle:g} rad is more than a turn; {_AS_RADIANS}")
        for key in ("a", "d"):
            length = description.number(*path, key) or 0.0
            lengths.append(abs(length))
            if abs(length) > MAX_LINK:
                description.fault((*path, key), f"suspect: a link of {length:g} m; {_AS_METRES}")
    if sum(lengths) > MAX_CHAIN and not max(lengths) > MAX_LINK:
        message = f"suspect: the links add up to {sum(lengths):g} m; {_AS_METRES}"
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
                ("robot", "joints", i, "limits"), f"suspect: a travel of {size:g} m; {_AS_METRES}"
            )
    wide = {i for i, angle in largest.items() if angle > SEVERAL_TURNS}
    # A single axis may turn without end; its limits are suspect if they look like whole degrees.
    if not _several(len(wide), len(joints)):
        wide = {i for i in wide if largest[i] > MANY_TURNS and largest[i] == round(largest[i])}
    for i in sorted(wide):
        message = f"suspect: limits of {largest[i]:g} rad are {largest[i] / TURN:.1f} turns; {_AS_RADIANS}"
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


def _suspect_transform(description: Description, path: KeyPath, limit: float) -> None:
    translation = description.vector(*path, "translation")
    if translation is not None and (size := float(np.linalg.norm(translation))) > limit:
        description.fault((*path, "translation"), f"suspect: a length of {size:g} m; {_AS_METRES}")
    rotation = description.vector(*path, "rotation_vector")
    if rotation is not None and (size := float(np.linalg.norm(rotation))) > MAX_ANGLE_PARAMETER:
        message = f"suspect: a rotation by {size:g} rad is more than a turn; {_AS_RADIANS}"
        description.fault((*path, "rotation_vector"), message)


def _several(n: int, n_joints: int) -> bool:
    """Return whether n joints are too many for all of them to be external axes or wrists that turn several times."""
    return n >= 2 and 3 * n >= n_joints


def suspect_joint_angles(poses: Table, description: Description, faults: list[Fault]) -> None:
    """Add joint angles that look like degrees: one joint far beyond its limits, or several beyond 1.5 turns; and travels in millimetres.

    Each such joint gives one fault, with its largest angle and the number of its angles out of bounds.
    """
    bounds, wide = {}, []
    for i in range(description.n_joints):
        name = f"q{i + 1}"
        if name not in poses.columns or not poses.n_rows:
            continue
        limits = description.vector("robot", "joints", i, "limits", size=2)
        if description.slides(i):
            _suspect_travel(poses, name, limits, faults)
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
                f"{beyond} of {poses.n_rows} angles are beyond {bound:.1f} rad; {_AS_RADIANS}, or, if it "
                f"really turns so far, give its limits in {DESCRIPTION}"
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
        unit, hint = ("m", _AS_METRES) if slides[j] else ("rad", _AS_RADIANS)
        message = f"suspect: {q[worst[j], j]:g} {unit}, and the limits of joint {j + 1} are {limits[j, 0]:g} and {limits[j, 1]:g} {unit}; {hint}"
        faults.append(Fault("poses", message, None, f"q{j + 1}"))
    if faults:
        raise InvalidInput(faults)


def _suspect_travel(poses: Table, name: str, limits: np.ndarray | None, faults: list[Fault]) -> None:
    """Add the travels of a prismatic joint that look like millimetres: one fault, with the largest travel."""
    bound = MAX_TRAVEL if limits is None else TRAVEL_OVER_LIMIT * float(np.abs(limits).max())
    beyond, worst, value = _beyond(poses.columns[name], bound)
    if beyond:
        message = (
            f"suspect: a travel of {value:g} m, and {beyond} of {poses.n_rows} are beyond {bound:g} m; {_AS_METRES}, or, "
            f"if it really goes so far, give its limits in {DESCRIPTION}"
        )
        faults.append(Fault(poses.file, message, int(poses.line_numbers()[worst]), name))


def suspect_points(points: Table, layout: MeasuredTable, faults: list[Fault]) -> None:
    """Add a fault for each column of points that looks like millimetres or degrees, or that holds a scanner's mark for "no value"."""
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
            message = (
                f"suspect: {value:g} {unit}, and {beyond} of {points.n_rows} numbers are "
                f"beyond {limit:.4g} {unit}; {_AS_METRES if unit == 'm' else _AS_RADIANS}, or remove the points"
            )
            faults.append(Fault(points.file, message, int(points.line_numbers()[worst]), name))
    if layout.several_rows and layout.item is None and points.good("pose"):
        _suspect_marks(points, layout, faults)


def _suspect_marks(points: Table, layout: MeasuredTable, faults: list[Fault]) -> None:
    """Add a fault for each column of scans with a number that stands for "no value".

    Scanners write such a mark, 0 or -99.9999 for example, for points that they did not see. All such points of a scan lie on one line, so that a fit
    cannot distinguish them from a second surface.
    """
    pose = points.columns["pose"]
    for name, unit in layout.units.items():
        if unit != "m" or name not in points.columns:
            continue
        values = _finite(points.columns[name])
        for extreme in dict.fromkeys((float(values.min()), float(values.max()))):
            marked = values == extreme
            if _is_mark(extreme, values[~marked], pose[marked], pose[~marked]):
                message = (
                    f"suspect: {extreme:g} {unit} stands in {marked.sum()} points of {len(np.unique(pose[marked]))} scans, far from all others: "
                    "a scanner's mark for 'no value'? Leave these points out"
                )
                row = int(points.line_numbers()[np.argmax(marked)])
                faults.append(Fault(points.file, message, row, name))


def _is_mark(number: float, others: np.ndarray, pose: np.ndarray, pose_of_others: np.ndarray) -> bool:
    """Return whether a number stands for "no value": it is far from all others, and occurs in several scans, which hold more other numbers.

    Args:
        number: The least or the largest number of a column.
        others: ``(M,)``, the numbers of the column that differ from it.
        pose: The poses at which the number stands, once for each time.
        pose_of_others: ``(M,)``, the poses of the others.
    """
    scans = np.unique(pose)
    if len(scans) < LEAST_MARKED_SCANS or not len(others):
        return False
    in_these = pose_of_others[np.isin(pose_of_others, scans)]
    if len(pose) >= len(in_these) or len(np.unique(in_these)) < len(scans):
        return False
    if np.min(np.abs(others - number)) <= FAR_MARK * np.ptp(others):
        return False
    # Where all numbers repeat, the rays are at the same places in every scan.
    return len(np.unique(others)) >= DISTINCT * len(others)


def _beyond(values: np.ndarray, bound: float) -> tuple[int, int, float]:
    """Return how many of a column's numbers are larger than a bound, the index of the largest, and that number with its sign."""
    sizes = np.abs(_finite(values))
    worst = int(np.argmax(sizes))
    return int(np.count_nonzero(sizes > bound)), worst, float(values[worst])


def _finite(values: np.ndarray) -> np.ndarray:
    """Return the values with 0 in place of those that are not finite and reported as such already."""
    return np.where(np.isfinite(values), values, 0.0)
