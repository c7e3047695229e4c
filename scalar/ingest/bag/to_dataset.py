"""Make a dataset of a recording: one pose for each moment at which the arm stands still and the scan clearly lies on one target plane."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from scalar.data.dataset_writer import write_dataset
from scalar.data.declared import PlaneGuess
from scalar.data.description import DESCRIPTION, NO_MORE_PLANES, Description, check_description, least_planes
from scalar.data.formats import FEW_PLANES
from scalar.data.io.plain_yaml import load_yaml_lines
from scalar.data.located_table import did_you_mean, shorten
from scalar.data.unit_suspicions import suspect_description
from scalar.errors import Fault, InvalidInput, Undetermined
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import Array, transform_from_rotation_vector
from scalar.ingest.bag.better_reading import better_reading
from scalar.ingest.bag.losses import LEAST_KEPT, StopCounts
from scalar.ingest.bag.messages import Recording
from scalar.ingest.bag.pieces import straight_piece
from scalar.ingest.bag.stops import Stop, find_stops
from scalar.ingest.bag.straight_scans import Pieces
from scalar.units import DEG

TOLERANCE = 1.5e-3
"""[m] Most by which a point of a straight piece may be off its line, unless ``SIGMAS`` allows more."""
SIGMAS = 5.0
"""The same in standard deviations of the stated noise."""
_SEED = 0
# [m] Scanners of profiles measure over a few metres at most, and hardly any nearer than 20 mm.
_FARTHEST = 20.0
_SEVERAL = 2  # joints: a single one may well turn endlessly
# Radians of joints within a turn are no larger than this; an arm that is calibrated has larger positions in degrees.
_A_TURN = 2.0 * np.pi
_TWO_TURNS = 4 * np.pi  # rad; hardly a joint turns further to one side


@dataclass(frozen=True)
class BagSettings:
    """How a recording is cut.

    Attributes:
        joint_names: Names of the recorded joints in the order of the robot's. If empty, those in dataset.yaml, or else the recorded order.
        still: Most by which a joint that stands still may move [rad, m].
        settled: Time from the last motion until the arm counts as settled [s].
        least_time: Least time for which it then stands still [s].
        accept_losses: Whether a dataset is written even if most stops become no poses, or another reading explains the recording far better.
        force: Whether a dataset at the output is replaced, whoever wrote it.
        degrees: Whether the positions of joints that turn were recorded in degrees.
    """

    joint_names: tuple[str, ...]
    still: float
    settled: float
    least_time: float
    accept_losses: bool = False
    force: bool = False
    degrees: bool = False


def load_workcell(path: Path) -> dict[str, Any]:
    """Return the content of the dataset.yaml, given by its path or its folder, that describes the workcell of a recording.

    Raises:
        InvalidInput: The file has faults, its sensor does not scan planes, or it does not state the sensor's nominal pose.
    """
    path = path / DESCRIPTION if path.is_dir() else path
    content, lines = load_yaml_lines(path)
    description = Description(content, lines, path.name)
    check_description(description)
    suspect_description(description)
    format = description.sensor_format
    if format is not None and not (format.on_planes and format.table is not None):
        description.fault(
            ("sensor", "kind"), "a recording of scans needs a sensor that scans planes: line-laser"
        )
    elif format is not None and description.get("sensor", "nominal_pose") is None:
        message = (
            "missing; where the scanner is, roughly, tells on which plane a scan lies: write it under sensor: as "
            "nominal_pose: {translation: [0.0, 0.0, 0.1], rotation_vector: [0.0, 0.0, 0.0]}, flange to sensor [m, rad]"
        )
        description.fault(("sensor", "nominal_pose"), message)
    if description.faults:
        raise InvalidInput(description.faults)
    return content


def write_recorded_dataset(
    recording: Recording,
    workcell: dict[str, Any],
    settings: BagSettings,
    target: str | os.PathLike[str],
    told: Callable[[int, int], None] = lambda done, total: None,
) -> StopCounts:
    """Write the dataset of a recording, which appears whole or not at all, and return how many stops became poses.

    Args:
        recording: What was recorded.
        workcell: The content of dataset.yaml, as ``load_workcell`` returns it.
        settings: How the recording is cut.
        target: The folder to write; a dataset there is replaced if SCALAR wrote it and nobody changed it since, or by ``settings.force``.
        told: Takes how many other readings of the set-up were tried, and how many there are.

    Raises:
        InvalidInput: The recorded joints are not those of the robot, or the scans are in millimetres.
        Undetermined: The arm never stands still, fewer than three planes are seen, or ``accept_losses`` is not set and most stops become no poses or
            another reading of the set-up explains the recording far better.
    """
    robot = Robot.from_mapping(workcell["robot"])
    order, names = _joint_order(recording, workcell["robot"]["joints"], settings.joint_names)
    stops = find_stops(
        recording.joint_times,
        _in_radians(recording, recording.positions[:, order], robot.slides, settings.degrees),
        settings.still,
        settings.settled,
        settings.least_time,
    )
    if not stops:
        seconds = recording.joint_times[-1] - recording.joint_times[0]
        raise Undetermined(
            f"the arm never stands still for {settings.settled + settings.least_time:g} s in the {seconds:.1f} s of {recording.joint_topic}, "
            f"all joints within {settings.still:g} rad (m): record a stop of a second at every pose, or allow more with --still"
        )
    chosen = [(stop, scan) for stop in stops if (scan := _scan_of(recording, stop)) is not None]
    _refuse_millimetres(recording, [points for _, (_, points) in chosen])
    noise = float(workcell["sensor"].get("noise") or 0.0)
    rng = np.random.default_rng(_SEED)
    pieces = [
        (m, t, points[straight_piece(points, max(TOLERANCE, SIGMAS * noise), rng)])
        for m, (t, points) in chosen
    ]
    pieces = [piece for piece in pieces if len(piece[2])]
    planes = [PlaneGuess.from_mapping(plane) for plane in workcell["planes"]]
    found = _pieces(robot, workcell["sensor"]["nominal_pose"], planes, pieces)
    index = found.plane_index()
    kept = np.flatnonzero(index >= 0)
    counts = StopCounts(
        len(stops), len(stops) - len(chosen), len(chosen) - len(pieces), len(pieces) - len(kept), names
    )
    _refuse(found, counts, settings, least_planes(workcell.get(FEW_PLANES)), told)
    poses, scans = _tables([pieces[i] for i in kept], [planes[k].name for k in index[kept]])
    write_dataset(target, mapping=workcell, poses=poses, scans=scans, force=settings.force)
    return counts


def _refuse(
    found: Pieces,
    counts: StopCounts,
    settings: BagSettings,
    least_planes: int,
    told: Callable[[int, int], None],
) -> None:
    """Refuse a recording of which too few stops become poses, or that fits another reading of the set-up far better."""
    index = found.plane_index()
    seen = [name for k, name in enumerate(found.plane_names) if k in index]
    few = len(seen) < least_planes
    if settings.accept_losses and not few:
        return
    better = better_reading(found, counts.joint_names, told)
    anyway = "; --accept-losses writes the dataset all the same"
    if few:
        on = f"only {' and '.join(seen)} {'is' if len(seen) == 1 else 'are'}" if seen else "no plane is"
        said = counts.sentence(
            f", and {on} seen of the three that are needed{NO_MORE_PLANES if seen else ''}"
        )
    elif counts.kept < LEAST_KEPT * counts.still:
        said = counts.sentence() + anyway
    elif better:
        said = better.as_described + anyway
    else:
        return
    raise Undetermined([said, *(better.sentences if better else ())])


def _joint_order(
    recording: Recording, joints: Sequence[dict[str, Any]], wanted: Sequence[str]
) -> tuple[list[int], tuple[str, ...]]:
    """Return which of the recorded joints become q1..qn, and their names."""
    recorded, n = recording.joint_names, len(joints)
    own = [str(joint["name"]) for joint in joints if "name" in joint]
    names = list(wanted) or (own if len(own) == n else list(recorded))
    where = "--joint-names" if wanted else "robot.joints"
    if len(names) != n:
        message = f"{len(names)} joints ({', '.join(names)}), and the robot has {n}; name those of the robot in their order with --joint-names"
        raise InvalidInput(Fault(where if wanted else recording.joint_topic, message))
    for name in names:
        if recorded.count(name) != 1:
            hint = did_you_mean(name, list(recorded))
            message = f"no joint {shorten(name)} on topic {recording.joint_topic}; {hint}it has {', '.join(recorded)}"
            raise InvalidInput(Fault(where, message))
    return [recorded.index(name) for name in names], tuple(names)


def _in_radians(recording: Recording, positions: Array, slides: Array, degrees: bool) -> Array:
    """Return joint positions ``(J, n)`` [rad; m of a joint that slides]; ``degrees`` says whether those of joints that turn are in degrees.

    Raises:
        InvalidInput: They are not said to be in degrees, and several joints would turn more than twice to one side; or they are, and no joint
            would turn by more than a few degrees.
    """
    if degrees:
        largest = float(np.abs(positions[:, ~np.asarray(slides)]).max(initial=0.0))
        if 0.0 < largest <= _A_TURN:
            message = (
                f"no joint position is larger than {largest:.3g}: as radians these are angles of an arm that moves, and as degrees it hardly moves; "
                "leave out --degrees, since JointState states radians"
            )
            raise InvalidInput(Fault(recording.joint_topic, message))
        return np.where(slides, positions, positions * DEG)
    turning = np.abs(positions[:, ~np.asarray(slides)]).max(axis=0, initial=0.0)
    if np.count_nonzero(turning > _TWO_TURNS) >= min(_SEVERAL, len(turning)) > 0:
        message = (
            f"joint positions of up to {turning.max():.4g} rad are more than two turns, and JointState states radians; say --degrees if these are "
            "degrees"
        )
        raise InvalidInput(Fault(recording.joint_topic, message))
    return positions


def _refuse_millimetres(recording: Recording, scans: Sequence[Array]) -> None:
    """Refuse scans ``(M, 2)`` whose points lie farther away than any scanner of profiles measures.

    Raises:
        InvalidInput: Half of the points are more than ``_FARTHEST`` away.
    """
    distances = [np.linalg.norm(points, axis=1) for points in scans if len(points)]
    if distances and (typical := float(np.median(np.concatenate(distances)))) > _FARTHEST:
        message = (
            f"its points lie {typical:.0f} m from the scanner in the median: they are probably in millimetres, and messages of ROS have metres; "
            "record them in metres, or write the profiles as a table and read it with `scalar import`"
        )
        raise InvalidInput(Fault(recording.scan_topic, message))


def _scan_of(recording: Recording, stop: Stop) -> tuple[float, Array] | None:
    """Return time and points of the scan nearest to the middle of a stop; None if there is none between its start and end."""
    inside = np.flatnonzero((recording.scan_times >= stop.start) & (recording.scan_times <= stop.end))
    if not len(inside):
        return None
    middle = (stop.start + stop.end) / 2
    i = int(inside[np.argmin(np.abs(recording.scan_times[inside] - middle))])
    return float(recording.scan_times[i]), recording.scans[i]


def _pieces(
    robot: Robot,
    nominal_pose: dict[str, Any],
    planes: Sequence[PlaneGuess],
    pieces: Sequence[tuple[Stop, float, Array]],
) -> Pieces:
    none = [0.0, 0.0, 0.0]
    return Pieces(
        robot,
        transform_from_rotation_vector(
            nominal_pose.get("translation", none), nominal_pose.get("rotation_vector", none)
        ),
        np.array([stop.q for stop, _, _ in pieces]).reshape(-1, robot.n_joints),
        [points for _, _, points in pieces],
        np.array([plane.normal for plane in planes]),
        np.array([plane.distance for plane in planes]),
        [plane.name for plane in planes],
    )


def _tables(
    pieces: Sequence[tuple[Stop, float, Array]], planes: Sequence[str]
) -> tuple[pd.DataFrame, pd.DataFrame]:
    q = np.array([stop.q for stop, _, _ in pieces])
    times = np.array([time for _, time, _ in pieces])
    ids = np.arange(1, len(pieces) + 1)
    poses = pd.DataFrame({"pose": ids, "plane": list(planes)})
    for i in range(q.shape[1]):
        poses[f"q{i + 1}"] = q[:, i]
    poses["order"] = ids - 1
    poses["time"] = times - times[0]
    points = np.concatenate([points for _, _, points in pieces])
    owner = np.repeat(ids, [len(points) for _, _, points in pieces])
    return poses, pd.DataFrame({"pose": owner, "x": points[:, 0], "z": points[:, 1]})
